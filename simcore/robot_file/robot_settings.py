"""What `simcore.toml` can say of a robot: small frozen records in SI units, each already checked by the reader."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    FlywheelSim,
    RackConfig,
    RackSim,
    RollerConfig,
    RollerSim,
)
from simcore.robot.shaft import ShaftSim
from simcore.vision.camera import CameraConfig

__all__ = [
    "CONTROLLERS",
    "IntakeSettings",
    "MechanismSettings",
    "RobotSettings",
    "ShooterSettings",
]

CONTROLLERS = ("TalonFX", "TalonFXS")
"""What can drive a mechanism of the file; others are connected in a physics.py."""

MechanismConfig: TypeAlias = FlywheelConfig | RollerConfig | ArmConfig | ElevatorConfig | RackConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class MechanismSettings:
    """A mechanism and the devices that turn it."""

    name: str
    config: MechanismConfig
    """Gears, masses and stops; its type is the kind."""
    motor: str
    """One of `simcore.robot.dc_motor.MOTOR_NAMES`."""
    controller: str
    """One of `CONTROLLERS`."""
    leader: int
    """CAN id."""
    followers: tuple[int, ...] = ()
    """CAN ids."""
    opposed: tuple[int, ...] = ()
    """Those of the followers that are mounted face to face with the leader."""
    reversed: bool = False
    """Whether positive in robot code is negative for the mechanism."""
    cancoder: int | None = None
    """CAN id of an absolute encoder on it."""
    cancoder_gearing: float = 1.0
    """Turns of the CANcoder per turn of the mechanism [-]."""

    @property
    def devices(self) -> tuple[int, ...]:
        """Ids of all its motor controllers, leader first."""
        return (self.leader, *self.followers)

    def build(self) -> ShaftSim:
        """The mechanism at its start."""
        c = self.config
        if isinstance(c, FlywheelConfig):
            return FlywheelSim(c)
        if isinstance(c, RollerConfig):
            return RollerSim(c)
        if isinstance(c, ArmConfig):
            return ArmSim(c)
        if isinstance(c, ElevatorConfig):
            return ElevatorSim(c)
        return RackSim(c)


@dataclass(frozen=True, slots=True, kw_only=True)
class IntakeSettings:
    """Where pieces are taken in, and when. Lengths in the robot frame [m]."""

    x: tuple[float, float]
    y: tuple[float, float]
    z_max: float
    roller: str
    """Mechanism that must turn forward."""
    deploy: str | None = None
    """Mechanism that must be out; None for an intake that always is."""
    out_at: str = "upper"
    """At which of its stops the deploy is out: `upper` or `lower`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShooterSettings:
    """Where pieces leave, how fast, and when."""

    wheels: str
    """Mechanism whose speed makes the shot."""
    feeder: str | None = None
    """Mechanism that must turn forward; None: spinning wheels are enough."""
    hood: str | None = None
    """Mechanism that tilts the shot; None for a fixed one."""
    wheel_radius: float
    """[m]"""
    exit_efficiency: float
    """Speed of the piece over speed of the rim [-]."""
    height: float
    """Of the muzzle over the floor [m]."""
    forward: float
    """Of the muzzle ahead of the robot's center [m]."""
    yaw: float
    """Direction of the shot, counter-clockwise from ahead [rad]."""
    barrels: tuple[float, ...]
    """Places across, to the left [m]."""
    rate: float
    """Shot events a second [1/s]."""
    elevation: float
    """Over the horizontal, with the hood at angle zero [rad]."""
    elevation_per_hood: float
    """How the hood's angle counts: 1 or -1 [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSettings:
    """All of the file; the defaults are what a robot without a file gets."""

    mass: float = 55.0
    """With bumpers and battery [kg]."""
    bumper: tuple[float, float] | None = None
    """Length and width over the bumpers [m]; None: 15 cm beyond the wheels' centers."""
    center_of_mass_height: float = 0.2
    """[m]"""
    tread: float = 1.2
    """Friction of the wheels on carpet [-]."""
    drive_motor: str | None = None
    """None: what the drivetrain's constants say."""
    steer_motor: str | None = None
    start: tuple[float, float, float] = (2.0, 1.2, 0.0)
    """As a blue robot, field frame [m, m, rad]."""
    preload: int = 0
    """Pieces in the robot at the start."""
    capacity: int = 50
    """Pieces that it can hold."""
    mechanisms: tuple[MechanismSettings, ...] = ()
    intake: IntakeSettings | None = None
    shooter: ShooterSettings | None = None
    cameras: tuple[CameraConfig, ...] = ()

    def with_bumper_around(self, wheels: tuple[tuple[float, float], ...]) -> RobotSettings:
        """The same with bumpers, if it had none, 15 cm beyond the wheels' centers [m]."""
        if self.bumper is not None:
            return self
        # From a wheel's center to the outside of the bumpers: 2.6 in of module, 3.25 in of bumper.
        around = tuple(2.0 * (max(abs(w[axis]) for w in wheels) + 0.15) for axis in (0, 1))
        return replace(self, bumper=(around[0], around[1]))

    def mechanism(self, name: str) -> MechanismSettings:
        """One of the mechanisms; the reader has made sure that names exist."""
        return next(m for m in self.mechanisms if m.name == name)

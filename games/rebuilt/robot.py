"""A robot for REBUILT: swerve, over-the-bumper intake at the back, hopper, and a shooter with two barrels.

This is the plant: what motors, gears and masses do with volts. What it wants to do is somebody else's business: a
scripted auto, or a team's robot code.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from wpimath.system.plant import DCMotor

from simcore.errors import ConfigError, require_non_negative, require_positive
from simcore.physics.world import PhysicsWorld
from simcore.pieces.intake import IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.pieces.shooter import ShooterSim
from simcore.robot.battery import BatteryConfig
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.gyro import GyroConfig, gyro_config
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    FlywheelConfig,
    FlywheelSim,
    RackConfig,
    RackSim,
    RollerConfig,
    RollerSim,
    launch_impulse,
)
from simcore.robot.shaft import ShaftSim
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_robot import SwerveRobot
from simcore.units import degrees, plain_sum
from simcore.vision.camera import CameraConfig

__all__ = ["RebuiltRobot", "RebuiltRobotConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RebuiltRobotConfig:
    """What the robot is built of. Numbers without a source are a plausible robot's, chosen by us."""

    chassis: ChassisConfig = field(default_factory=ChassisConfig)
    module: SwerveModuleConfig = field(
        default_factory=lambda: SwerveModuleConfig(
            x=0.0,
            y=0.0,
            drive_stator_limit=60.0,
            drive_supply_limit=40.0,
            steer_stator_limit=40.0,
            steer_supply_limit=20.0,
        )
    )
    """Repeated at every wheel position of the chassis."""
    drivetrain: SwerveConfig | None = None
    """The drivetrain as a whole, e.g. from robot code's constants; None: `module` at every wheel of the chassis."""
    battery: BatteryConfig = field(default_factory=BatteryConfig)
    gyro: GyroConfig = field(default_factory=lambda: gyro_config("pigeon2"))
    hopper_capacity: int = 50
    shooter: FlywheelConfig = field(
        default_factory=lambda: FlywheelConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), motors=4, gearing=24 / 36, stator_current_limit=40.0),
            inertia=0.008,
        )
    )
    wheel_radius: float = 0.05
    """Of the shooter wheels [m]."""
    exit_efficiency: float = 0.49
    """Speed of the fuel over speed of the wheel's rim [-]: it rolls along a fixed hood, so about one half."""
    hood: ArmConfig = field(
        default_factory=lambda: ArmConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX44(1), gearing=90.0, stator_current_limit=30.0),
            inertia=0.05,
            mass=1.2,
            center_of_mass=0.12,
            min_angle=degrees(20.0),
            max_angle=degrees(65.0),
        )
    )
    feeder: RollerConfig = field(
        default_factory=lambda: RollerConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=2.0, stator_current_limit=60.0),
            inertia=0.002,
            radius=0.025,
        )
    )
    spindexer: RollerConfig = field(
        default_factory=lambda: RollerConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=5.0, stator_current_limit=60.0),
            inertia=0.02,
            radius=0.2,
        )
    )
    deploy: RackConfig = field(
        default_factory=lambda: RackConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=10.0, stator_current_limit=40.0),
            mass=4.0,
            pinion_radius=0.019,
            travel=0.28,
        )
    )
    roller: RollerConfig = field(
        default_factory=lambda: RollerConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=3.0, stator_current_limit=60.0),
            inertia=0.001,
            radius=0.025,
        )
    )
    intake: IntakeZone = field(
        default_factory=lambda: IntakeZone(x_min=-0.50, x_max=-0.35, y_min=-0.33, y_max=0.33, z_max=0.20)
    )
    """Where fuel is taken in while the rack is in its inner position; the rack moves x_min out. From the reference, but
    0.66 m wide, as over-the-bumper intakes of 2026 are, where the reference has 0.5 m."""
    launch: LaunchParameters = field(
        default_factory=lambda: LaunchParameters(height=0.55, forward=0.168, barrels=(0.08, -0.08))
    )
    """Two barrels, shooting ahead: the reference's places."""
    shot_rate: float = 8.0
    """Shot events a second, each with both barrels [1/s]."""
    cameras: tuple[CameraConfig, ...] = ()
    """Limelights; each name only once in a match."""

    def __post_init__(self) -> None:
        owner = "RebuiltRobotConfig"
        for name in ("wheel_radius", "exit_efficiency", "shot_rate"):
            require_positive(owner, name, getattr(self, name))
        require_non_negative(owner, "hopper_capacity", self.hopper_capacity)
        d, c = self.drivetrain, self.chassis
        if d is not None:
            if len(d.modules) != len(c.wheel_positions):
                raise ConfigError(
                    f"{owner}: drivetrain has {len(d.modules)} modules, but the chassis {len(c.wheel_positions)} wheels"
                )
            if not math.isclose(d.mass, c.mass):
                raise ConfigError(f"{owner}: mass of drivetrain and chassis must agree, got {d.mass} and {c.mass} kg")

    @classmethod
    def around(cls, drivetrain: SwerveConfig, *, bumper: tuple[float, float]) -> RebuiltRobotConfig:
        """A robot with this drivetrain under it: a chassis of its mass, on its wheels.

        Args:
            drivetrain: The robot's.
            bumper: Length and width over the bumpers [m].
        """
        chassis = ChassisConfig(
            mass=drivetrain.mass,
            bumper_length=bumper[0],
            bumper_width=bumper[1],
            center_of_mass_height=drivetrain.center_of_mass[2],
            yaw_inertia=drivetrain.yaw_inertia,
            wheel_positions=tuple((m.x, m.y) for m in drivetrain.modules),
            wheel_radius=drivetrain.modules[0].wheel_radius,
        )
        return cls(chassis=chassis, drivetrain=drivetrain)

    def build(
        self, world: PhysicsWorld, *, number: int, pose: tuple[float, float, float], rng: np.random.Generator
    ) -> RebuiltRobot:
        """The robot of this config, standing in a world; a config of another kind of robot builds that."""
        return RebuiltRobot(world, self, number=number, pose=pose, rng=rng)

    @property
    def swerve(self) -> SwerveConfig:
        """The drivetrain: as given, or the module at every wheel position."""
        if self.drivetrain is not None:
            return self.drivetrain
        c = self.chassis
        return SwerveConfig(
            modules=tuple(
                replace(self.module, x=x, y=y, wheel_radius=c.wheel_radius, wheel_cof=c.friction)
                for x, y in c.wheel_positions
            ),
            mass=c.mass,
            yaw_inertia=c.inertia[2],
            center_of_mass=(0.0, 0.0, c.center_of_mass_height),
        )


class RebuiltRobot(SwerveRobot):
    """All state of one robot: body, drivetrain, battery, gyro, odometry and the six mechanisms.

    Args:
        world: Where it stands.
        config: What it is built of.
        number: Its place in the list of robots; also the holder of its fuel.
        pose: Start, field frame [m, m, rad].
        rng: For the noise of its sensors.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: RebuiltRobotConfig,
        *,
        number: int,
        pose: tuple[float, float, float],
        rng: np.random.Generator,
    ) -> None:
        self.config = config
        self.number = number
        super().__init__(
            world,
            config.chassis,
            config.swerve,
            pose=pose,
            gyro=config.gyro,
            rng=rng,
            battery=config.battery,
            name=f"robot {number}",
        )
        self.shooter_wheels = FlywheelSim(config.shooter)
        self.hood = ArmSim(config.hood)
        self.feeder = RollerSim(config.feeder)
        self.spindexer = RollerSim(config.spindexer)
        self.deploy = RackSim(config.deploy)
        self.roller = RollerSim(config.roller)
        self.mechanisms: tuple[ShaftSim, ...] = (
            *(self.shooter_wheels, self.hood, self.feeder),
            *(self.spindexer, self.deploy, self.roller),
        )
        """The six, in the order in which they are stepped."""
        self.steps_own_mechanisms = True
        """Whether the game steps them; False: whoever drives their motors does, in steps of its own."""
        self.shooter = ShooterSim(
            config.launch,
            shot_rate=config.shot_rate,
            elevation=lambda: self.elevation,
            speed=lambda: self.exit_speed,
            gate_open=lambda: self.gate_open,
        )

    @property
    def elevation(self) -> float:
        """Of the muzzle above the horizontal [rad]: the hood at 20 degrees shoots straight up (as in the reference)."""
        return degrees(110.0) - self.hood.position

    @property
    def exit_speed(self) -> float:
        """Of a fuel relative to the muzzle, at the wheels' present speed [m/s]."""
        return max(0.0, self.shooter_wheels.velocity) * self.config.wheel_radius * self.config.exit_efficiency

    def wheel_speed_for(self, exit_speed: float) -> float:
        """Shooter wheel speed that gives an exit speed [m/s]; [rad/s]."""
        return exit_speed / (self.config.wheel_radius * self.config.exit_efficiency)

    @property
    def gate_open(self) -> bool:
        """Whether fuel reaches the wheels: feeder above 0.5 and wheels above 5 turns a second, as in the reference."""
        return self.shooter_wheels.velocity > 5.0 * math.tau and self.feeder.velocity > 0.5 * math.tau

    @property
    def intake_active(self) -> bool:
        """Whether the rack is out and the roller pulls in."""
        return self.deploy.extended_fraction > 0.8 and self.roller.velocity > math.tau

    def intake_zone(self) -> IntakeZone:
        """Where fuel is taken in, with the rack where it is now."""
        zone = self.config.intake
        return replace(zone, x_min=zone.x_min - self.deploy.extension)

    @property
    def intake_reach(self) -> float:
        """No place where fuel is taken in is farther from the robot's origin [m]."""
        return self.config.intake.reach + self.deploy.extension

    def after_shot(self, mass: float, exit_speed: float) -> None:
        """The wheels give a fuel its momentum and slow down."""
        self.shooter_wheels.apply_impulse(-launch_impulse(mass, exit_speed, self.config.wheel_radius))

    def step_mechanisms(self, dt: float) -> None:
        """Advance the six by dt [s] at the battery's voltage; disabled or browned out, they coast."""
        volts = self.battery.voltage
        is_off = self.battery.browned_out or not self.drive.enabled
        for mechanism in self.mechanisms:
            if is_off:
                mechanism.coast()  # until robot code commands volts again, in its next tick
            mechanism.step(dt, volts)

    @property
    def mechanism_current(self) -> float:
        """What the six take from the battery [A]."""
        return plain_sum(mechanism.supply_current for mechanism in self.mechanisms)

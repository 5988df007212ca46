"""REBUILT for a team's own robot, as its `simcore.toml` describes it: what `robotpy sim --simcore` plays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from games.rebuilt.robot import RebuiltRobot, RebuiltRobotConfig
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry
from simcore.physics.world import PhysicsWorld
from simcore.pieces.intake import IntakeZone
from simcore.pieces.launch import LaunchParameters
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.mechanisms import FlywheelSim
from simcore.robot.shaft import ShaftSim
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot_file.robot_settings import RobotSettings
from simcore.telemetry.snapshot import TelemetrySink

if TYPE_CHECKING:
    import ntcore

__all__ = ["PracticeRobot", "PracticeRobotConfig", "practice"]

_TURNS = math.tau  # [rad/s]; a roller or feeder that turns once a second moves fuel
_SHOOTS = 5.0 * math.tau  # [rad/s]; slower wheels do not throw
_OUT = 0.8  # [-]; of the way to its stop at which a deployed intake works


@dataclass(frozen=True, slots=True, kw_only=True)
class PracticeRobotConfig(RebuiltRobotConfig):
    """A robot whose mechanisms, intake and shooter are its team's."""

    settings: RobotSettings = field(default_factory=RobotSettings)

    def build(
        self, world: PhysicsWorld, *, number: int, pose: tuple[float, float, float], rng: np.random.Generator
    ) -> PracticeRobot:
        """The robot of this config, standing in a world."""
        return PracticeRobot(world, self, number=number, pose=pose, rng=rng)


class PracticeRobot(RebuiltRobot):
    """The mechanisms of the file in place of the game's own robot's; what the file does not name, stands still.

    Args:
        world: Where it stands.
        config: With the settings.
        number: Its place in the list of robots.
        pose: Start, field frame [m, m, rad].
        rng: For the noise of its sensors.
    """

    def __init__(
        self,
        world: PhysicsWorld,
        config: PracticeRobotConfig,
        *,
        number: int,
        pose: tuple[float, float, float],
        rng: np.random.Generator,
    ) -> None:
        super().__init__(world, config, number=number, pose=pose, rng=rng)
        self.settings = s = config.settings
        self.named: Mapping[str, ShaftSim] = {m.name: m.build() for m in s.mechanisms}
        """The mechanisms of the file, by their names."""
        self.mechanisms = tuple(self.named.values())
        self._guests: list[ShaftSim] = []
        self._roller = self._deploy = self._feeder = self._hood = None
        if s.intake is not None:
            self._roller = self.named[s.intake.roller]
            self._deploy = None if s.intake.deploy is None else self.named[s.intake.deploy]
        if s.shooter is not None:
            wheels = self.named[s.shooter.wheels]
            assert isinstance(wheels, FlywheelSim)
            self.shooter_wheels = wheels
            self._feeder = None if s.shooter.feeder is None else self.named[s.shooter.feeder]
            self._hood = None if s.shooter.hood is None else self.named[s.shooter.hood]

    def add_mechanism(self, mechanism: ShaftSim) -> None:
        """Step one more with the others; it is a guess, so its current is kept from the battery."""
        self._guests.append(mechanism)

    def remove_mechanism(self, mechanism: ShaftSim) -> None:
        """Leave one that was added to somebody else."""
        self._guests.remove(mechanism)

    def step_mechanisms(self, dt: float) -> None:
        """Advance all by dt [s]."""
        super().step_mechanisms(dt)
        for mechanism in self._guests:
            mechanism.step(dt, self.battery.voltage)

    @property
    def elevation(self) -> float:
        """Of the muzzle above the horizontal [rad]."""
        shooter = self.settings.shooter
        if shooter is None:
            return super().elevation
        hood = 0.0 if self._hood is None else self._hood.position
        return shooter.elevation + shooter.elevation_per_hood * hood

    @property
    def gate_open(self) -> bool:
        """Whether pieces reach wheels that turn."""
        if self.settings.shooter is None:
            return False
        fed = self._feeder is None or self._feeder.velocity > 0.5 * _TURNS
        return fed and self.shooter_wheels.velocity > _SHOOTS

    @property
    def intake_active(self) -> bool:
        """Whether the intake is out and its roller pulls in."""
        return self._roller is not None and self._roller.velocity > _TURNS and self._is_out

    def intake_zone(self) -> IntakeZone:
        """Where pieces are taken in: as the file says, with the intake out."""
        return self.config.intake

    @property
    def _is_out(self) -> bool:
        intake, deploy = self.settings.intake, self._deploy
        if intake is None or deploy is None:
            return True
        low, high = deploy.stops
        way = (deploy.position - low) / (high - low)
        return way > _OUT if intake.out_at == "upper" else way < 1.0 - _OUT


def practice(
    settings: RobotSettings,
    drivetrain: SwerveConfig,
    sinks: Sequence[TelemetrySink] = (),
    network: ntcore.NetworkTableInstance | None = None,
) -> tuple[RebuiltSim, PracticeRobot]:
    """The whole field and one robot; every fuel counts.

    Args:
        settings: The robot's, with bumpers.
        drivetrain: The robot's.
        sinks: Who wants telemetry.
        network: Where its cameras publish and listen.

    Raises:
        ConfigError: The robot cannot be, or cannot start where it should.
    """
    length, width = settings.bumper or (0.8, 0.8)
    body = ChassisConfig(
        mass=drivetrain.mass,
        bumper_length=length,
        bumper_width=width,
        center_of_mass_height=drivetrain.center_of_mass[2],
        yaw_inertia=drivetrain.yaw_inertia,
        wheel_positions=tuple((m.x, m.y) for m in drivetrain.modules),
        wheel_radius=drivetrain.modules[0].wheel_radius,
    )
    config = PracticeRobotConfig(
        chassis=body,
        drivetrain=drivetrain,
        hopper_capacity=settings.capacity,
        cameras=settings.cameras,
        settings=settings,
    )
    intake, shooter = settings.intake, settings.shooter
    if intake is not None:
        (x_min, x_max), (y_min, y_max) = intake.x, intake.y
        zone = IntakeZone(x_min=x_min, x_max=x_max, y_min=y_min, y_max=y_max, z_max=intake.z_max)
        config = replace(config, intake=zone)
    if shooter is not None:
        launch = LaunchParameters(
            height=shooter.height, forward=shooter.forward, heading=shooter.yaw, barrels=shooter.barrels
        )
        config = replace(
            config,
            launch=launch,
            shot_rate=shooter.rate,
            wheel_radius=shooter.wheel_radius,
            exit_efficiency=shooter.exit_efficiency,
        )
    entry = RobotEntry(config=config, pose=settings.start, preload=settings.preload)
    sim = RebuiltSim(RebuiltConfig(robots=(entry,), hubs_always_active=True), sinks=sinks, network=network)
    robot = sim.robots[0]
    assert isinstance(robot, PracticeRobot)
    return sim, robot

"""The game's robot on a differential drive: for teams without swerve, connected in a physics.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from games.rebuilt.robot import RebuiltRobot, RebuiltRobotConfig
from simcore.physics.world import PhysicsWorld
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.robot.tank_drive import TankConfig, TankDrive

__all__ = ["RebuiltTankConfig", "RebuiltTankRobot"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RebuiltTankConfig(RebuiltRobotConfig):
    """Mechanisms as in `RebuiltRobotConfig`; mass, wheels and bumpers follow `tank`."""

    tank: TankConfig = field(default_factory=TankConfig)
    bumper: tuple[float, float] = (0.9, 0.8)
    """Length and width [m]."""

    def __post_init__(self) -> None:
        t = self.tank
        body = ChassisConfig(
            mass=t.mass,
            bumper_length=self.bumper[0],
            bumper_width=self.bumper[1],
            center_of_mass_height=t.center_of_mass[2],
            yaw_inertia=t.yaw_inertia,
            wheel_positions=tuple((x, side * 0.5 * t.trackwidth) for side in (1.0, -1.0) for x in t.wheel_xs),
            wheel_radius=t.wheel_radius,
        )
        object.__setattr__(self, "chassis", body)
        RebuiltRobotConfig.__post_init__(self)

    def build(
        self, world: PhysicsWorld, *, number: int, pose: tuple[float, float, float], rng: np.random.Generator
    ) -> RebuiltTankRobot:
        """The robot of this config, standing in a world."""
        return RebuiltTankRobot(world, self, number=number, pose=pose, rng=rng)


class RebuiltTankRobot(RebuiltRobot):
    """`RebuiltRobot` with a `TankDrive`; scripts that command modules cannot drive it."""

    config: RebuiltTankConfig
    drive: TankDrive  # type: ignore[assignment]

    def _build_drive(self, swerve: SwerveConfig) -> TankDrive:  # type: ignore[override]
        return TankDrive(self.config.tank, battery=self.battery)

    def _wheels(self) -> tuple[Sequence[float], Sequence[float]]:
        """Wheels that never turn about their azimuth."""
        n = len(self.config.tank.wheel_xs)
        left, right = self.drive.side_distances()
        return [left] * n + [right] * n, [0.0] * (2 * n)

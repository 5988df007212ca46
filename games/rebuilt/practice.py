"""REBUILT for a robot of which only the drivetrain is known: what `robotpy sim --simcore` plays."""

from __future__ import annotations

from collections.abc import Sequence

from games.rebuilt.robot import RebuiltRobot, RebuiltRobotConfig
from games.rebuilt.sim import RebuiltConfig, RebuiltSim, RobotEntry
from simcore.chassis.config import ChassisConfig
from simcore.drivetrain.config import SwerveConfig
from simcore.telemetry.snapshot import TelemetrySink

__all__ = ["practice"]


def practice(
    drivetrain: SwerveConfig, bumper: tuple[float, float], sinks: Sequence[TelemetrySink] = ()
) -> tuple[RebuiltSim, RebuiltRobot]:
    """The whole field and one robot, in front of its alliance's wall; every fuel counts.

    Args:
        drivetrain: The robot's.
        bumper: Length and width over the bumpers [m].
        sinks: Who wants telemetry.
    """
    body = ChassisConfig(
        mass=drivetrain.mass,
        bumper_length=bumper[0],
        bumper_width=bumper[1],
        center_of_mass_height=drivetrain.center_of_mass[2],
        yaw_inertia=drivetrain.yaw_inertia,
        wheel_positions=tuple((m.x, m.y) for m in drivetrain.modules),
        wheel_radius=drivetrain.modules[0].wheel_radius,
    )
    entry = RobotEntry(config=RebuiltRobotConfig(chassis=body, drivetrain=drivetrain), pose=(2.0, 1.2, 0.0), preload=0)
    sim = RebuiltSim(RebuiltConfig(robots=(entry,), hubs_always_active=True), sinks=sinks)
    return sim, sim.robots[0]

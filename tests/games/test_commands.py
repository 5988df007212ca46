"""Commands are checked when they are given: nonsense is refused by a sentence, and no later tick ends by it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from simcore.errors import SimcoreError
from simcore.match.game import PieceSupply
from simcore.match.match import Match
from simcore.physics.shapes import Sphere
from simcore.pieces.kinds import GamePieceConfig
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, PistonConfig, ServoConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig

GEARBOX = GearboxConfig(motor=motor("NEO"), gearing=20.0)
MECHANISMS = {
    "wheel": FlywheelConfig(gearbox=GEARBOX, inertia=0.001),
    "arm": ArmConfig(gearbox=GEARBOX, inertia=0.1, mass=1.0, center_of_mass=0.2, min_angle=0.0, max_angle=1.0),
    "lift": ElevatorConfig(gearbox=GEARBOX, carriage_mass=3.0, drum_radius=0.02, min_height=0.0, max_height=1.0),
    "valve": PistonConfig(stroke=0.2, stroke_time=0.2),
    "servo": ServoConfig(min_angle=0.0, max_angle=1.0, speed=3.0),
}
DRIVETRAINS = {
    "swerve": SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0)),
    "tank": TankConfig(),
    "mecanum": MecanumConfig(),
}
BALL = PieceSupply(GamePieceConfig(name="ball", shape=Sphere(0.1), mass=0.2), 10)
NONSENSE = (None, "5", math.nan, math.inf, 1e300, 10**400, [], [1.0], {"a": 1}, object(), np.zeros((3, 3)), 3 + 4j)

OTHERS = ("set_mass_properties", "set_requests")
"""Called by the chassis and the loop, with what they have worked out."""


@pytest.mark.parametrize("kind", DRIVETRAINS)
def test_no_command_of_nonsense_is_a_foreign_error_or_ends_a_later_tick(kind):
    with Match.bare(RobotConfig(drivetrain=DRIVETRAINS[kind], mechanisms=MECHANISMS), pieces=(BALL,)) as match:
        robot, pieces = match.robots[0], match.pieces
        piece = pieces.spawn("ball", np.array([[5.0, 5.0, 0.1]]))
        drive = [
            getattr(robot.drive, name)
            for name in dir(robot.drive)
            if name.startswith("set_") and name != "set_mass_properties"
        ]
        mechanisms = robot.mechanisms.values()
        calls = [
            *(
                lambda bad, set_=set_: set_(*[bad] * _arguments(set_))
                for set_ in drive
                if "request" not in set_.__name__
            ),
            *(lambda bad, m=m: m.set_volts(bad) for m in mechanisms),
            *(lambda bad, m=m: m.set_duty_cycle(bad) for m in mechanisms),
            *(lambda bad, m=m: m.set_load(bad) for m in mechanisms),
            *(lambda bad, m=m: m.reset(bad) for m in mechanisms),
            lambda bad: pieces.stage("ball", bad),
            lambda bad: pieces.stage(bad, 1),
            lambda bad: pieces.spawn("ball", bad),
            lambda bad: pieces.release(piece, bad),
            lambda bad: pieces.release(bad, np.zeros((1, 3))),
            lambda bad: pieces.push(piece, bad),
            lambda bad: pieces.put_down(piece, bad),
            lambda bad: pieces.hold(piece, bad),
            lambda bad: match.control.start_auto(bad),
        ]
        assert len(calls) > 30
        for call in calls:
            for bad in NONSENSE:
                try:
                    call(bad)
                except SimcoreError:
                    continue
            match.tick()
        assert np.isfinite(robot.chassis.pose).all() and match.count.is_conserved


def _arguments(function):
    return function.__code__.co_argcount - 1

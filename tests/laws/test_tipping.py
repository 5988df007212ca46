"""Acceleration at which a robot tips: a h = g b."""

from dataclasses import replace

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.pieces.kinds import GamePieceConfig
from simcore.robot.chassis_config import MovingMass
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ElevatorConfig
from simcore.robot.robot_config import RobotConfig, tipping_limit
from simcore.robot.storage import StorageConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.units import GRAVITY
from simcore.world.linkage import Joint
from simcore.world.shapes import Sphere

pytestmark = pytest.mark.engines("bullet")

LIFT = ElevatorConfig(
    gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=10.0),
    carriage_mass=10.0,
    drum_radius=0.05,
    max_height=1.5,
)
SLIDE = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.2), slides=True, ratio=0.05)
MODULE = SwerveModuleConfig(x=0.0, y=0.0, drive_stator_limit=60.0)
ROBOT = RobotConfig(
    drivetrain=SwerveConfig.rectangle(0.6, 0.4, MODULE, mass=50.0, height=0.25),
    mechanisms={"lift": LIFT},
    storage=StorageConfig(capacity=5, low=(0.1, -0.1, 0.5), high=(0.3, 0.1, 1.5)),
)


def test_a_plain_robot_tips_about_its_outer_wheels():
    limit = tipping_limit(ROBOT)
    assert (limit.mass, limit.height) == (50.0, 0.25)
    assert limit.forward == pytest.approx(GRAVITY * 0.3 / 0.25)
    assert limit.sideways == pytest.approx(GRAVITY * 0.2 / 0.25)
    assert 5.0 < limit.drivetrain < 12.0


@each("center", [(0.301, 0.0, 0.2), (0.0, -0.2, 0.2), (-0.4, 0.3, 0.2)])
def test_a_robot_whose_center_of_mass_is_not_between_its_wheels_is_refused(center):
    with pytest.raises(
        ConfigError, match=r"center_of_mass must lie between the wheels, .* with wheels at \(\(0.3, 0.2\)"
    ):
        replace(ROBOT, drivetrain=replace(ROBOT.drivetrain, center_of_mass=center))
    replace(ROBOT, drivetrain=replace(ROBOT.drivetrain, center_of_mass=(0.299, 0.199, 0.2)))


def test_a_raised_elevator_and_full_storages_lower_the_tipping_limit():
    lifting = replace(ROBOT, moving_masses=(MovingMass(name="carriage", mass=10.0, joints=(SLIDE,)),))
    raised = tipping_limit(lifting)
    assert raised.height == pytest.approx(0.25 + 10.0 * 1.5 / 50.0)
    assert raised.sideways == pytest.approx(GRAVITY * 0.2 / raised.height)
    ball = GamePieceConfig(name="Ball", shape=Sphere(0.1), mass=2.0)
    full = tipping_limit(lifting, [ball, replace(ball, name="Light", mass=0.1)])
    assert full.mass == pytest.approx(60.0)
    center = (10.0 * 0.2 / 60.0, (50.0 * raised.height + 2.0 * (0.6 + 0.8 + 1.0 + 1.2 + 1.4)) / 60.0)
    assert full.height == pytest.approx(center[1])
    assert full.forward == pytest.approx(GRAVITY * (0.3 - center[0]) / center[1])

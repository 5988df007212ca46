"""Mass, center of mass and moments of inertia of a body with point masses."""

from dataclasses import replace

import pytest

from simcore.errors import ConfigError, UnknownNameError
from simcore.robot.chassis_config import MassDistribution, MovingMass, with_points
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ElevatorConfig
from simcore.robot.robot_config import RobotConfig
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.world.linkage import Joint

pytestmark = pytest.mark.engines("bullet")

BODY = MassDistribution(40.0, (0.1, -0.05, 0.2), (3.0, 4.0, 5.0))
LIFT = ElevatorConfig(
    gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=10.0),
    carriage_mass=8.0,
    drum_radius=0.05,
    max_height=2.0,
    start_height=0.5,
)
JOINT = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), origin=(0.1, 0.0, 0.2), slides=True, ratio=0.05)
CARRIAGE = MovingMass(name="carriage", mass=8.0, joints=(JOINT,))
ROBOT = RobotConfig(
    drivetrain=SwerveConfig.square(0.5, SwerveModuleConfig(x=0.0, y=0.0), mass=55.0), mechanisms={"lift": LIFT}
)


def test_a_point_mass_shifts_center_and_moments_by_the_parallel_axis_theorem():
    """With mu = m1 m2 / (m1 + m2), each moment grows by mu times the squared distance from the axis."""
    mass, center, inertia = with_points(BODY, [(10.0, (0.4, 0.35, 1.2))])
    mu, (dx, dy, dz) = 40.0 * 10.0 / 50.0, (0.3, 0.4, 1.0)
    assert mass == 50.0
    assert center == pytest.approx((0.1 + 0.2 * dx, -0.05 + 0.2 * dy, 0.2 + 0.2 * dz))
    expected = (3.0 + mu * (dy**2 + dz**2), 4.0 + mu * (dx**2 + dz**2), 5.0 + mu * (dx**2 + dy**2))
    assert inertia == pytest.approx(expected)


def test_adding_and_removing_a_mass_restores_the_body():
    point = (7.0, (0.3, 0.2, 0.9))
    added = with_points(BODY, [point])
    for number, expected in zip(with_points(added, [(-7.0, point[1])]), BODY, strict=True):
        assert number == pytest.approx(expected)
    assert with_points(BODY, []) == BODY


def test_the_configured_mass_includes_moving_masses_at_their_start():
    robot = replace(ROBOT, moving_masses=(CARRIAGE,))
    assert robot.whole == ROBOT.whole == ROBOT.bare_body
    assert robot.bare_body.mass == pytest.approx(47.0)
    at_start = with_points(robot.bare_body, [(8.0, (0.1, 0.0, 0.7))])
    for number, expected in zip(at_start, ROBOT.whole, strict=True):
        assert number == pytest.approx(expected)


def test_invalid_moving_masses_are_refused():
    with pytest.raises(UnknownNameError, match="lifft"):
        joint = replace(JOINT, mechanism="lifft")
        replace(ROBOT, moving_masses=(MovingMass(name="carriage", mass=8.0, joints=(joint,)),))
    with pytest.raises(ConfigError, match="leave nothing for the body"):
        replace(ROBOT, moving_masses=(replace(CARRIAGE, mass=60.0),))
    with pytest.raises(ConfigError, match="needs a joint"):
        MovingMass(name="carriage", mass=8.0, joints=())

"""A mecanum drive against closed forms: WPILib's kinematics, push of rollers at 45 degrees, energy."""

import math
from dataclasses import replace

import pytest
from each_case import each

from simcore.robot.dc_motor import MotorModel
from simcore.robot.fixed_wheel_config import MecanumConfig
from simcore.robot.fixed_wheel_drive import MecanumDrive
from simcore.testing.benches import DriveBench, hold
from simcore.units import GRAVITY

pytestmark = pytest.mark.engines("bullet")

FREE = replace(MecanumConfig(), friction_volts=0.0, rolling_resistance=0.0, efficiency=1.0, free_speed_share=1.0)
"""Drive without friction in gears and wheels."""
ARM = 0.56  # |x| + |y| of the wheels [m]


def driven(config: MecanumConfig, volts: list[float], seconds: float) -> tuple[MecanumDrive, DriveBench]:
    drive = MecanumDrive(config)
    robot = DriveBench(drive)
    drive.set_volts(volts)
    robot.run(seconds)
    return drive, robot


@each(
    ("signs", "axis", "per_tread"),
    [((1, 1, 1, 1), "vx", 1.0), ((-1, 1, 1, -1), "vy", 1.0), ((-1, 1, -1, 1), "omega", 1.0 / ARM)],
)
def test_top_speed_follows_from_the_free_speed_of_the_motors(signs, axis, per_tread):
    """r w at 6 V, where the torque vanishes: J dw/dt = k_t (V - w / k_v) / R without friction ends at w = k_v V."""
    drive, robot = driven(FREE, [6.0 * s for s in signs], 8.0)
    motor: MotorModel = FREE.motor
    tread = motor.kv * 6.0 / FREE.gearing * FREE.wheel_radius
    assert getattr(robot, axis) == pytest.approx(tread * per_tread, rel=0.005)
    others = {"vx", "vy", "omega"} - {axis}
    assert all(abs(getattr(robot, name)) < 1e-6 for name in others)
    assert [abs(v) for v in drive.shaft_speeds] == pytest.approx([tread / FREE.wheel_radius] * 4, rel=0.005)


@pytest.mark.parametrize("direction", ["forward", "left"])
def test_a_mecanum_drive_pushes_with_its_grip_over_root_two(direction):
    """Each roller exerts mu N along its axis, and 1 / sqrt 2 of this force acts in the direction of the push."""
    signs = (1, 1, 1, 1) if direction == "forward" else (-1, 1, 1, -1)
    drive = MecanumDrive(FREE)
    drive.set_volts([12.0 * s for s in signs])
    for _ in range(40):
        hold(drive, 0.005, (0.0, 0.0, 0.0))  # chassis held in place
    force = drive.wheel_forces.sum(axis=0)
    along, across = (force[0], force[1]) if direction == "forward" else (force[1], force[0])
    assert along == pytest.approx(FREE.wheel_cof * FREE.mass * GRAVITY / math.sqrt(2.0), rel=0.002)
    assert abs(across) < 1e-6 * along


def test_a_roller_exerts_a_force_only_along_its_axis():
    """The front left wheel rolls freely along (1, 1) and resists motion along (1, -1)."""
    drive = MecanumDrive(FREE)
    hold(drive, 0.005, (0.5, 0.5, 0.0))
    forces = drive.wheel_forces
    assert forces[0] == pytest.approx((0.0, 0.0), abs=1e-9) and forces[3] == pytest.approx((0.0, 0.0), abs=1e-9)
    assert forces[1][0] == pytest.approx(forces[1][1]) and forces[1][0] < -1.0


def test_acceleration_without_slip_follows_from_motor_torque_and_inertia():
    """m a = 4 tau g / r - 4 J a / r^2 with the current of each motor at its limit: rotor inertia adds to the mass."""
    config = replace(FREE, stator_limit=20.0, wheel_cof=2.0)
    _, robot = driven(config, [12.0] * 4, 0.1)
    torque = config.motor.kt * 20.0 * config.gearing
    inertia = config.shaft_inertia(1, 1)
    accel = 4.0 * torque / config.wheel_radius / (config.mass + 4.0 * inertia / config.wheel_radius**2)
    assert robot.vx == pytest.approx(0.1 * accel, rel=0.01)


@each("speeds", [(2.0, 0.0, 0.0), (0.0, 1.5, 0.0), (0.0, 0.0, 3.0), (1.0, -1.0, 0.2)])
def test_the_velocity_loops_follow_commanded_chassis_speeds(speeds):
    drive = MecanumDrive(MecanumConfig())
    robot = DriveBench(drive)
    drive.set_chassis_speeds(*speeds)
    robot.run(1.5)
    yaw = robot.yaw
    forward = math.cos(yaw) * robot.vx + math.sin(yaw) * robot.vy
    left = math.cos(yaw) * robot.vy - math.sin(yaw) * robot.vx
    assert (forward, left, robot.omega) == pytest.approx(speeds, abs=0.06)


def test_a_commanded_turn_leaves_the_robot_center_at_rest():
    """The center of mass, 0.1 m ahead of the robot center, then moves at omega x r."""
    drive = MecanumDrive(replace(MecanumConfig(), center_of_mass=(0.1, 0.0, 0.2)))
    robot = DriveBench(drive)
    drive.set_chassis_speeds(0.0, 0.0, 2.0)
    robot.run(1.5)
    c, s = math.cos(robot.yaw), math.sin(robot.yaw)
    forward, left = c * robot.vx + s * robot.vy, c * robot.vy - s * robot.vx
    assert (forward, left, robot.omega) == pytest.approx((0.0, 0.2, 2.0), abs=0.06)


@each("signs", [(1, 1, 1, 1), (-1, 1, 1, -1), (1, -1, 1, -1), (1, 0, 0.3, 1)])
def test_kinetic_energy_never_exceeds_the_electrical_energy_drawn(signs):
    """Kinetic energy of chassis and shafts is at most the energy that the motors drew, driving and braking."""
    config = MecanumConfig()
    drive = MecanumDrive(config)
    robot = DriveBench(drive)
    for volts in (12.0, -12.0, 6.0, 0.0):
        drive.set_volts([volts * s for s in signs])
        for _ in range(20):
            robot.run(0.02)
            kinetic = 0.5 * config.mass * (robot.vx**2 + robot.vy**2) + 0.5 * config.yaw_inertia * robot.omega**2
            kinetic += sum(0.5 * config.shaft_inertia(1, 1) * w * w for w in drive.shaft_speeds)
            assert kinetic <= drive.electrical_energy + 1e-6

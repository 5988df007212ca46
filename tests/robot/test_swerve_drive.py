import math
from dataclasses import replace

import numpy as np
import pytest
from each_case import each

from simcore.errors import ConfigError, NonFiniteError
from simcore.loop.robot_state import STEP
from simcore.loop.robots import optimize
from simcore.robot.battery import Battery, BatteryConfig
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive, desaturate, module_targets
from simcore.testing.benches import DriveBench, hold
from simcore.units import GRAVITY

MODULE = SwerveModuleConfig(x=0, y=0)


def drive_of(battery=None, **changes) -> SwerveDrive:
    return SwerveDrive(SwerveConfig.square(0.527, replace(MODULE, **changes)), battery=battery)


def test_a_swerve_drive_reaches_its_commanded_chassis_speeds():
    drive = drive_of()
    robot = DriveBench(drive)
    drive.set_chassis_speeds(2.0, 1.0, 0.0)
    robot.run(1.5)
    c, s = math.cos(robot.yaw), math.sin(robot.yaw)  # nothing holds the yaw here
    assert (c * robot.vx + s * robot.vy, c * robot.vy - s * robot.vx) == pytest.approx((2.0, 1.0), abs=0.03)
    drive.set_chassis_speeds(0.0, 0.0, 3.0)
    robot.run(1.5)
    assert robot.omega == pytest.approx(3.0, abs=0.05)
    drive.set_chassis_speeds(0.0, 0.0, 0.0)
    robot.run(1.0)
    assert robot.speed == pytest.approx(0.0, abs=1e-3)


def test_a_stalled_steer_motor_keeps_its_supply_limit():
    """12 V on a stalled motor would draw V^2 / R; limited to P = 5 A at 12 V, it carries I = sqrt(P / R)."""
    drive = drive_of(steer_supply_limit=5.0, steer_friction_volts=13.0, steer_efficiency=1.0)
    drive.set_volts([0.0] * 4, [12.0] * 4)
    hold(drive, 0.005, (0.0, 0.0, 0.0))
    assert drive.state.steer_speed.tolist() == [0.0] * 4
    assert drive.steer_motors.supply == pytest.approx([5.0] * 4)
    assert drive.steer_motors.current == pytest.approx([math.sqrt(5.0 * 12.0 / MODULE.steer_motor.resistance)] * 4)


@pytest.mark.parametrize(("speed", "turns"), [(0.0, False), (2.0, True)])
def test_scrub_holds_the_steer_angle_of_a_wheel_at_rest_but_not_of_a_rolling_wheel(speed, turns):
    """The volts are halfway between the friction in the air and that on the carpet while nothing rolls.

    At 2 m/s, a patch slips by s = .01 v, and a module that steers at omega rubs it by r omega: the carpet takes r omega
    / s of mu N r. So it steers at the speed at which the volts less friction equal the back-EMF and this share.
    """
    drive = drive_of(steer_brake=False)
    standing = float(drive.shafts["model"]["ks"][4])
    free = MODULE.steer_friction_volts
    hold(drive, 0.3, (speed, 0.0, 0.0))
    drive.set_volts([0.0] * 4, [0.5 * (free + standing)] * 4)
    before = drive.steer_angles[0]
    hold(drive, 0.1, (speed, 0.0, 0.0))
    assert (drive.steer_angles[0] - before > 0.01) == turns


def test_a_command_beyond_top_speed_is_scaled_down_and_keeps_its_direction():
    drive = drive_of()
    robot = DriveBench(drive)
    drive.set_chassis_speeds(30.0, 30.0, 0.0)
    robot.run(3.0)
    heading = math.atan2(robot.vy, robot.vx) - robot.yaw  # nothing holds the yaw here
    assert math.degrees(heading) == pytest.approx(45.0, abs=1.0)
    assert robot.speed == pytest.approx(drive.max_speed, rel=0.02)


def test_the_drive_reaches_its_stated_top_speed_and_acceleration():
    for changes in ({}, {"drive_stator_limit": 60.0}, {"drive_stator_limit": 40.0}):
        drive = SwerveDrive(SwerveConfig.square(0.527, replace(MODULE, **changes), height=0.0))
        robot = DriveBench(drive)
        drive.set_volts([12.0] * 4, [0.0] * 4)
        robot.run(0.1)
        assert robot.vx / 0.1 == pytest.approx(drive.max_accel, rel=0.03)
        robot.run(4.0)
        assert robot.vx == pytest.approx(drive.max_speed, rel=0.01)
        drive.reset(angles=[math.atan2(x, -y) for x, y in drive.config.positions])
        robot.reset()
        drive.set_volts([12.0] * 4, [0.0] * 4)
        robot.run(0.1)
        assert robot.omega / 0.1 == pytest.approx(drive.max_angular_accel, rel=0.03)
        robot.run(4.0)
        assert robot.omega == pytest.approx(drive.max_omega, rel=0.01)


def test_a_torque_current_command_sets_the_stator_current():
    drive = drive_of(drive_stator_limit=80.0)
    robot = DriveBench(drive)
    drive.set_torque_currents([30.0, 30.0, 30.0, 200.0], [0.0] * 4)
    robot.run(0.1)
    assert drive.drive_motors.current == pytest.approx([30.0, 30.0, 30.0, 80.0])


def test_a_duty_cycle_follows_the_voltage_of_the_battery():
    stiff = Battery(BatteryConfig(full_voltage=10.0, empty_voltage=10.0, resistance=0.0))
    drive = drive_of(stiff, drive_stator_limit=math.inf, drive_supply_limit=math.inf)
    drive.set_duty_cycles([0.5, -0.5, 2.0, 0.0], [0.0] * 4)
    hold(drive, 0.005, (0.0, 0.0, 0.0), in_air=True)
    assert drive.drive_motors.volts == pytest.approx([5.0, -5.0, 10.0, 0.0], rel=1e-3)


def test_a_braking_motor_is_shorted_and_a_coasting_motor_is_open():
    """In coast, friction and rolling drag remain: a = (4 T / r + .01 m g) / (m + 4 J / r^2)."""
    m = MODULE
    dry = (
        4 * m.drive_gearing * m.drive_motor.kt * m.drive_efficiency * m.drive_friction_volts / m.drive_motor.resistance
    )
    slows = (dry / m.wheel_radius + 5.5 * GRAVITY * 0.1) / (55.0 + 4 * m.drive_inertia / m.wheel_radius**2)
    ends = []
    for brake in (True, False):
        drive = drive_of(drive_brake=brake)
        drive.state.wheel_speed[:] = [60.0] * 4
        robot = DriveBench(drive)
        robot.reset(vx=60.0 * 0.0508)
        robot.run(0.2)
        ends.append(robot.vx)
        if not brake:
            assert drive.drive_motors.current == [0.0] * 4
    assert ends[0] < 1.5
    assert ends[1] == pytest.approx(60.0 * 0.0508 - 0.2 * slows, rel=0.005)


def test_a_brownout_disables_the_outputs_and_its_end_enables_them():
    drive = drive_of(Battery(BatteryConfig(resistance=0.02)))
    drive.set_volts([1.0] * 4, [0.0] * 4)
    drive.other_current = 320.0
    hold(drive, 0.02, (0.0, 0.0, 0.0))
    assert drive.browned_out
    hold(drive, 0.02, (0.0, 0.0, 0.0))
    assert drive.supply_current == pytest.approx(0.0, abs=1e-9)
    drive.other_current = 0.0
    hold(drive, 0.02, (0.0, 0.0, 0.0))
    assert not drive.browned_out


def test_a_drive_on_a_battery_at_zero_volts_does_not_accelerate_and_draws_no_current():
    drive = drive_of(Battery(BatteryConfig(full_voltage=0.0, empty_voltage=0.0)))
    drive.set_chassis_speeds(3.0, 0.0, 1.0)
    robot = DriveBench(drive)
    robot.run(0.5)
    assert robot.speed == 0.0
    drive = drive_of(Battery(BatteryConfig(full_voltage=0.0, empty_voltage=0.0, brownout_enabled=False)))
    drive.set_volts([12.0] * 4, [12.0] * 4)
    assert hold(drive, 0.02, (1.0, 0.0, 0.0))[0] < 0.0  # shorted motors brake
    assert drive.supply_current == 0.0


def test_a_disabled_drive_is_neutral():
    drive = drive_of()
    drive.set_volts([12.0] * 4, [12.0] * 4)
    drive.enabled = False
    assert hold(drive, 0.02, (0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)


@each("bad", [math.nan, math.inf, None, "12"])
def test_an_invalid_command_changes_nothing_and_the_error_names_the_module(bad):
    drive = drive_of()
    drive.set_volts([6.0] * 4, [0.0] * 4)
    twin = drive_of()
    twin.set_volts([6.0] * 4, [0.0] * 4)
    for call in (drive.set_volts, drive.set_module_states, drive.set_duty_cycles, drive.set_torque_currents):
        with pytest.raises(NonFiniteError, match="front right"):
            call([1.0, bad, 1.0, 1.0], [0.0] * 4)
        with pytest.raises(NonFiniteError, match="back left"):
            call([1.0] * 4, [0.0, 0.0, bad, 0.0])
    with pytest.raises(NonFiniteError, match="omega"):
        drive.set_chassis_speeds(0.0, 0.0, bad)
    assert hold(drive, 0.02, (0.0, 0.0, 0.0)) == hold(twin, 0.02, (0.0, 0.0, 0.0))


def test_the_error_for_a_wrong_number_of_values_gives_both_numbers():
    drive = drive_of()
    with pytest.raises(ConfigError, match="4 modules, got 3"):
        drive.set_volts([1.0] * 3, [0.0] * 4)


def test_a_reset_restores_the_initial_state():
    drive = drive_of(Battery())
    drive.set_chassis_speeds(2.0, 1.0, 1.0)
    first = [hold(drive, 0.02, (0.0, 0.0, 0.0)) for _ in range(10)]
    drive.reset()
    assert not any(drive.shaft_angles)
    drive.set_chassis_speeds(2.0, 1.0, 1.0)
    assert [hold(drive, 0.02, (0.0, 0.0, 0.0)) for _ in range(10)] == first


def test_wheels_in_the_air_spin_up_and_push_nothing():
    drive = drive_of()
    drive.set_volts([12.0] * 4, [0.0] * 4)
    for _ in range(40):
        assert hold(drive, 0.005, (0.0, 0.0, 0.0), in_air=True) == (0.0, 0.0, 0.0)
    assert drive.wheel_speeds() == pytest.approx([drive.max_speed] * 4, rel=0.02)
    assert not drive.wheel_forces.any()


def test_wheels_across_a_ramp_hold_the_robot():
    """Within the linear part of the tire, it creeps at slip_speed * (m g sin a) / (mu m g cos a): 0.09 mm/s."""
    drive = drive_of()
    robot = DriveBench(drive, slope=math.radians(15))
    drive.reset(angles=[math.pi / 2] * 4)
    robot.run(0.2)
    before = robot.x
    robot.run(2.0)
    share = math.tan(math.radians(15)) / 1.2
    assert before - robot.x == pytest.approx(MODULE.slip_speed * share * 2.0, rel=0.1)


def test_shorted_motors_let_a_robot_roll_down_a_ramp_slowly():
    """m g sin a = 4 (f + kt G^2 w / (R kv) / e) / r + rolling drag, where f is the dry friction."""
    drive = drive_of()
    robot = DriveBench(drive, slope=math.radians(15))
    robot.run(2.0)
    m = MODULE.drive_motor
    weight = 55.0 * GRAVITY * (math.sin(math.radians(15)) - 0.01 * math.cos(math.radians(15)))
    dry = 6.75 * m.kt * 0.95 * MODULE.drive_friction_volts / m.resistance
    damping = m.kt * 6.75**2 / (m.resistance * m.kv) / 0.95
    w = (weight * 0.0508 / 4 - dry) / damping
    assert -robot.vx == pytest.approx(w * 0.0508, rel=0.02, abs=0.002)


def test_a_coupled_steer_axis_turns_the_drive_rotor_and_not_the_wheel():
    drive = drive_of(coupling_ratio=3.57)
    drive.stop()
    drive.set_volts([0.0] * 4, [2.0] * 4)
    robot = DriveBench(drive)
    robot.run(0.3)
    turned = drive.steer_angles[0]
    assert turned > 0.5
    rotor = drive.drive_rotor_angles[0]
    assert rotor == pytest.approx(6.75 * drive.shaft_angles[0] + 3.57 * turned)
    # A shorted drive motor resists: it drags the wheels back a little rather than let its rotor spin.
    assert drive.shaft_angles[0] < 0.0


def test_steering_cannot_diverge_at_any_inertia_or_step():
    for gearing in (41.25, 12.8):
        for inertia in (1e-9, 1e-4, 1.0):
            for h in (0.001, 0.02):
                motor_ = replace(MODULE.steer_motor, rotor_inertia=0.0)
                drive = drive_of(steer_gearing=gearing, steer_inertia=inertia, steer_motor=motor_)
                top = 12.0 * motor_.kv / gearing
                drive.set_volts([0.0] * 4, [12.0] * 4)
                for _ in range(25):
                    hold(drive, h, (0.0, 0.0, 0.0))
                    assert (np.abs(drive.state.steer_speed) <= top).all()


def test_the_reported_forces_equal_the_change_of_momentum():
    drive = drive_of()
    drive.set_volts([6.0, 3.0, 6.0, 3.0], [0.0] * 4)
    dvx, dvy, domega = hold(drive, STEP, (0.0, 0.0, 0.0))
    force = drive.wheel_forces
    assert dvx == pytest.approx(force[:, 0].sum() * STEP / 55.0)
    assert dvy == pytest.approx(force[:, 1].sum() * STEP / 55.0, abs=1e-6)
    torque = sum(x * fy - y * fx for (x, y), (fx, fy) in zip(drive.config.positions, force, strict=True))
    assert domega == pytest.approx(torque * STEP / drive.config.yaw_inertia, rel=1e-6)


def test_a_robot_that_coasts_in_a_circle_loses_the_same_speed_for_any_step():
    """Lateral slip takes 1 to 10 % of its speed in 2 s: forces act in the axes of the middle of a step."""
    module = replace(MODULE, drive_brake=False, drive_friction_volts=0.0, rolling_resistance=0.0)
    speeds = []
    for h in (0.005, STEP, 1e-4):
        drive = SwerveDrive(SwerveConfig.square(0.527, module, height=0.0))
        drive.reset(vx=1.0, omega=6.0)
        robot = DriveBench(drive)
        robot.reset(vx=1.0, omega=6.0)
        robot.run(2.0, h=h)
        speeds.append(robot.speed)
    assert speeds[0] == pytest.approx(speeds[2], abs=5e-3)
    assert speeds[1] == pytest.approx(speeds[2], abs=5e-3)
    assert 0.90 < speeds[2] < 0.99


class TestTank:
    @each("volts", [4.0, 8.0, -4.0])
    def test_a_dropped_center_tank_drive_turns_on_the_spot_at_the_speed_of_its_treads(self, volts):
        """The middle wheels are at its center and do not scrub: omega = tread speed over half the track width."""
        drive = TankDrive(TankConfig())
        robot = DriveBench(drive)
        drive.set_volts(-volts, volts)
        robot.run(2.0)
        assert robot.omega == pytest.approx(drive.wheel_speeds()[-1] / 0.28, rel=0.01)
        assert abs(drive.wheel_speeds()[-1]) > 0.85 * drive.max_speed * abs(volts) / 12.0
        assert robot.speed < 0.05

    @pytest.mark.parametrize("turn", [1.0, -1.0])
    def test_a_dropped_center_tank_drive_follows_commanded_curves(self, turn):
        """At 2 m/s it is commanded to turn at 1 rad/s, for which treads without scrub differ by 0.56 m/s."""
        drive = TankDrive(TankConfig())
        robot = DriveBench(drive)
        drive.set_chassis_speeds(2.0, turn)
        robot.run(3.0)
        assert robot.speed == pytest.approx(2.0, rel=0.05)
        assert robot.omega == pytest.approx(turn, rel=0.1)

    def test_six_level_wheels_turn_by_scrubbing(self):
        drive = TankDrive(TankConfig(dropped_center=False))
        robot = DriveBench(drive)
        drive.set_volts(-8.0, 8.0)
        robot.run(1.0)
        assert robot.omega > 1.0
        assert robot.speed < 0.05
        # The wheels are faster than the robot's turn: they scrub.
        assert drive.wheel_speeds()[-1] >= robot.omega * 0.28 * 0.95

    def test_a_tank_drive_that_slides_sideways_decelerates_by_g(self):
        robot = DriveBench(TankDrive(TankConfig()))
        robot.reset(vy=2.0)
        robot.step(0.005)
        assert robot.ay == pytest.approx(-GRAVITY, rel=1e-3)

    @pytest.mark.parametrize("bad", [math.nan, None])
    def test_invalid_commands_and_configs_are_refused(self, bad):
        drive = TankDrive(TankConfig())
        with pytest.raises(NonFiniteError, match="right"):
            drive.set_volts(1.0, bad)
        with pytest.raises(ConfigError, match="motors_per_side"):
            TankConfig(motors_per_side=0)
        with pytest.raises(ConfigError, match="dropped_center must be True or False, got 1"):
            TankConfig(dropped_center=1)


def test_a_drive_can_start_with_rolling_wheels():
    """Each wheel points along its direction of travel and turns at its speed: no wheel slips, and forces are small."""
    drive = drive_of()
    drive.reset(vx=2.0, vy=-1.0, omega=1.5)

    ways = [(2.0 - 1.5 * y, -1.0 + 1.5 * x) for x, y in drive.config.positions]
    assert drive.wheel_speeds() == pytest.approx([math.hypot(*way) for way in ways])
    assert drive.wheel_angles() == pytest.approx([math.atan2(wy, wx) for wx, wy in ways])
    drive.set_module_states(drive.wheel_speeds(), drive.wheel_angles())
    assert max(map(abs, hold(drive, 0.001, (2.0, -1.0, 1.5)))) < 0.01


def test_a_rolling_start_with_given_steer_angles_has_wheel_speeds_along_these_angles():
    drive = drive_of()
    drive.reset(angles=[math.pi / 3] * 4, vx=2.0)
    assert drive.wheel_speeds() == pytest.approx([1.0] * 4)
    with pytest.raises(NonFiniteError, match="vy"):
        drive.reset(vy=math.nan)


def test_a_tank_drive_can_start_with_rolling_sides():
    drive = TankDrive(TankConfig(trackwidth=0.6))
    drive.reset(vx=1.0, omega=2.0)
    assert (drive.wheel_speeds()[0], drive.wheel_speeds()[-1]) == pytest.approx((0.4, 1.6))
    assert drive.wheel_speeds() == pytest.approx([0.4] * 3 + [1.6] * 3)
    assert drive.wheel_distances() == [0.0] * 6


def test_swerve_and_tank_drives_provide_the_same_kinds_of_readings():
    swerve, tank = drive_of(), TankDrive(TankConfig())
    swerve.set_volts([6.0] * 4, [0.0] * 4)
    tank.set_volts(6.0, 3.0)
    for drive in (swerve, tank):
        for _ in range(2):
            hold(drive, 0.005, (0.0, 0.0, 3.0))
        assert drive.time == pytest.approx(0.01)
        assert len(drive.wheel_distances()) == len(drive.wheel_angles()) == len(drive.config.positions)
        assert {k: len(v) for k, v in drive.motor_currents().items()} == {k: len(v) for k, v in drive.gearing.items()}
    assert set(swerve.motor_currents()) == {"drive", "steer"}
    left, right = tank.motor_currents().values()
    assert left[0] == left[1] > right[0] > 0.0
    assert tank.supply_current == pytest.approx(tank.battery.current)


# --- kinematics of the on-board loops ---------------------------------------------------------------------------------


def test_optimize_turns_a_module_by_at_most_a_quarter_turn():
    assert optimize(2.0, 3.0, 0.0) == pytest.approx((-2.0 * math.cos(3.0 - math.pi), 3.0 - math.pi))
    assert optimize(2.0, 0.3, 4 * math.pi) == pytest.approx((2.0 * math.cos(0.3), 0.3))


def test_desaturate_keeps_the_ratios_of_speeds():
    assert desaturate([4.0, -8.0], 4.0) == [2.0, -4.0]
    assert desaturate([1.0], 4.0) == [1.0]


def test_modules_point_along_the_circle_when_the_robot_turns_on_the_spot():
    positions = [(0.3, 0.3), (-0.3, 0.3)]
    speeds, angles = module_targets(positions, 0.0, 0.0, 2.0, 5.0, [0.0, 0.0])
    assert speeds == pytest.approx([0.6 * math.sqrt(2)] * 2)
    assert angles == pytest.approx([math.radians(135), math.radians(-135)])


def test_modules_without_speed_keep_their_angles():
    assert module_targets([(0.3, 0.3)], 0.0, 0.0, 0.0, 5.0, [1.2]) == ([0.0], [1.2])

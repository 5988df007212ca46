"""Findings of `simcore check`: REBUILT's robot with one mistake each, and test runs compared with closed forms."""

import math
from dataclasses import replace

import pytest
from each_case import each

from games.rebuilt import REBUILT
from simcore.robot.climber import ClimberConfig
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.intake import IntakeZone
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, place_text
from simcore.robot_file.needed_speeds import elevations
from simcore.robot_file.robot_findings import (
    CodeView,
    findings,
    holding_share,
    reading_unit,
    run_findings,
    run_mechanism,
    speed_text,
    top_exit_speed,
)
from simcore.world.linkage import Joint

ROBOT = REBUILT.robot()


def found(robot=ROBOT, game=REBUILT, **codes):
    return [finding.text for finding in findings(robot, game=game, codes=codes) if finding.is_wrong]


def with_intake(**change):
    zone = IntakeZone(**{"x_min": -0.5, "x_max": -0.35, "y_min": -0.3, "y_max": 0.3, "z_max": 0.2, **change})
    return replace(ROBOT, intakes=(replace(ROBOT.intakes[0], zone=zone, stretch=None, deploy=None),))


def with_shooter(**change):
    launch = {key: change.pop(key) for key in ("height", "forward", "heading", "pivot_x") if key in change}
    (shooter,) = ROBOT.shooters
    return replace(ROBOT, shooters=(replace(shooter, launch=replace(shooter.launch, **launch), **change),))


def with_climber(height, mass=2.0, gearing=60.0):
    lift = ElevatorConfig(
        gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=gearing, stator_current_limit=60.0),
        carriage_mass=mass, drum_radius=0.02, max_height=height,
    )  # fmt: skip
    joint = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), origin=(0.0, 0.0, 0.3), slides=True, ratio=0.02)
    return replace(
        ROBOT, mechanisms={**ROBOT.mechanisms, "lift": lift}, climbers=(ClimberConfig(joints=(joint,)),)
    )  # fmt: skip


def test_the_robot_of_the_game_has_no_findings():
    assert found() == [] and found(with_intake()) == [] and found(with_climber(0.5)) == []


@each(
    ("robot", "said"),
    [
        (with_intake(x_min=-0.38, x_max=-0.2), "intake 1 is inside of the bumpers, which no piece passes"),
        (with_intake(x_min=0.3, x_max=0.45), "intake 1 ends 50 mm outside of the bumpers; the middle of a piece that"),
        (with_intake(z_max=0.05), "intake 1 ends 0.05 m above the floor; the middle of a piece there is at 0.075 m"),
        (with_shooter(forward=0.55), "shooter 1: its muzzle is 150 mm outside of the robot, at (0.55, 0.08) m"),
        (with_shooter(forward=0.45, heading=math.pi), "at (-0.45, -0.08) m"),
        (with_shooter(wheel_radius=0.005), "from 2 m or more: at 12 V pieces leave at 2.3 m/s, and need "),
        (with_shooter(min_wheel_speed=1000.0), "shooter 1 never shoots: its wheels turn 150.8 times a second at 12 V"),
        (with_climber(0.5, gearing=5.0), "climber 1 cannot lift the robot: lift pulls with"),
    ],
)
def test_each_mistake_in_a_robot_is_found(robot, said):
    assert any(said in text for text in found(robot)), found(robot)


def test_the_findings_use_the_current_limit_in_the_program():
    (text,) = found(hood=CodeView(stator_limit=0.5))
    assert text.startswith("hood cannot hold itself: its weight needs ") and text.endswith("at their limit of 0.5 A")


def test_without_a_game_only_the_robot_is_checked():
    assert found(with_intake(z_max=0.05), game=None) == []


def test_the_top_exit_speed_is_rim_speed_at_motor_free_speed_times_efficiency():
    speed = ROBOT.mechanisms["shooter"].gearbox.free_speed(12.0) * 0.05 * 0.49
    assert top_exit_speed(ROBOT.shooters[0], ROBOT) == pytest.approx(speed)
    assert elevations(ROBOT.shooters[0], ROBOT) == pytest.approx((math.radians(45.0), math.radians(90.0)))


def test_a_gearing_mismatch_and_an_implausibly_slow_spin_up_are_reported():
    rack = ROBOT.mechanisms["intake_deploy"]

    def said(config=rack, **code):
        run = run_mechanism("rack", config, code=CodeView(**{"reading": 0.0, "ratio": 10.0, **code}))
        return [finding.text for finding in run_findings([(run, None)])]

    assert said() == []
    (ratio,) = said(ratio=12.5)
    assert ratio.endswith("divides the rotor's turns by 12.5: it reads 0.8 turns per turn of the mechanism")
    wheel = ROBOT.mechanisms["shooter"]
    (slow,) = said(replace(wheel, inertia=40.0), ratio=1.0)
    assert slow.startswith("rack takes ") and slow.endswith("look at inertia (40 kg m^2) and gearing (0.666667)")


# --- a second of each mechanism ---------------------------------------------------------------------------------------

MOTOR = motor("Kraken X60")


def gearbox(gearing: float = 2.0, **more: float) -> GearboxConfig:
    return GearboxConfig(motor=MOTOR, gearing=gearing, **more)


WHEEL = FlywheelConfig(gearbox=gearbox(), inertia=0.001)
RACK = RackConfig(gearbox=gearbox(20.0), mass=3.0, pinion_radius=0.02, travel=0.3)


def test_a_wheel_reaches_95_percent_of_its_free_speed_after_three_time_constants():
    run = run_mechanism("wheel", WHEEL)
    box = WHEEL.gearbox
    tau = WHEEL.inertia * box.resistance / (box.torque_per_amp * box.volts_per_speed)
    assert run.sign == 1.0 and not run.is_rising and run.stop is None
    assert run.speed == pytest.approx(box.free_speed(12.0), rel=1e-6)
    assert run.spin_up == pytest.approx(tau * math.log(20.0), abs=0.002), "a step"
    assert speed_text(run.mechanism, run.speed) == f"{box.free_speed(12.0) / math.tau:.1f} turns/s"


def test_the_reading_in_robot_code_has_the_configured_ratio_and_sign():
    """A ratio of half the gearing counts two turns per turn; reversed, the wheel turns back as the count goes up."""
    code = CodeView(ratio=1.0, reading=3.0)
    run = run_mechanism("wheel", WHEEL, code=code, reversed=True)
    assert run.sign == -1.0 and run.travel < 0.0
    assert run.read == pytest.approx((3.0, 3.0 - 2.0 * run.travel / math.tau))


def test_a_current_limit_in_the_program_slows_the_mechanism():
    """a = limit kt / J until the back-EMF takes over: with 5 A it has a fraction of the free speed after a second."""
    code = CodeView(ratio=2.0, reading=0.0, stator_limit=5.0)
    run = run_mechanism("wheel", FlywheelConfig(gearbox=gearbox(), inertia=0.01), code=code)
    assert run.speed == pytest.approx(5.0 * gearbox().torque_per_amp / 0.01, rel=1e-6)
    assert run.is_rising


def test_a_rack_reaches_its_stop():
    run = run_mechanism("rack", RACK)
    assert run.position * 0.02 == pytest.approx(0.3) and run.stop is not None
    assert run.stop > 0.3 / (RACK.gearbox.free_speed(12.0) * 0.02), "no faster than its free speed"
    assert place_text(run.mechanism, run.position) == "0.30 m"


@each(
    ("config", "per_turn", "unit"),
    [
        (RACK, 1.0, "turns"),
        (RACK, math.tau * 0.02, "m"),
        (RACK, math.tau * 0.02 / 0.0254, "in"),
        (WHEEL, 360.0, "deg"),
        (WHEEL, math.tau, "rad"),
        (WHEEL, math.tau * 0.02, None),
    ],
)
def test_the_unit_of_a_reading_follows_from_the_ratio(config, per_turn, unit):
    mechanism = run_mechanism("it", config).mechanism
    assert reading_unit(mechanism, CodeView(ratio=mechanism.gearing / per_turn)) == unit


def test_a_soft_limit_stops_a_mechanism_before_its_hard_stop():
    """The code reads turns of the pinion; 1.2 turns from the start are 0.151 m."""
    code = CodeView(ratio=20.0, reading=0.5, upper_limit=1.7, lower_limit=0.0)
    run = run_mechanism("rack", RACK, code=code)
    assert run.stop is None and run.soft_limit is not None
    assert run.travel == pytest.approx(1.2 * math.tau, rel=0.03), "within a step at full speed, and braking"
    back = run_mechanism("rack", RACK, code=code, output=-1.0)
    assert back.travel == 0.0 and back.soft_limit is None and back.stop is not None


def test_a_reading_that_counts_against_the_motion_of_its_mechanism_is_reported():
    """An arm starts at its upper stop, and the code counts up as the arm goes down."""
    arm = ArmConfig(
        gearbox=gearbox(20.0), inertia=0.05, min_angle=0.0, max_angle=0.5 * math.pi, start_angle=0.5 * math.pi
    )

    def said(turned=False, **code):
        view = CodeView(ratio=20.0, reading=0.0, **code)
        pair = [run_mechanism("pivot", arm, code=view, reversed=turned, output=output) for output in (1.0, -1.0)]
        runs = [tuple(pair) if not pair[0].travel else (pair[0], None)]
        return [(finding.is_wrong, finding.text) for finding in run_findings(runs)]

    assert said() == [] and said(turned=True) == []
    (wrong,) = said(lower_limit=0.0, upper_limit=0.25)
    assert (
        wrong[0]
        and "pivot cannot move either way" in wrong[1]
        and "(0 to 0.25 turns): does your code count" in wrong[1]
    )
    assert said(turned=True, lower_limit=0.0, upper_limit=0.25) == []


def test_the_holding_share_is_the_weight_torque_over_the_available_motor_torque():
    """m g c / (kt I) over its whole travel, whether or not it is ever level."""
    arm = ArmConfig(
        gearbox=gearbox(20.0, stator_current_limit=20.0), inertia=0.5, mass=8.0, center_of_mass=0.5,
        min_angle=-0.5, max_angle=1.0,
    )  # fmt: skip
    torque = 20.0 * arm.gearbox.torque_per_amp
    assert holding_share(arm) == pytest.approx(8.0 * 9.80665 * 0.5 / torque, rel=1e-4)
    steep = ArmConfig(
        gearbox=arm.gearbox, inertia=0.5, mass=8.0, center_of_mass=0.5, min_angle=1.0, max_angle=2.0
    )  # fmt: skip
    assert holding_share(steep) == pytest.approx(holding_share(arm) * math.cos(1.0), rel=1e-9)
    upside = ArmConfig(gearbox=arm.gearbox, inertia=0.5, mass=8.0, center_of_mass=0.5, min_angle=2.0, max_angle=4.0)
    assert holding_share(upside) == pytest.approx(holding_share(arm)), "level at 180 degrees"
    lift = ElevatorConfig(gearbox=gearbox(5.0), carriage_mass=10.0, drum_radius=0.02, max_height=1.0)
    torque = lift.gearbox.stall_torque(12.0)
    assert holding_share(lift) == pytest.approx(10.0 * 9.80665 * 0.02 / torque, rel=1e-4)
    assert holding_share(WHEEL) == 0.0

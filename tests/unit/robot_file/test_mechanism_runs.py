"""A second of each mechanism: direction, speed, stops and soft limits, against closed forms."""

from __future__ import annotations

import math

import pytest

from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig
from simcore.robot_file.mechanism_runs import (
    CodeView,
    holding_share,
    place_text,
    reading_unit,
    run_mechanism,
    speed_text,
)

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


def test_what_robot_code_reads_follows_its_ratio_and_reversal():
    """A ratio of half the gearing counts two turns for each; reversed, the wheel goes back while the code counts up."""
    code = CodeView(ratio=1.0, reading=3.0)
    run = run_mechanism("wheel", WHEEL, code=code, reversed=True)
    assert run.sign == -1.0 and run.travel < 0.0
    assert run.read == pytest.approx((3.0, 3.0 - 2.0 * run.travel / math.tau))


def test_a_current_limit_of_the_program_makes_it_slower():
    """a = limit kt / J until the back-EMF takes over: 5 A reach a fraction of the free speed within a second."""
    code = CodeView(ratio=2.0, reading=0.0, stator_limit=5.0)
    run = run_mechanism("wheel", FlywheelConfig(gearbox=gearbox(), inertia=0.01), code=code)
    assert run.speed == pytest.approx(5.0 * gearbox().torque_per_amp / 0.01, rel=1e-6)
    assert run.is_rising


def test_a_rack_meets_its_stop():
    run = run_mechanism("rack", RACK)
    assert run.position * 0.02 == pytest.approx(0.3) and run.stop is not None
    assert run.stop > 0.3 / (RACK.gearbox.free_speed(12.0) * 0.02), "no faster than its free speed"
    assert place_text(run.mechanism, run.position) == "0.30 m"


@pytest.mark.parametrize(
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
def test_a_ratio_that_has_the_drum_in_it_reads_meters(config, per_turn, unit):
    mechanism = run_mechanism("it", config).mechanism
    assert reading_unit(mechanism, CodeView(ratio=mechanism.gearing / per_turn)) == unit


def test_a_soft_limit_stops_it_before_its_stop():
    """The code reads pinion turns; 1.2 turns from where it starts are 0.151 m."""
    code = CodeView(ratio=20.0, reading=0.5, upper_limit=1.7, lower_limit=0.0)
    run = run_mechanism("rack", RACK, code=code)
    assert run.stop is None and run.soft_limit is not None
    assert run.travel == pytest.approx(1.2 * math.tau, rel=0.03), "within a step at full speed, and braking"
    back = run_mechanism("rack", RACK, code=code, output=-1.0)
    assert back.travel == 0.0 and back.soft_limit is None and back.stop is not None


def test_an_arm_that_is_too_heavy_has_a_share_above_one():
    """m g c / (kt I): over its whole travel, level or not."""
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

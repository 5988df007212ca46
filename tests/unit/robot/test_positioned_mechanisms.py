"""Pistons and servos: where they are, and when."""

from __future__ import annotations

import math

import pytest

from simcore.errors import ConfigError
from simcore.robot.mechanisms import PistonConfig, PistonSim, ServoConfig, ServoSim

STROKE, TIME = 0.3, 0.5


def settling(time: float, tau: float) -> float:
    """The way from rest over the final speed, with a time constant [s]."""
    return time - tau * (1.0 - math.exp(-time / tau))


@pytest.mark.parametrize("dt", [0.005, 0.02])
def test_a_piston_takes_its_stroke_time_each_way(dt):
    """It comes to speed with a time constant of a twentieth of that; steps are exact, whatever dt is."""
    piston = PistonSim(PistonConfig(stroke=STROKE, stroke_time=TIME))
    piston.set_volts(12.0)
    speed = STROKE / settling(TIME, TIME / 20.0)
    for k in range(1, round(TIME / dt)):
        piston.step(dt, battery_voltage=8.0)  # air, not the battery, moves it
        assert piston.extension == pytest.approx(speed * settling(k * dt, TIME / 20.0), rel=1e-9)
        assert piston.supply_current == 0.0
    assert piston.extension < 0.99 * STROKE
    piston.step(dt)
    assert piston.extension == pytest.approx(STROKE, rel=1e-12)
    piston.step(dt)
    assert (piston.extension, piston.velocity, piston.extended_fraction) == (STROKE, 0.0, 1.0)
    piston.set_volts(0.0)
    piston.step(1.0)
    assert piston.extension == 0.0


def test_without_power_a_single_valve_returns_by_its_spring_and_a_double_one_stays():
    def after_power_loss(**settings) -> float:
        piston = PistonSim(PistonConfig(stroke=STROKE, stroke_time=TIME, **settings))
        piston.set_volts(-12.0 if settings.get("springs_out") else 12.0)
        piston.step(1.0)
        piston.coast()
        piston.step(1.0)
        return piston.extension

    assert after_power_loss() == 0.0
    assert after_power_loss(springs_out=True) == STROKE
    assert after_power_loss(is_double=True) == STROKE


def test_a_piston_stays_where_it_starts():
    for start, where in ((False, 0.0), (True, STROKE)):
        piston = PistonSim(PistonConfig(stroke=STROKE, stroke_time=TIME, is_double=True, starts_extended=start))
        piston.step(1.0)
        assert piston.extension == where


SERVO = ServoConfig(min_angle=-1.0, max_angle=2.0, speed=6.0, start_angle=-0.5)
TAU = 0.02


def test_a_servo_turns_at_its_speed_and_settles_without_overshoot():
    """At full voltage until 4 tau of its speed before the goal; from there critically damped."""
    servo = ServoSim(SERVO)
    servo.set_goal(1.5)
    for k in range(1, 50):
        servo.step(0.005)
        if servo.goal - servo.position > 4.0 * TAU * SERVO.speed:
            assert servo.position == pytest.approx(-0.5 + SERVO.speed * settling(0.005 * k, TAU), rel=1e-9)
            assert servo.velocity < SERVO.speed
    assert 5.9 < SERVO.speed * (1.0 - math.exp(-0.2 / TAU)) < SERVO.speed  # it was all but there
    highest = servo.position
    for _ in range(100):
        servo.step(0.005)
        highest = max(highest, servo.position)
    # 25/s twice over: half a second after it e^-12.5 (1 + 12.5) of 0.5 rad is left
    assert servo.position == pytest.approx(1.5, abs=1e-4)
    assert highest < 1.5 + 1e-4


def test_a_servo_keeps_within_its_travel_and_holds_still_without_a_signal():
    servo = ServoSim(SERVO)
    servo.set_goal(9.0)
    servo.step(0.1)
    held = servo.position
    servo.coast()
    servo.step(1.0)
    assert servo.position == held and servo.supply_current == 0.0
    servo.set_goal(9.0)
    servo.step(1.0)
    assert servo.position == pytest.approx(2.0, abs=1e-3)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: PistonConfig(stroke=0.0, stroke_time=1.0), "PistonConfig: stroke must be"),
        (lambda: PistonConfig(stroke=1.0, stroke_time=math.nan), "PistonConfig: stroke_time must be"),
        (lambda: ServoConfig(min_angle=1.0, max_angle=1.0, speed=1.0), "min_angle must be below max_angle"),
        (lambda: ServoConfig(min_angle=0.0, max_angle=1.0, speed=0.0), "ServoConfig: speed must be"),
        (lambda: ServoSim(SERVO).set_goal(math.nan), "goal"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(build, words):
    with pytest.raises(ConfigError, match=words):
        build()

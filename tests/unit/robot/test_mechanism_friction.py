"""Friction where nobody has measured it: what stops a mechanism that is let go, and when."""

from __future__ import annotations

import math

import pytest

from simcore.errors import ConfigError
from simcore.loop.robot_state import STEP
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig, default_friction, friction_from_volts, no_load_friction
from simcore.robot.mechanisms import ShaftSim

KRAKEN = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=3.0)


def with_friction(torque: float) -> GearboxConfig:
    return GearboxConfig(motor=KRAKEN.motor, motors=2, gearing=3.0, friction_torque=torque)


def test_a_mechanism_that_is_let_go_stops_as_coulomb_friction_says():
    """dw/dt = -T/J: it stands still after J w / T, having turned J w^2 / (2 T).

    In the millisecond in which it stops it turns w h / 2 instead of w^2 J / (2 T): T h^2 / (8 J) more at most.
    """
    torque, inertia, speed = default_friction(KRAKEN), 0.004, 150.0
    shaft = ShaftSim(with_friction(torque), inertia)
    shaft.reset(velocity=speed)
    shaft.coast()
    rest = inertia * speed / torque
    steps = math.ceil(rest / 0.005)
    for k in range(steps):
        assert shaft.velocity == pytest.approx(speed - torque / inertia * 0.005 * k, abs=1e-9)
        shaft.step(0.005)
    assert shaft.velocity == 0.0
    too_far = shaft.position - inertia * speed**2 / (2.0 * torque)
    assert -1e-9 < too_far < torque * STEP**2 / (8.0 * inertia) + 1e-9
    shaft.step(1.0)
    assert shaft.velocity == 0.0 and shaft.current == 0.0


def test_no_load_friction_gives_the_free_speed_and_current_of_the_datasheet():
    shaft = ShaftSim(with_friction(no_load_friction(KRAKEN)), 0.001)
    shaft.set_volts(12.0)
    shaft.step(30.0)
    assert shaft.velocity == pytest.approx(KRAKEN.motor.free_speed / 3.0, rel=1e-6)
    shaft.step(0.01)
    assert shaft.current == pytest.approx(2 * KRAKEN.motor.free_current, rel=1e-6)


def test_friction_from_a_ks_holds_up_to_that_voltage_and_no_further():
    torque = friction_from_volts(KRAKEN, -0.25)
    for volts, moves in ((0.2499, False), (0.2501, True)):
        shaft = ShaftSim(with_friction(torque), 0.001)
        shaft.set_volts(volts)
        shaft.step(0.1)
        assert (shaft.velocity > 0.0) is moves


def test_geared_mechanisms_have_at_least_the_friction_of_their_motors():
    assert default_friction(KRAKEN) == pytest.approx(friction_from_volts(KRAKEN, 0.2))
    assert default_friction(KRAKEN, has_gears=False) == no_load_friction(KRAKEN) < default_friction(KRAKEN)
    brushed = GearboxConfig(motor=motor("Bag"), gearing=1.0)  # 1.8 A of 53 A: 0.41 V
    assert default_friction(brushed) == no_load_friction(brushed)
    with pytest.raises(ConfigError, match="finite"):
        friction_from_volts(KRAKEN, math.nan)

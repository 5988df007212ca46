"""Loops that are left out because nothing has changed: the outcome is that of motors that never leave one out."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("phoenix6")

from simcore.phoenix6_emulator.emulated_device import EnableDelays
from simcore.phoenix6_emulator.emulator import Emulator

REQUESTS = (
    ("VoltageOut", {"output": 4.0}),
    ("VoltageOut", {"output": 0.0}),
    ("TorqueCurrentFOC", {"output": 30.0}),
    ("PositionVoltage", {"position": 2.0}),
    ("VelocityVoltage", {"velocity": 20.0}),
    ("VelocityTorqueCurrentFOC", {"velocity": -20.0}),
    ("MotionMagicVoltage", {"position": 1.0}),
    ("NeutralOut", {}),
    ("StaticBrake", {}),
    ("CoastOut", {}),
)


def build():
    from phoenix6.spns.spn_value import SpnValue as Spn

    world = Emulator(EnableDelays(enable=0.0, disable=0.0))
    world.cancoder(9)
    common = {
        Spn.SLOT0_K_P.value: 2.0,
        Spn.CONFIG_MOTION_MAGIC_CRUISE_VELOCITY.value: 5.0,
        Spn.CONFIG_MOTION_MAGIC_ACCELERATION.value: 20.0,
        Spn.CONFIG_SUPPLY_CURR_LIMIT_EN.value: 1,
        Spn.CONFIG_SUPPLY_CURRENT_LIMIT.value: 20.0,
        Spn.CONFIG_SUPPLY_CURRENT_LOWER_LIMIT.value: 10.0,
        Spn.CONFIG_SUPPLY_CURRENT_LOWER_TIME.value: 0.03,
    }
    special = {
        1: {Spn.CONFIG_NEUTRAL_MODE.value: 1},
        2: {Spn.SLOT0_K_I.value: 5.0},
        3: {Spn.CONFIG_VOLTAGE_OPEN_LOOP_RAMP_PERIOD.value: 0.2},
        4: {Spn.CONFIG_FEEDBACK_SENSOR_SOURCE.value: 1, Spn.CONFIG_FEEDBACK_REMOTE_SENSOR_ID.value: 9},
        5: {Spn.CONFIG_FORWARD_SOFT_LIMIT_ENABLE.value: 1, Spn.CONFIG_FORWARD_SOFT_LIMIT_THRESHOLD.value: 1.5},
    }
    for number in range(1, 8):
        world.talon(number).configure({**common, **special.get(number, {})})
    return world


def play(seed, leaves_out):
    """Half a second of a robot on which anything may change between two steps; what every motor put out and told.

    And the share of loops that could be left out.
    """
    rng = np.random.default_rng(seed)
    world = build()
    talons = [world.talon(number) for number in range(1, 8)]
    seen, same = [], []

    def between():
        same.extend(talon.rotor_rps == talon.settled_rps for talon in talons)
        if not leaves_out:
            for talon in talons:
                talon.settled_rps = math.nan

    world.every(0.004, between)  # cuts steps, as odometry does
    for _ in range(100):
        world.enable.feed(100 if rng.random() < 0.97 else 0)
        for number in range(1, 6):
            talon = world.talon(number)
            chance = rng.random()
            if chance < 0.10:
                kind, values = REQUESTS[rng.integers(len(REQUESTS))]
                talon.apply(kind, update_freq_hz=float(rng.choice([0.0, 100.0])), **values)
            elif chance < 0.15:
                talon.set_input("SupplyVoltage", float(rng.choice([8.0, 12.0])))
            elif chance < 0.20:
                talon.set_input("ForwardLimit", float(rng.integers(2)))
            elif chance < 0.25:
                talon.set_position(float(rng.choice([0.0, 1.0])))
            elif chance < 0.30:
                talon.set_input("RotorAcceleration", float(rng.choice([0.0, 10.0])))
            if rng.random() < 0.5:
                talon.raw, talon.rotor_rps = float(rng.choice([0.0, 1.0, 1.2])), float(rng.choice([0.0, -30.0, 40.0]))
        for number, leader in ((6, 1), (7, int(rng.integers(1, 4)))):
            if rng.random() < 0.1:
                world.talon(number).apply("Follower", leader_id=leader, motor_alignment=float(rng.integers(2)))
        world.cancoder(9).raw = float(rng.choice([0.0, 0.5]))
        between()
        world.step(0.005)
        for talon in talons:
            b = talon.bridge
            seen.append((b.volts, b.current, b.supply_current, b.duty, b.is_neutral, talon.pid_out, *talon.frame[:20]))
    return seen, sum(same) / len(same)


@pytest.mark.parametrize("seed", range(20))
def test_a_loop_that_is_left_out_would_have_changed_nothing(seed):
    lazy, share = play(seed, leaves_out=True)
    assert 0.1 < share < 0.9
    assert lazy == play(seed, leaves_out=False)[0]  # signed zeros are equal

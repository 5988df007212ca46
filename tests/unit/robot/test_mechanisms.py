"""Flywheel, roller, arm, elevator and rack: what each adds to the shaft."""

from __future__ import annotations

import math

import pytest

from simcore.errors import ConfigError
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    RackConfig,
    RackSim,
    RollerConfig,
)
from simcore.units import GRAVITY

BOX = GearboxConfig(motor=motor("Kraken X60"), gearing=20.0)


def arm(**changes) -> ArmSim:
    base = dict(gearbox=BOX, inertia=0.3, mass=3.0, center_of_mass=0.25, min_angle=-1.5, max_angle=1.5, start_angle=0.0)
    return ArmSim(ArmConfig(**{**base, **changes}))


def elevator(**changes) -> ElevatorSim:
    base = dict(gearbox=BOX, carriage_mass=8.0, drum_radius=0.02, max_height=1.5, start_height=0.5)
    return ElevatorSim(ElevatorConfig(**{**base, **changes}))


def rack(**changes) -> RackSim:
    return RackSim(RackConfig(**{**dict(gearbox=BOX, mass=4.0, pinion_radius=0.012, travel=0.3), **changes}))


def test_holding_volts_hold_arm_and_elevator():
    held_arm, held_elevator = arm(start_angle=0.4), elevator()
    held_arm.set_volts(held_arm.holding_volts)
    held_elevator.set_volts(held_elevator.holding_volts)
    for _ in range(100):
        held_arm.step(0.02)
        held_elevator.step(0.02)
    assert held_arm.position == pytest.approx(0.4, abs=1e-9)
    assert held_elevator.height == pytest.approx(0.5, abs=1e-9)


def test_coasting_elevator_falls_freely():
    """h = h0 - g t^2 / 2: the drum's inertia is the carriage's alone."""
    lift = elevator(start_height=1.4)
    lift.coast()
    for _ in range(10):
        lift.step(0.02)
    assert lift.height == pytest.approx(1.4 - 0.5 * GRAVITY * 0.2**2)
    assert lift.speed == pytest.approx(-GRAVITY * 0.2)


def test_elevator_keeps_its_weight_when_a_load_is_added():
    lift = elevator(start_height=1.0)
    lift.coast()
    lift.set_load(0.5 * 8.0 * GRAVITY * 0.02)
    lift.step(0.1)
    assert lift.speed == pytest.approx(-0.5 * GRAVITY * 0.1)


def test_coasting_arm_swings_like_a_pendulum():
    """Energy m g c sin(angle) + J w^2 / 2 stays: second order, (omega h)^2 / 12 of 11 J with omega^2 = m g c / J."""
    swinging = arm(min_angle=-4.0, max_angle=1.0, start_angle=-0.5)
    swinging.coast()
    lowest = math.inf
    for _ in range(200):
        swinging.step(0.02)
        energy = 3.0 * GRAVITY * 0.25 * math.sin(swinging.position) + swinging.kinetic_energy
        assert energy == pytest.approx(3.0 * GRAVITY * 0.25 * math.sin(-0.5), abs=5e-5)
        lowest = min(lowest, swinging.position)
    assert lowest == pytest.approx(-math.pi + 0.5, abs=1e-3)  # as high on the other side; seen every 20 ms


def test_arm_stays_stable_behind_a_stiff_gear():
    stiff = arm(gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=300.0), inertia=0.01)
    stiff.set_volts(1.0)
    for _ in range(20):
        stiff.step(0.02)
        assert abs(stiff.velocity) < 1.1 * stiff.gearbox.free_speed(1.0)


def test_arm_rests_on_its_stop():
    resting = arm(start_angle=-1.5)
    for _ in range(20):
        resting.step(0.02)
    assert (resting.position, resting.velocity, resting.current) == (-1.5, 0.0, 0.0)


def test_rack_goes_out_and_comes_back_between_its_stops():
    deploy = rack()
    deploy.set_volts(8.0)
    seen = []
    for _ in range(80):
        deploy.step(0.02)
        seen.append(deploy.extension)
    assert seen == sorted(seen)
    assert deploy.extension == pytest.approx(0.3)
    assert deploy.extended_fraction == pytest.approx(1.0)
    assert deploy.speed == 0.0
    deploy.set_volts(-8.0)
    for _ in range(80):
        deploy.step(0.02)
    assert deploy.extended_fraction == 0.0


@pytest.mark.parametrize(
    ("make", "change"),
    [
        (arm, {"inertia": -1.0}),
        (arm, {"mass": -1.0}),
        (arm, {"mass": math.nan}),
        (arm, {"min_angle": 2.0}),
        (arm, {"start_angle": 3.0}),
        (elevator, {"carriage_mass": 0.0}),
        (elevator, {"drum_radius": -0.1}),
        (elevator, {"start_height": 2.0}),
        (elevator, {"min_height": math.nan}),
        (rack, {"mass": -1.0}),
        (rack, {"pinion_radius": 0.0}),
        (rack, {"travel": math.nan}),
        (rack, {"start_extension": 1.0}),
    ],
)
def test_settings_that_cannot_work_are_refused(make, change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        make(**change)


def test_flywheel_and_roller_refuse_nonsense():
    with pytest.raises(ConfigError, match="inertia"):
        FlywheelConfig(gearbox=BOX, inertia=-0.1)
    with pytest.raises(ConfigError, match="radius"):
        RollerConfig(gearbox=BOX, inertia=0.1, radius=0.0)


def test_springs_carry_their_part_of_a_weight():
    """A carriage whose weight springs carry stays where it is; half of an arm's weight takes half the volts."""
    box = GearboxConfig(motor=motor("NEO"), motors=1, gearing=10.0)
    carriage = {"gearbox": box, "carriage_mass": 5.0, "drum_radius": 0.02, "max_height": 1.0, "start_height": 0.5}
    balanced, heavy, light = (
        ElevatorSim(ElevatorConfig(**carriage, spring_force=share * 5.0 * GRAVITY)) for share in (1.0, 0.9, 1.1)
    )
    for elevator in (balanced, heavy, light):
        elevator.coast()
        elevator.step(0.2)
    assert balanced.height == 0.5 and balanced.holding_volts == 0.0
    assert heavy.height < 0.5 < light.height
    arm = {"gearbox": box, "inertia": 0.5, "mass": 3.0, "center_of_mass": 0.4, "min_angle": -1.0, "max_angle": 1.0}
    whole, half = (ArmSim(ArmConfig(**arm, start_angle=0.0, spring_share=share)) for share in (0.0, 0.5))
    assert half.holding_volts == pytest.approx(0.5 * whole.holding_volts)
    with pytest.raises(ConfigError, match="spring_share"):
        ArmConfig(**arm, spring_share=1.5)

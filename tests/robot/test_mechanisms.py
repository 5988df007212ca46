"""Arm, elevator, rack, piston, servo and their friction agree with closed forms."""

import itertools
import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.loop.robot_state import STEP
from simcore.robot.dc_motor import motor
from simcore.robot.gearbox import GearboxConfig, default_friction, friction_from_volts, no_load_friction
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    PistonConfig,
    PistonSim,
    RackConfig,
    RackSim,
    RollerConfig,
    ServoConfig,
    ServoSim,
    ShaftSim,
)
from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
from simcore.robot.swerve_drive import SwerveDrive
from simcore.testing.benches import DriveBench
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


def test_the_holding_voltage_keeps_an_arm_and_an_elevator_at_rest():
    held_arm, held_elevator = arm(start_angle=0.4), elevator()
    held_arm.set_volts(held_arm.holding_volts)
    held_elevator.set_volts(held_elevator.holding_volts)
    for _ in range(100):
        held_arm.step(0.02)
        held_elevator.step(0.02)
    assert held_arm.position == pytest.approx(0.4, abs=1e-9)
    assert held_elevator.height == pytest.approx(0.5, abs=1e-9)


def test_a_coasting_elevator_falls_freely():
    """h = h0 - g t^2 / 2: the inertia at the drum is only the inertia of the carriage."""
    lift = elevator(start_height=1.4)
    lift.coast()
    for _ in range(10):
        lift.step(0.02)
    assert lift.height == pytest.approx(1.4 - 0.5 * GRAVITY * 0.2**2)
    assert lift.speed == pytest.approx(-GRAVITY * 0.2)


def test_an_elevator_keeps_its_weight_when_a_load_is_added():
    lift = elevator(start_height=1.0)
    lift.coast()
    lift.set_load(0.5 * 8.0 * GRAVITY * 0.02)
    lift.step(0.1)
    assert lift.speed == pytest.approx(-0.5 * GRAVITY * 0.1)


def test_a_coasting_arm_swings_like_a_pendulum():
    """m g c sin(angle) + J w^2 / 2 stays to second order: (omega h)^2 / 12 of 11 J, with omega^2 = m g c / J."""
    swinging = arm(min_angle=-4.0, max_angle=1.0, start_angle=-0.5)
    swinging.coast()
    lowest = math.inf
    for _ in range(200):
        swinging.step(0.02)
        energy = 3.0 * GRAVITY * 0.25 * math.sin(swinging.position) + swinging.kinetic_energy
        assert energy == pytest.approx(3.0 * GRAVITY * 0.25 * math.sin(-0.5), abs=5e-5)
        lowest = min(lowest, swinging.position)
    assert lowest == pytest.approx(-math.pi + 0.5, abs=1e-3)  # as high on the other side; read every 20 ms


def test_an_arm_rests_on_its_stop():
    resting = arm(start_angle=-1.5)
    for _ in range(20):
        resting.step(0.02)
    assert (resting.position, resting.velocity, resting.current) == (-1.5, 0.0, 0.0)


def test_a_rack_extends_and_retracts_between_its_stops():
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


@each(
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
def test_invalid_mechanism_configs_are_refused(make, change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        make(**change)


def test_a_flywheel_and_a_roller_refuse_invalid_values():
    with pytest.raises(ConfigError, match="inertia"):
        FlywheelConfig(gearbox=BOX, inertia=-0.1)
    with pytest.raises(ConfigError, match="radius"):
        RollerConfig(gearbox=BOX, inertia=0.1, radius=0.0)


def test_a_spring_carries_the_configured_fraction_of_the_weight():
    """A carriage balanced by springs stays in place; an arm balanced by half needs half the volts."""
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


# --- friction that nobody has measured: what stops a mechanism that is let go, and when -------------------------------


KRAKEN = GearboxConfig(motor=motor("Kraken X60"), motors=2, gearing=3.0)


def with_friction(torque: float) -> GearboxConfig:
    return GearboxConfig(motor=KRAKEN.motor, motors=2, gearing=3.0, friction_torque=torque)


def test_a_coasting_mechanism_is_stopped_by_coulomb_friction():
    """dw/dt = -T / J: it stops after J w / T, having turned by J w^2 / (2 T).

    In the millisecond in which it stops, it turns by w h / 2 instead of w^2 J / (2 T): at most T h^2 / (8 J) more.
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


def test_the_no_load_friction_gives_the_free_speed_and_current_of_the_datasheet():
    shaft = ShaftSim(with_friction(no_load_friction(KRAKEN)), 0.001)
    shaft.set_volts(12.0)
    shaft.step(30.0)
    assert shaft.velocity == pytest.approx(KRAKEN.motor.free_speed / 3.0, rel=1e-6)
    shaft.step(0.01)
    assert shaft.current == pytest.approx(2 * KRAKEN.motor.free_current, rel=1e-6)


def test_friction_from_a_ks_holds_a_shaft_up_to_that_voltage_and_no_further():
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


# --- pistons and servos: where they are, and when ---------------------------------------------------------------------


STROKE, TIME = 0.3, 0.5


def settling(time: float, tau: float) -> float:
    """Return the travel from rest over the final speed, for a time and a time constant [s]."""
    return time - tau * (1.0 - math.exp(-time / tau))


@pytest.mark.parametrize("dt", [0.005, 0.02])
def test_a_piston_takes_its_stroke_time_in_each_direction(dt):
    """The time constant of the speed is a twentieth of the stroke time; the steps are exact for any dt."""
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


def test_without_power_a_single_valve_returns_by_its_spring_and_a_double_valve_stays():
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


def test_a_piston_with_a_double_valve_stays_at_its_start_position_without_a_command():
    for start, where in ((False, 0.0), (True, STROKE)):
        piston = PistonSim(PistonConfig(stroke=STROKE, stroke_time=TIME, is_double=True, starts_extended=start))
        piston.step(1.0)
        assert piston.extension == where


SERVO = ServoConfig(min_angle=-1.0, max_angle=2.0, speed=6.0, start_angle=-0.5)
TAU = 0.02


def test_a_servo_turns_at_its_speed_and_settles_without_overshoot():
    """The servo turns at full voltage until 4 tau of its speed before the goal, and is critically damped from there."""
    servo = ServoSim(SERVO)
    servo.set_goal(1.5)
    for k in range(1, 50):
        servo.step(0.005)
        if servo.goal - servo.position > 4.0 * TAU * SERVO.speed:
            assert servo.position == pytest.approx(-0.5 + SERVO.speed * settling(0.005 * k, TAU), rel=1e-9)
            assert servo.velocity < SERVO.speed
    assert 5.9 < SERVO.speed * (1.0 - math.exp(-0.2 / TAU)) < SERVO.speed  # it had nearly reached it
    highest = servo.position
    for _ in range(100):
        servo.step(0.005)
        highest = max(highest, servo.position)
    # a double pole at 25/s: half a second later, e^-12.5 (1 + 12.5) of 0.5 rad is left
    assert servo.position == pytest.approx(1.5, abs=1e-4)
    assert highest < 1.5 + 1e-4


def test_a_servo_stays_within_its_travel_and_holds_still_without_a_signal():
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


@each(
    ("build", "words"),
    [
        (lambda: PistonConfig(stroke=0.0, stroke_time=1.0), "PistonConfig: stroke must be"),
        (lambda: PistonConfig(stroke=1.0, stroke_time=math.nan), "PistonConfig: stroke_time must be"),
        (lambda: ServoConfig(min_angle=1.0, max_angle=1.0, speed=1.0), "min_angle must be below max_angle"),
        (lambda: ServoConfig(min_angle=0.0, max_angle=1.0, speed=0.0), "ServoConfig: speed must be"),
        (lambda: ServoSim(SERVO).set_goal(math.nan), "goal"),
    ],
)
def test_invalid_piston_and_servo_values_are_refused(build, words):
    with pytest.raises(ConfigError, match=words):
        build()


def test_a_stalled_falcon_at_4_volts_has_the_torque_measured_by_its_vendor():
    """A Falcon at 4 V has 2.15 N m on its vendor's dynamometer."""
    falcon = GearboxConfig(motor=motor("Falcon 500"), gearing=1.0)
    shaft = ShaftSim(falcon, inertia=1000.0)
    shaft.set_volts(4.0)
    shaft.step(0.02, 12.0)
    assert falcon.torque_per_amp * shaft.current == pytest.approx(2.15, rel=0.05)


@each(
    "name, volts, share",
    itertools.product(["Falcon 500", "Kraken X60", "NEO"], [-12.0, -4.0, 2.0, 8.0, 12.0], [-0.4, 0.0, 0.3, 0.9]),
)
def test_a_mechanism_and_a_drivetrain_use_the_same_motor_model(name, volts, share):
    """I = (V - e) / R behind the controller, or (V_bus - e) / R of the whole circuit where its duty is full.

    Both motors turn at a share of the free speed; their currents agree within the effect of inertia in 1 ms.
    """
    model = motor(name)
    shaft = ShaftSim(GearboxConfig(motor=model, gearing=6.0), inertia=1000.0)
    module = SwerveModuleConfig(
        x=0.0, y=0.0, drive_motor=model, drive_gearing=6.0, wheel_inertia=100.0, drive_friction_volts=0.0,
        drive_efficiency=1.0, drive_stator_limit=math.inf, drive_supply_limit=math.inf,
    )  # fmt: skip
    bench = DriveBench(SwerveDrive(SwerveConfig.square(0.53, module)))
    bench.lift()
    rate = share * model.free_speed / 6.0
    shaft.velocity = rate
    shaft.set_volts(volts)
    bench.drive.shafts["speed"][:4] = rate
    bench.drive.set_volts([volts] * 4, [0.0] * 4)
    bench.step(0.001)
    bus = bench.drive.bus_voltage
    shaft.step(0.001, bus)
    emf = share * model.free_speed / model.kv
    wanted = max(-bus, min(bus, volts))
    amps = (wanted - emf) / model.winding_resistance
    if wanted * (wanted - emf) > 0.0:
        full = (math.copysign(bus, wanted) - emf) / model.resistance
        amps = min(amps, full, key=abs)
    expected = pytest.approx(amps, rel=2e-3, abs=0.1)
    assert shaft.current == expected
    assert bench.drive.shafts["current"][:4].tolist() == [expected] * 4

"""Our mechanisms against WPILib's simulations of the same plant: speeds within 0.5 %, t90 within 5 ms."""

from __future__ import annotations

import math

import pytest
from scipy.integrate import solve_ivp
from wpimath.system.plant import DCMotor, LinearSystemId

from simcore.robot.gearbox import GearboxConfig
from simcore.robot.mechanisms import (
    ArmConfig,
    ArmSim,
    ElevatorConfig,
    ElevatorSim,
    FlywheelConfig,
    FlywheelSim,
    ShaftSim,
)
from simcore.units import GRAVITY

pytestmark = pytest.mark.engines("bullet")

simulation = pytest.importorskip("wpilib.simulation", reason="wpilib is not installed: nothing to compare with")

DT = 0.001
VOLTS = [12.0] * 300 + [-6.0] * 300 + [0.0] * 300


def compare(ours, theirs, our_speed, their_speed, *, volts=VOLTS, tolerance=0.005):
    """Compare two series of speeds; the tolerance is relative to the highest speed."""
    pairs = []
    for v in volts:
        ours.set_volts(v)
        ours.step(DT)
        theirs.setInputVoltage(v)
        theirs.update(DT)
        pairs.append((our_speed(), their_speed()))
    top = max(abs(b) for _, b in pairs)
    worst = max(abs(a - b) for a, b in pairs)
    assert worst <= tolerance * top, f"worst difference {worst}, top speed {top}"
    return pairs


def t90(speeds):
    end = speeds[-1]
    return next(i for i, speed in enumerate(speeds) if speed >= 0.9 * end) * DT


@pytest.fixture(autouse=True)
def full_battery():
    simulation.RoboRioSim.setVInVoltage(12.0)


@pytest.mark.parametrize(("motors", "gearing", "inertia"), [(1, 1.0, 0.001), (4, 24 / 36, 0.02), (2, 12.0, 0.5)])
def test_a_motor_matches_dc_motor_sim(motors, gearing, inertia):
    both = DCMotor.krakenX60(motors)
    theirs = simulation.DCMotorSim(LinearSystemId.DCMotorSystem(both, inertia, gearing), both, [0.0, 0.0])
    ours = ShaftSim(GearboxConfig(motor=DCMotor.krakenX60(1), motors=motors, gearing=gearing), inertia)
    compare(ours, theirs, lambda: ours.velocity, theirs.getAngularVelocity)
    assert ours.position == pytest.approx(theirs.getAngularPosition(), rel=0.005)


def test_the_motor_current_matches_dc_motor_sim():
    """WPILib reports the instantaneous current, we the mean of the step: they differ by half a step's change."""
    both = DCMotor.krakenX60(4)
    theirs = simulation.DCMotorSim(LinearSystemId.DCMotorSystem(both, 0.02, 1.0), both, [0.0, 0.0])
    ours = ShaftSim(GearboxConfig(motor=DCMotor.krakenX60(1), motors=4, gearing=1.0), 0.02)
    ours.set_volts(12.0)
    theirs.setInputVoltage(12.0)
    for _ in range(100):
        ours.step(DT)
        theirs.update(DT)
        assert ours.current == pytest.approx(theirs.getCurrentDraw(), abs=0.03 * 4 * both.stallCurrent / 4)


def test_a_flywheel_and_its_t90_match_flywheel_sim():
    both = DCMotor.krakenX60FOC(4)
    theirs = simulation.FlywheelSim(LinearSystemId.flywheelSystem(both, 0.02, 24 / 36), both, [0.0])
    box = GearboxConfig(motor=DCMotor.krakenX60FOC(1), motors=4, gearing=24 / 36)
    ours = FlywheelSim(FlywheelConfig(gearbox=box, inertia=0.02))
    pairs = compare(ours, theirs, lambda: ours.velocity, theirs.getAngularVelocity, volts=[9.0] * 1500)
    assert t90([a for a, _ in pairs]) == pytest.approx(t90([b for _, b in pairs]), abs=0.005)


def test_a_weak_battery_limits_both_simulations_equally():
    simulation.RoboRioSim.setVInVoltage(7.0)
    both = DCMotor.krakenX60(1)
    theirs = simulation.FlywheelSim(LinearSystemId.flywheelSystem(both, 0.005, 1.0), both, [0.0])
    ours = FlywheelSim(FlywheelConfig(gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=1.0), inertia=0.005))
    for _ in range(500):
        ours.set_volts(12.0)
        ours.step(DT, battery_voltage=7.0)
        theirs.setInputVoltage(12.0)
        theirs.update(DT)
    assert ours.velocity == pytest.approx(theirs.getAngularVelocity(), rel=0.005)


@pytest.mark.parametrize(("gearing", "tolerance"), [(20.0, 0.005), (100.0, 0.01)])
@pytest.mark.parametrize("volts", [0.0, 2.0])
def test_an_arm_matches_single_jointed_arm_sim(gearing, tolerance, volts):
    """WPILib models the arm as a uniform rod: J = m l^2 / 3, center at l / 2, with g = 9.8.

    Above 100:1 WPILib's integrator is 0.6 % off in the first milliseconds (ours: 2e-6, see the next test).
    """
    length, mass = 0.5, 3.0
    inertia = mass * length**2 / 3
    theirs = simulation.SingleJointedArmSim(DCMotor.krakenX60(1), gearing, inertia, length, -1.2, 1.4, True, 0.3)
    ours = ArmSim(
        ArmConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), gearing=gearing),
            inertia=inertia,
            mass=mass,
            center_of_mass=length / 2,
            min_angle=-1.2,
            max_angle=1.4,
            start_angle=0.3,
            gravity=9.8,
        )
    )
    compare(
        ours, theirs, lambda: ours.velocity, theirs.getVelocity, volts=[volts] * 150 + [0.0] * 100, tolerance=tolerance
    )
    assert ours.position == pytest.approx(theirs.getAngle(), abs=0.002)


def test_an_arm_matches_the_differential_equation():
    motor, gearing, inertia, torque = DCMotor.krakenX60(1), 100.0, 0.25, 3.0 * GRAVITY * 0.25
    box = GearboxConfig(motor=motor, gearing=gearing)
    arm = ArmSim(ArmConfig(gearbox=box, inertia=inertia, mass=3.0, center_of_mass=0.25, min_angle=-1.5, max_angle=1.5))
    arm.reset(position=0.3)
    arm.set_volts(2.0)

    def law(_, y):
        amps = (2.0 - gearing * y[1] / motor.Kv) / motor.R
        return [y[1], (gearing * motor.Kt * amps - torque * math.cos(y[0])) / inertia]

    exact = solve_ivp(law, (0.0, 0.2), [0.3, 0.0], rtol=1e-10, atol=1e-12).y[:, -1]
    for _ in range(10):
        arm.step(0.02)
    assert [arm.position, arm.velocity] == pytest.approx(list(exact), rel=1e-4)


def test_an_arm_is_as_accurate_at_20_ms_as_at_1_ms():
    def end(dt):
        box = GearboxConfig(motor=DCMotor.krakenX60(1), gearing=40.0)
        arm = ArmSim(ArmConfig(gearbox=box, inertia=0.25, mass=3.0, center_of_mass=0.25, min_angle=-1.5, max_angle=1.5))
        arm.set_volts(3.0)
        for _ in range(round(0.16 / dt)):
            arm.step(dt)
        return arm.position, arm.velocity

    assert end(0.02) == pytest.approx(end(0.001), rel=0.005)


def test_an_elevator_matches_elevator_sim_up_down_and_at_the_stops():
    # Time constant 9 ms; below 3 ms WPILib's integrator is 0.7 % off after a change of voltage.
    theirs = simulation.ElevatorSim(DCMotor.krakenX60(2), 5.0, 8.0, 0.025, 0.0, 1.5, True, 0.2)
    ours = ElevatorSim(
        ElevatorConfig(
            gearbox=GearboxConfig(motor=DCMotor.krakenX60(1), motors=2, gearing=5.0),
            carriage_mass=8.0,
            drum_radius=0.025,
            max_height=1.5,
            start_height=0.2,
            gravity=9.8,
        )
    )
    compare(ours, theirs, lambda: ours.speed, theirs.getVelocity, volts=[5.0] * 300 + [-3.0] * 500)
    assert ours.height == pytest.approx(theirs.getPosition(), abs=0.005)
    assert ours.current == pytest.approx(-theirs.getCurrentDraw(), rel=0.02)  # our current has the sign of the torque

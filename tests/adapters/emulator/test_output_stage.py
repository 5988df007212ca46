"""Output stage and control laws against their equations."""

import math

import pytest

OHM, EMF = 12.0 / 483.0, 12.0 / (5800.0 / 60.0)


def put_out(bench, talon, request, seconds=0.04):
    bench.run(seconds, lambda: talon.set_control(request))
    return talon.get_motor_voltage().value


@pytest.mark.parametrize(
    ("unit", "request_of", "full", "read"),
    [
        ("voltage", lambda c, x: c.VoltageOut(12.0 * x), 12.0, "get_motor_voltage"),
        ("duty_cycle", lambda c, x: c.DutyCycleOut(x), 1.0, "get_duty_cycle"),
        ("torque", lambda c, x: c.TorqueCurrentFOC(300.0 * x), 300.0, "get_torque_current"),
    ],
)
def test_an_open_loop_ramp_rises_at_its_rate_and_restarts_after_neutral(bench, unit, request_of, full, read):
    """The output reaches full scale within the ramp's time: 12 V, duty cycle 1 or 300 A."""
    from phoenix6 import controls

    period = 1.0
    talon = bench.talon(**{f"open_loop_ramps__{unit}_open_loop_ramp_period": period})
    bench.hold(talon, rps=20.0)
    for _ in range(2):
        values = []
        bench.run(
            0.2,
            lambda seen=values: (
                talon.set_control(request_of(controls, 0.5)),
                seen.append(getattr(talon, read)().value),
            ),
        )
        slope = (values[-1] - values[-6]) / 0.1
        assert slope == pytest.approx(full / period, rel=1e-6)
        bench.run(0.04, lambda: talon.set_control(controls.NeutralOut()))


def test_a_ramp_continues_from_the_previous_requests_output(bench):
    from phoenix6 import controls

    talon = bench.talon(closed_loop_ramps__voltage_closed_loop_ramp_period=1.0, slot0__k_v=1.0)
    bench.hold(talon, rps=20.0)
    assert put_out(bench, talon, controls.VoltageOut(4.0)) == pytest.approx(4.0)
    assert put_out(bench, talon, controls.VelocityVoltage(10.0), 0.1) == pytest.approx(4.0 + 12.0 * 0.1, abs=0.13)


def test_a_loop_on_a_remote_sensor_runs_once_per_frame(bench):
    """A new setpoint takes effect with the sensor's next frame; a request of another kind starts with zero output."""
    from phoenix6 import controls, signals

    encoder = bench.device("CANcoder", 1)
    talon = bench.talon(
        slot0__k_p=10.0,
        feedback__feedback_remote_sensor_id=1,
        feedback__feedback_sensor_source=signals.FeedbackSensorSourceValue.FUSED_CANCODER,
    )
    period = 10  # loops of 1 ms, at 100 Hz
    bench.run(0.1, lambda: talon.set_control(controls.PositionVoltage(0.0)))

    def loops_until(volts):
        for k in range(3 * period):
            if talon.sim_state.motor_voltage == pytest.approx(volts, abs=1e-9):
                return k
            bench.emulator.step(0.001)
        raise AssertionError(f"never {volts} V")

    loops_until(0.0)
    encoder.sim_state.set_raw_position(-0.1)
    loops_until(1.0)  # a frame has just been read, so the next is one period away
    talon.set_control(controls.PositionVoltage(0.2).with_update_freq_hz(0))
    assert loops_until(3.0) == period
    talon.set_control(controls.PositionDutyCycle(-0.09).with_update_freq_hz(0))
    assert loops_until(0.0) == 1
    assert loops_until(0.1 * 12.0) == period - 1


@pytest.mark.parametrize("slot", [0, 1, 2])
@pytest.mark.parametrize("arm", [False, True])
def test_every_gain_of_every_slot_contributes_to_the_output(bench, slot, arm):
    """u = kS sign + kG cos + kV r' + kP e + kD e' + feed-forward."""
    from phoenix6 import controls, signals

    gains = dict(k_p=2.0, k_d=0.1, k_s=0.2, k_v=0.05, k_g=0.3)
    settings = {f"slot{slot}__{name}": value for name, value in gains.items()}
    settings[f"slot{slot}__gravity_type"] = signals.GravityTypeValue(int(arm))
    talon = bench.talon(**settings)
    bench.hold(talon, rotations=0.1, rps=1.5)
    request = controls.PositionVoltage(0.6, velocity=2.0, feed_forward=0.4, slot=slot)
    gravity = 0.3 * (math.cos(math.tau * 0.1) if arm else 1.0)
    expected = 0.2 + gravity + 0.05 * 2.0 + 2.0 * 0.5 + 0.1 * (2.0 - 1.5) + 0.4
    assert put_out(bench, talon, request) == pytest.approx(expected, abs=1e-6)
    assert talon.get_closed_loop_slot().value == slot
    assert talon.get_closed_loop_error().value == pytest.approx(0.5)
    assert talon.get_closed_loop_proportional_output().value == pytest.approx(1.0)
    assert talon.get_closed_loop_proportional_output().units == "V"
    assert talon.get_control_mode().value.name == "POSITION_VOLTAGE_FOC"


def test_a_velocity_loop_applies_kd_to_acceleration_and_ks_with_the_sign_of_its_goal(bench):
    from phoenix6 import controls, signals

    talon = bench.talon(
        slot0__k_d=0.1,
        slot0__k_a=0.02,
        slot0__k_s=0.3,
        slot0__static_feedforward_sign=signals.StaticFeedforwardSignValue.USE_CLOSED_LOOP_SIGN,
    )
    bench.hold(talon, rps=8.0)
    talon.sim_state.set_rotor_acceleration(10.0)
    # the goal is below the velocity, but the sign is that of the goal
    assert put_out(bench, talon, controls.VelocityVoltage(5.0, acceleration=20.0)) == pytest.approx(
        0.3 + 0.02 * 20.0 + 0.1 * (20.0 - 10.0), abs=1e-6
    )


@pytest.mark.parametrize(
    ("at", "goal", "error"), [(0.9, 0.1, 0.2), (0.0, 0.5, -0.5), (3.2, 0.1, -0.1), (0.0, 2.75, -0.25)]
)
def test_continuous_wrap_turns_in_the_shorter_direction(bench, at, goal, error):
    from phoenix6 import controls

    talon = bench.talon(slot0__k_p=1.0, closed_loop_general__continuous_wrap=True)
    bench.hold(talon, rotations=at)
    assert put_out(bench, talon, controls.PositionVoltage(goal)) == pytest.approx(error, abs=1e-6)


def test_an_integral_term_follows_its_equation_and_resets_when_disabled(bench):
    """The term is kI e t; it is kept when the goal changes and reset by another kind of request or by disabling."""
    from phoenix6 import controls

    talon = bench.talon(slot0__k_i=1.0)
    bench.hold(talon, rotations=-1.0)
    assert put_out(bench, talon, controls.PositionVoltage(0.0), 0.504) == pytest.approx(0.495, abs=0.011)
    held = put_out(bench, talon, controls.PositionVoltage(-1.0))
    assert put_out(bench, talon, controls.PositionVoltage(-1.0), 0.2) == pytest.approx(held, abs=1e-9)
    bench.run(0.02, enabled=False)
    assert put_out(bench, talon, controls.PositionVoltage(-1.0)) == 0.0


def test_a_missing_remote_sensor_stops_only_closed_loops_and_sets_a_fault(bench):
    from phoenix6 import controls, signals

    talon = bench.talon(
        slot0__k_p=5.0,
        feedback__feedback_remote_sensor_id=55,
        feedback__feedback_sensor_source=signals.FeedbackSensorSourceValue.REMOTE_CANCODER,
    )
    assert put_out(bench, talon, controls.VoltageOut(3.0)) == pytest.approx(3.0)
    assert put_out(bench, talon, controls.PositionVoltage(3.0)) == 0.0
    assert talon.get_fault_remote_sensor_data_invalid().value
    bench.device("CANcoder", 55)
    bench.run(0.02)
    assert not talon.get_fault_remote_sensor_data_invalid().value


def test_a_synced_cancoder_sets_the_zero_of_the_rotor(bench):
    from phoenix6 import signals

    encoder = bench.device("CANcoder", 3, magnet_sensor__magnet_offset=0.2)
    bench.run(0.02)
    talon = bench.talon(
        feedback__feedback_remote_sensor_id=3,
        feedback__feedback_sensor_source=signals.FeedbackSensorSourceValue.SYNC_CANCODER,
        feedback__rotor_to_sensor_ratio=10.0,
    )
    bench.hold(talon, rotations=5.0, rps=20.0)
    bench.run(0.02)
    assert encoder.get_position().value == pytest.approx(0.2)
    assert talon.get_position().value == pytest.approx(0.2 + 0.5, abs=1e-6)
    assert talon.get_velocity().value == pytest.approx(2.0)


def test_a_limit_switch_can_set_the_position(bench):
    talon = bench.talon(
        hardware_limit_switch__reverse_limit_autoset_position_enable=True,
        hardware_limit_switch__reverse_limit_autoset_position_value=9.0,
    )
    bench.hold(talon, rotations=2.0)
    bench.run(0.02)
    talon.sim_state.set_reverse_limit(True)
    bench.run(0.02)
    assert talon.get_position().value == pytest.approx(9.0)


def test_over_voltage_turns_the_output_off(bench):
    from phoenix6 import controls

    talon = bench.talon()
    bench.hold(talon, supply=18.0)
    assert put_out(bench, talon, controls.VoltageOut(3.0)) == 0.0
    assert talon.get_fault_over_supply_v().value


@pytest.mark.parametrize(
    ("request_of", "amps"),
    [
        (lambda c: c.VoltageOut(12.0), 40.0),
        (lambda c: c.DutyCycleOut(-1.0), -40.0),
        (lambda c: c.TorqueCurrentFOC(25.0), 25.0),
        (lambda c: c.TorqueCurrentFOC(-90.0), -40.0),
        (lambda c: c.CoastOut(), 0.0),
    ],
    ids=["volts", "duty cycle", "amperes", "amperes over the limit", "coast"],
)
def test_a_mechanism_obeys_its_controllers_limits_and_reports_its_current(bench, request_of, amps):
    from phoenix6 import controls, unmanaged

    from simcore.robot.dc_motor import motor
    from simcore.robot.gearbox import GearboxConfig
    from simcore.robot.mechanisms import FlywheelConfig, FlywheelSim
    from simcore.robotcode.makers.phoenix6.talon_motor import TalonFXMotorSim

    talon = bench.talon(current_limits__stator_current_limit_enable=True, current_limits__stator_current_limit=40.0)
    wheel = FlywheelSim(FlywheelConfig(gearbox=GearboxConfig(motor=motor("Kraken X60"), gearing=1.0), inertia=0.05))
    sim = TalonFXMotorSim(talon, wheel, inverted=False)
    for _ in range(20):
        unmanaged.feed_enable(0.1)
        talon.set_control(request_of(controls))
        bench.emulator.step(0.005)
        sim.update(0.005, 12.0)
    assert talon.sim_state.torque_current == pytest.approx(amps, abs=1e-6) == wheel.motor_output[1]
    assert talon.sim_state.motor_voltage == wheel.motor_output[0]
    assert talon.get_stator_current().value == pytest.approx(amps, abs=0.1)

"""Control patterns of CTRE's public Python examples, which teams copy first, each on a simulated plant."""

import math

import pytest

pytestmark = pytest.mark.usefixtures("bench")


def test_a_talonfx_in_open_loop_reaches_the_speed_of_its_duty_cycle(bench):
    """TalonFX example: a duty cycle from a joystick, and signals printed now and then."""
    from phoenix6 import controls

    talon = bench.talon()
    bench.spin(talon)
    request = controls.DutyCycleOut(0.0)
    position, velocity = talon.get_position(), talon.get_velocity()
    bench.run(1.5, lambda: talon.set_control(request.with_output(0.5)))
    assert velocity.refresh().value == pytest.approx(0.5 * 5800 / 60, rel=0.01)
    assert position.refresh().value > 20.0
    assert talon.get_duty_cycle().value == pytest.approx(0.5, abs=1e-6)
    assert (velocity.units, velocity.status.name) == ("rotations per second", "OK")
    assert talon.control_request is request


def test_followers_of_an_arcade_drive_match_the_speed_of_their_leaders(bench):
    """ArcadeDrive and TankDrive: leaders by duty cycle, right side inverted, rear motors as followers."""
    from phoenix6 import controls, signals

    clockwise = signals.InvertedValue.CLOCKWISE_POSITIVE
    left, rear_left = bench.talon(1), bench.talon(2)
    right, rear_right = bench.talon(3, motor_output__inverted=clockwise), bench.talon(4)
    plants = [bench.spin(talon) for talon in (left, rear_left, right, rear_right)]
    rear_left.set_control(controls.Follower(1, signals.MotorAlignmentValue.ALIGNED))
    rear_right.set_control(controls.Follower(3, signals.MotorAlignmentValue.ALIGNED))
    out = controls.DutyCycleOut(0.0)

    def drive():
        left.set_control(out.with_output(0.6 + 0.1))
        right.set_control(out.with_output(0.6 - 0.1))

    bench.run(1.5, drive)
    speeds = [plant["speed"] / math.tau for plant in plants]
    assert speeds[0] == pytest.approx(0.7 * 5800 / 60, rel=0.01)
    assert speeds[1] == pytest.approx(speeds[0], rel=0.002)
    assert speeds[2] == pytest.approx(-0.5 * 5800 / 60, rel=0.01)  # counter-clockwise simulation frame
    assert speeds[3] == pytest.approx(speeds[2], rel=0.002)
    assert rear_right.get_velocity().value == pytest.approx(-speeds[3], rel=0.01)  # reads like its leader


def test_velocity_closed_loops_hold_their_speed_in_volts_and_in_amperes(bench):
    """VelocityClosedLoop: slot 0 for voltage and slot 1 for torque current, each with kS; then neutral."""
    from phoenix6 import configs, controls

    config = configs.TalonFXConfiguration()
    config.slot0.with_k_s(0.1).with_k_v(0.12).with_k_p(0.11)
    config.slot1.with_k_s(2.5).with_k_p(5.0)
    config.voltage.with_peak_forward_voltage(8).with_peak_reverse_voltage(-8)
    config.torque_current.with_peak_forward_torque_current(40).with_peak_reverse_torque_current(-40)
    talon = bench.device("TalonFX", 1, config)
    bench.spin(talon)
    volts, amperes = controls.VelocityVoltage(0).with_slot(0), controls.VelocityTorqueCurrentFOC(0).with_slot(1)
    bench.run(2.0, lambda: talon.set_control(volts.with_velocity(40)))
    # steady state: kS + kV r + kP (r - v) = v ke
    ke = 12.0 / (5800 / 60)
    assert talon.get_velocity().value == pytest.approx((0.1 + 0.12 * 40 + 0.11 * 40) / (ke + 0.11), rel=1e-4)
    bench.run(2.0, lambda: talon.set_control(amperes.with_velocity(-30)))
    assert talon.get_velocity().value == pytest.approx(-30.5, abs=0.01)  # beyond by kS/kP: no load, so no torque
    assert talon.get_closed_loop_reference().value == pytest.approx(-30.0)
    assert talon.get_closed_loop_reference().units == "rotations per second"
    talon.set_control(controls.NeutralOut())
    bench.run(0.1)
    assert talon.get_torque_current().value == 0.0


def test_position_loops_reach_setpoints_with_voltage_and_torque_current_output(bench):
    """PositionClosedLoop: go to ten turns, then brake with StaticBrake."""
    from phoenix6 import configs, controls

    config = configs.TalonFXConfiguration()
    config.slot0.k_p, config.slot0.k_i, config.slot0.k_d = 2.4, 0.0, 0.1
    config.slot1.k_p, config.slot1.k_i, config.slot1.k_d = 60.0, 0.0, 6.0
    config.voltage.peak_forward_voltage, config.voltage.peak_reverse_voltage = 8.0, -8.0
    config.torque_current.peak_forward_torque_current = 120.0
    config.torque_current.peak_reverse_torque_current = -120.0
    talon = bench.device("TalonFX", 1, config)
    assert talon.set_position(0).is_ok()
    bench.spin(talon)
    bench.run(2.0, lambda: talon.set_control(controls.PositionVoltage(10.0).with_slot(0)))
    assert talon.get_position().value == pytest.approx(10.0, abs=0.02)
    bench.run(3.0, lambda: talon.set_control(controls.PositionTorqueCurrentFOC(-10.0).with_slot(1)))
    assert talon.get_position().value == pytest.approx(-10.0, abs=0.02)
    talon.set_control(controls.StaticBrake())
    bench.run(0.1)
    assert talon.get_motor_voltage().value == 0.0


@pytest.mark.parametrize("kind", ["MotionMagicVoltage", "MotionMagicExpoVoltage", "DynamicMotionMagicVoltage"])
def test_motion_magic_stays_within_its_limits_and_reaches_its_goal(bench, kind):
    """MotionMagic: a profile with cruise velocity, acceleration and jerk; its reference keeps the cruise velocity."""
    from phoenix6 import controls

    talon = bench.talon(
        feedback__sensor_to_mechanism_ratio=12.8,
        motion_magic__motion_magic_cruise_velocity=5.0,
        motion_magic__motion_magic_acceleration=10.0,
        motion_magic__motion_magic_jerk=100.0,
        motion_magic__motion_magic_expo_k_v=1.6,
        motion_magic__motion_magic_expo_k_a=0.3,
        slot0__k_s=0.25,
        slot0__k_v=1.6,
        slot0__k_a=0.01,
        slot0__k_p=60.0,
        slot0__k_d=0.5,
    )
    bench.spin(talon, inertia=0.0004)
    extra = (5.0, 10.0, 100.0) if kind.startswith("Dynamic") else ()
    request = getattr(controls, kind)(4.0, *extra)
    slopes = []

    def tick():
        talon.set_control(request)
        slopes.append(talon.get_closed_loop_reference_slope().value)

    bench.run(0.6, tick)
    assert talon.get_motion_magic_is_running().value
    bench.run(1.6, tick)
    assert max(slopes) <= 5.0 + 1e-9
    assert talon.get_position().value == pytest.approx(4.0, abs=0.01)
    assert talon.get_motion_magic_at_target().value


def test_a_fused_cancoder_sets_the_position_of_a_mechanism(bench):
    """FusedCANcoder: the encoder behind the gears gives the position with offset; the motor takes the short way."""
    from phoenix6 import configs, controls, signals

    config = configs.CANcoderConfiguration()
    config.magnet_sensor.magnet_offset = 0.4
    config.magnet_sensor.absolute_sensor_discontinuity_point = 0.5
    encoder = bench.device("CANcoder", 1, config)
    talon = bench.talon(
        1,
        feedback__feedback_remote_sensor_id=1,
        feedback__feedback_sensor_source=signals.FeedbackSensorSourceValue.FUSED_CANCODER,
        feedback__rotor_to_sensor_ratio=12.8,
        closed_loop_general__continuous_wrap=True,
        slot0__k_p=50.0,
        slot0__k_d=0.5,
    )
    bench.spin(talon, inertia=0.00006, encoder=encoder, gearing=12.8)
    bench.run(0.1)
    assert talon.get_position().value == pytest.approx(0.4, abs=1e-6)
    assert encoder.get_absolute_position().value == pytest.approx(0.4, abs=1e-6)
    bench.run(1.0, lambda: talon.set_control(controls.PositionVoltage(-0.4)))
    assert talon.get_position().value == pytest.approx(0.6, abs=0.003)  # forward through half a turn
    assert encoder.get_absolute_position().value == pytest.approx(-0.4, abs=0.003)
    assert not talon.get_fault_remote_sensor_data_invalid().value


def test_control_request_limits_and_limit_switches_stop_one_direction(bench):
    """ControlRequestLimits: a digital input limits one direction of a request, as limit switches do."""
    from phoenix6 import controls

    talon = bench.talon()
    request = controls.VoltageOut(3.0)

    def volts(output, **flags):
        bench.run(0.04, lambda: talon.set_control(controls.VoltageOut(output, **flags)))
        return talon.get_motor_voltage().value

    assert volts(request.output, limit_forward_motion=True) == 0.0
    assert volts(-3.0, limit_forward_motion=True) == pytest.approx(-3.0)
    assert volts(-3.0, limit_reverse_motion=True) == 0.0
    talon.sim_state.set_forward_limit(True)
    assert volts(3.0) == 0.0
    assert talon.get_fault_forward_hard_limit().value
    assert talon.get_forward_limit().value.name == "CLOSED_TO_GROUND"
    assert volts(3.0, ignore_hardware_limits=True) == pytest.approx(3.0)
    talon.sim_state.set_forward_limit(False)
    assert volts(3.0) == pytest.approx(3.0)
    assert talon.get_sticky_fault_forward_hard_limit().value
    talon.clear_sticky_fault_forward_hard_limit()
    bench.run(0.02)
    assert not talon.get_sticky_fault_forward_hard_limit().value


def test_a_soft_limit_stops_a_mechanism_just_beyond_the_limit(bench):
    from phoenix6 import controls, signals

    talon = bench.talon(
        feedback__sensor_to_mechanism_ratio=10.0,
        motor_output__neutral_mode=signals.NeutralModeValue.BRAKE,
        software_limit_switch__forward_soft_limit_enable=True,
        software_limit_switch__forward_soft_limit_threshold=2.0,
    )
    bench.spin(talon, inertia=0.0003)
    bench.run(2.0, lambda: talon.set_control(controls.VoltageOut(6.0)))
    assert 2.0 < talon.get_position().value < 2.6
    assert talon.get_fault_forward_soft_limit().value
    assert talon.get_velocity().value == pytest.approx(0.0, abs=0.05)


def test_current_limits_bound_stator_and_supply_current(bench):
    """CurrentLimits: 40 A of stator current from rest, and a lower supply limit after half a second at the limit."""
    from phoenix6 import controls

    talon = bench.talon(
        current_limits__stator_current_limit=40.0,
        current_limits__supply_current_limit=20.0,
        current_limits__supply_current_lower_limit=10.0,
        current_limits__supply_current_lower_time=0.5,
    )
    talon.configurator.apply(_on(talon, "stator_current_limit_enable", "supply_current_limit_enable"))
    bench.spin(talon, inertia=0.01)
    stator, supply = [], []

    def tick():
        talon.set_control(controls.VoltageOut(12.0))
        stator.append(talon.get_stator_current().value)
        supply.append(talon.get_supply_current().value)

    bench.run(6.0, tick)
    assert max(stator) == pytest.approx(40.0, abs=1.1)
    assert max(supply) == pytest.approx(20.0, abs=1.1)
    assert max(supply[-20:]) == pytest.approx(10.0, abs=1.1)
    at_limit = 0.02 * sum(amps > 19.2 for amps in supply)
    assert at_limit == pytest.approx(0.5, abs=0.06), "it is lowered after half a second"
    assert talon.get_fault_supply_curr_limit().value


def _on(talon, *names):
    """Return the controller's current limits with the named limits enabled."""
    from phoenix6 import configs

    limits = configs.CurrentLimitsConfigs()
    assert talon.configurator.refresh(limits).is_ok()
    for name in names:
        setattr(limits, name, True)
    return limits


def test_wait_for_all_returns_simultaneous_signals(bench):
    """WaitForAll: several signals at one rate; in simulated time they are available at once."""
    from phoenix6 import BaseStatusSignal, controls

    talons = [bench.talon(k) for k in (1, 2)]
    for talon in talons:
        bench.spin(talon)
        talon.set_control(controls.VoltageOut(3.0))
    wanted = [s for t in talons for s in (t.get_position(False), t.get_velocity(False))]
    assert BaseStatusSignal.set_update_frequency_for_all(250, wanted).is_ok()
    assert [s.get_applied_update_frequency() for s in wanted] == [250.0] * 4
    bench.run(0.213)
    assert BaseStatusSignal.wait_for_all(0.1, wanted).is_ok()
    assert len({s.timestamp.time for s in wanted}) == 1
    assert wanted[0].timestamp.get_latency() == 0.0
    now = BaseStatusSignal.get_latency_compensated_value(wanted[0], wanted[1])
    assert now == pytest.approx(talons[0].get_position().value, abs=1e-6)


def test_status_signals_age_until_they_are_refreshed(bench):
    """StatusSignals: a signal keeps its value until refreshed, and reports its age; its rate can be lowered."""
    from phoenix6 import hardware

    talon = bench.talon()
    bench.hold(talon, rotations=1.0)
    bench.run(0.05)
    position = talon.get_position()
    assert position.has_updated
    assert not position.has_updated
    bench.hold(talon, rotations=2.0)
    assert position.value == 1.0
    ages = []
    bench.run(0.1, lambda: ages.append(position.refresh().timestamp.get_latency()))
    assert position.refresh().value == 2.0
    assert all(0.0 <= age <= 0.010 for age in ages)  # 100 Hz
    assert hardware.ParentDevice.optimize_bus_utilization_for_all(talon).is_ok()
    assert position.get_applied_update_frequency() == 4.0
    position.set_update_frequency(50)
    assert position.get_applied_update_frequency() == 50.0
    talon.reset_signal_frequencies()
    assert position.get_applied_update_frequency() == 100.0
    assert talon.is_connected
    assert not talon.has_reset_occurred


def test_a_cancoder_counts_turns_and_its_position_can_be_set(bench):
    """CANcoder: position over several turns, absolute position within one, a new position, and magnet health."""
    from phoenix6 import signals

    encoder = bench.device("CANcoder", 1, magnet_sensor__sensor_direction=signals.SensorDirectionValue(0))
    state = encoder.sim_state
    state.set_raw_position(1.25)
    state.set_velocity(2.0)
    bench.run(0.02)
    assert (encoder.get_position().value, encoder.get_velocity().value) == (1.25, 2.0)
    assert encoder.get_absolute_position().value == 0.25
    encoder.set_position(0.4)
    assert encoder.get_position().wait_for_update(0.1).value == pytest.approx(0.4)
    assert encoder.get_magnet_health().value.name == "MAGNET_GREEN"


def test_a_pigeon_yaw_is_continuous_and_can_be_set(bench):
    """Pigeon2: yaw over several turns, set to a heading; attitude as a rotation."""
    gyro = bench.device("Pigeon2", 1)
    state = gyro.sim_state
    for degrees in range(0, 400, 50):
        state.set_raw_yaw(degrees)
    state.set_angular_velocity_z(90.0)
    bench.run(0.02)
    assert gyro.get_yaw().value == pytest.approx(350.0)
    assert gyro.get_angular_velocity_z_world().value == pytest.approx(90.0)
    gyro.set_yaw(144.0)
    assert gyro.get_yaw().wait_for_update(0.1).value == pytest.approx(144.0)
    rotation = gyro.get_rotation3d() if hasattr(gyro, "get_rotation3d") else gyro.getRotation3d()
    assert math.degrees(getattr(rotation, "z", None) or rotation.Z()) == pytest.approx(144.0, abs=1e-6)


def test_a_canrange_detects_an_object_with_hysteresis(bench):
    """CANrange: it detects closer than 0.4 m, and stays so up to 0.41 m."""
    sensor = bench.device("CANrange", 1)
    seen = []
    for distance in (0.1, 0.39, 0.405, 0.42, 0.40, 0.395, 0.385, 2.0):
        sensor.sim_state.set_distance(distance)
        bench.run(0.02)
        assert sensor.get_distance().value == pytest.approx(distance)
        seen.append(sensor.get_is_detected().value)
    assert seen == [True, True, True, False, False, False, True, False]  # as measured on CTRE's simulation


def test_a_candi_reads_its_pins_and_its_sensors(bench):
    """CANdi: digital pins with a close state, a pulse-width sensor and a quadrature sensor."""
    from phoenix6 import signals

    candi = bench.device("CANdi", 1, digital_inputs__s1_close_state=signals.S1CloseStateValue.CLOSE_WHEN_LOW)
    state = candi.sim_state
    closed = []
    for pin in (signals.S1StateValue.FLOATING, signals.S1StateValue.LOW, signals.S1StateValue.HIGH):
        state.set_s1_state(pin)
        bench.run(0.02)
        closed.append(candi.get_s1_closed().value)
    assert closed == [False, True, False]
    state.set_pwm1_position(0.3)
    state.set_raw_quadrature_position(1.5)
    bench.run(0.02)
    assert candi.get_pwm1_position().value == pytest.approx(0.3)
    assert candi.get_quadrature_position().value == pytest.approx(1.5)


def test_a_remote_limit_on_a_canrange_stops_a_roller(bench):
    from phoenix6 import controls, signals

    sensor = bench.device("CANrange", 5)
    talon = bench.talon(
        hardware_limit_switch__forward_limit_source=signals.ForwardLimitSourceValue.REMOTE_CANRANGE,
        hardware_limit_switch__forward_limit_remote_sensor_id=5,
    )
    sensor.sim_state.set_distance(1.0)
    bench.run(0.04, lambda: talon.set_control(controls.VoltageOut(4.0)))
    assert talon.get_motor_voltage().value == pytest.approx(4.0)
    sensor.sim_state.set_distance(0.1)
    bench.run(0.04)
    assert talon.get_motor_voltage().value == 0.0


def test_a_sysid_routine_ramps_the_voltage_of_its_motor(bench):
    """PhoenixSysId: a slow voltage ramp with its state in the signal log; nothing is written to disk here."""
    from phoenix6 import SignalLogger, controls

    talon = bench.talon()
    bench.spin(talon)
    SignalLogger.start()
    clock = iter(range(1000))
    request = controls.VoltageOut(0.0)

    def tick():
        SignalLogger.write_string("state", "quasistatic-forward")
        talon.set_control(request.with_output(0.02 * next(clock)))

    bench.run(4.0, tick)
    SignalLogger.stop()
    lag = 0.6  # V: 1 V/s behind a time constant of 0.13 s, and two frames
    assert talon.get_velocity().value * 12.0 / (5800 / 60) == pytest.approx(4.0, abs=lag)


def test_candle_requests_are_accepted(bench):
    """CANdle: colors and animations."""
    from phoenix6 import controls, signals

    lights = bench.device("CANdle", 1)
    assert lights.set_control(controls.SolidColor(0, 7, color=signals.RGBWColor(217, 30, 0))).is_ok()
    assert lights.set_control(controls.RainbowAnimation(8, 37, slot=0)).is_ok()


def test_a_talonfxs_outputs_voltage_only_with_a_configured_motor_arrangement(bench):
    """At 20 turns/s, 3 V give the current of a Minion; without a motor arrangement the output stays 0 V."""
    from phoenix6 import controls, signals

    arranged = bench.device("TalonFXS", 1, commutation__motor_arrangement=signals.MotorArrangementValue.MINION_JST)
    bare = bench.device("TalonFXS", 2)
    for talon in (arranged, bare):
        bench.hold(talon, rps=20.0)
    bench.run(0.05, lambda: [talon.set_control(controls.VoltageOut(3.0)) for talon in (arranged, bare)])
    assert arranged.get_torque_current().value == pytest.approx(19.5, abs=0.5)  # measured on CTRE's simulation
    assert bare.get_motor_voltage().value == 0.0

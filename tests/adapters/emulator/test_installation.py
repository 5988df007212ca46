"""Installation of the emulator behind the Phoenix 6 library, and errors that name unsupported calls."""

import ctypes
import math

import pytest


def test_uninstalling_restores_the_native_side_of_the_library(bench):
    from phoenix6.phoenix_native import Native

    from simcore.robotcode.emulator import install, installed, uninstall

    assert type(Native.instance()).__name__ == "EmulatedNative"
    assert install() is installed()
    uninstall()
    assert installed() is None
    assert type(Native._Native__instance).__name__ != "EmulatedNative"
    install()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            lambda table: [row for row in table if not row[0].endswith("get_signal")],
            "no function c_ctre_phoenix6_get_s",
        ),
        (
            lambda table: [
                (n, r, [*a, ctypes.c_bool]) if n.endswith("ControlVelocityVoltage") else (n, r, a) for n, r, a in table
            ],
            "VelocityVoltage takes 15 arguments and not 14",
        ),
    ],
)
def test_an_incompatible_phoenix6_raises_an_error_of_one_sentence(bench, monkeypatch, change, words):
    from phoenix6.phoenix_native import Native

    from simcore.robotcode.emulator.installation import SeamError, check_seam

    check_seam()
    monkeypatch.setattr(Native, "_Native__c_args", change(Native._Native__c_args))
    with pytest.raises(SeamError, match=words) as error:
        check_seam()
    assert "pip install 'phoenix6~=26.3.0'" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("cls", ["TalonFX", "TalonFXS", "CANcoder", "Pigeon2", "CANrange", "CANdi"])
def test_a_configuration_is_read_as_applied_and_a_full_configuration_resets_the_rest(bench, cls):
    from phoenix6 import configs

    from simcore.robotcode.emulator.emulated_device import parse_config

    make = getattr(configs, f"{cls}Configuration")
    device = bench.device(cls, 1)
    first = make()
    assert device.configurator.refresh(first).is_ok()
    wanted = make()
    if cls.startswith("TalonFX"):
        wanted.current_limits.stator_current_limit_enable = first.current_limits.stator_current_limit_enable
        wanted.current_limits.supply_current_limit_enable = first.current_limits.supply_current_limit_enable
    assert parse_config(first.serialize()) == parse_config(wanted.serialize())
    changed = make()
    changed.custom_params.custom_param0 = 42
    assert device.configurator.apply(changed).is_ok()
    assert device.configurator.refresh(first).is_ok()
    assert first.custom_params.custom_param0 == 42
    alone = configs.CustomParamsConfigs().with_custom_param1(7)
    assert device.configurator.apply(alone).is_ok()
    assert device.configurator.refresh(first).is_ok()
    assert (first.custom_params.custom_param0, first.custom_params.custom_param1) == (0, 7)
    assert device.configurator.apply(make()).is_ok()
    assert device.configurator.refresh(first).is_ok()
    assert (first.custom_params.custom_param0, first.custom_params.custom_param1) == (0, 0)


def test_applying_a_configuration_group_leaves_the_other_groups_unchanged(bench):
    from phoenix6 import configs

    talon = bench.talon(slot0__k_p=3.0)
    assert talon.configurator.apply(configs.Slot1Configs().with_k_p(0.1)).is_ok()
    back = configs.TalonFXConfiguration()
    assert talon.configurator.refresh(back).is_ok()
    assert back.slot0.k_p == 3.0
    assert back.slot1.k_p == pytest.approx(0.1, rel=1e-7)  # the device keeps single precision
    assert back.slot1.k_p != 0.1


def test_output_starts_49_ms_after_enabling_and_stops_86_ms_after_disabling(bench):
    """On the wall clock, output starts 49 ms after enabling and stops 86 ms after disabling."""
    from phoenix6 import controls, unmanaged

    from simcore.robotcode.emulator import EnableDelays
    from simcore.robotcode.emulator.emulated_device import EnableState

    bench.emulator.enable = EnableState(bench.emulator.clock, EnableDelays())
    talon = bench.talon()
    talon.set_control(controls.VoltageOut(3.0))
    bench.run(0.1, enabled=False)
    assert talon.sim_state.motor_voltage == 0.0
    times = []
    for _ in range(30):
        unmanaged.feed_enable(0.1)
        bench.emulator.step(0.005)
        times.append(talon.sim_state.motor_voltage != 0.0)
    assert times.index(True) in (9, 10)
    unmanaged.feed_enable(0.0)
    for k in range(30):
        bench.emulator.step(0.005)
        times[k] = talon.sim_state.motor_voltage != 0.0
    assert times.index(False) in (16, 17)


def test_a_request_sent_once_lasts_a_tenth_of_a_second(bench):
    from phoenix6 import controls

    talon = bench.talon()
    talon.set_control(controls.VoltageOut(3.0).with_update_freq_hz(0))
    bench.run(0.09)
    assert talon.sim_state.motor_voltage == pytest.approx(3.0)
    bench.run(0.02)
    assert talon.sim_state.motor_voltage == 0.0


@pytest.mark.parametrize("parts", [1, 2, 5])
def test_a_step_in_parts_equals_a_single_step(bench, parts):
    """A profile is a closed form of time, so 5 ms at once or in parts agree to the last digits."""
    from phoenix6 import configs, controls

    config = configs.TalonFXConfiguration()
    config.motion_magic.with_motion_magic_cruise_velocity(5).with_motion_magic_acceleration(20)
    config.slot0.with_k_p(2.0).with_k_d(0.1).with_k_v(0.1)
    talon = bench.device("TalonFX", 1, config)
    talon.set_control(controls.MotionMagicVoltage(1.0))
    out = []
    for k in range(40):
        bench.emulator.enable.feed(100)
        bench.hold(talon, rotations=0.3 * math.sin(0.1 * k), rps=2.0 * math.cos(0.1 * k))
        for _ in range(parts):
            bench.emulator.step(0.005 / parts)
        out.append(talon.sim_state.motor_voltage)
    if parts == 1:
        _WHOLE[:] = out
    assert out == pytest.approx(_WHOLE, abs=1e-9)


_WHOLE: list[float] = []


def test_scheduled_tasks_run_at_their_time_within_a_step(bench):
    seen = []
    clock = bench.emulator.clock
    cancel = bench.emulator.every(0.004, lambda: seen.append(round(clock.now, 6)))
    bench.emulator.step(0.010)
    bench.emulator.step(0.003)
    assert seen == [0.004, 0.008, 0.012]
    cancel()
    bench.emulator.step(0.010)
    assert len(seen) == 3


@pytest.mark.parametrize("mirror", [False, True])
def test_wpilib_sim_devices_mirror_outputs_on_request(bench, mirror):
    import hal
    from phoenix6 import controls

    from simcore import season
    from simcore.robotcode.emulator import EnableDelays, install, uninstall

    uninstall()
    bench.emulator = install(delays=EnableDelays(enable=0.0, disable=0.0), mirror=mirror)
    number = 40 + mirror  # the HAL keeps SimDevices by name
    talon = bench.talon(number)
    bench.hold(talon, rotations=3.0)
    bench.run(0.05, lambda: talon.set_control(controls.VoltageOut(3.0)))
    (hal.simPeriodicBefore if hasattr(hal, "simPeriodicBefore") else hal.sim_periodic_before)()
    sim_device = season.wpilib_simulation.SimDeviceSim
    volts = sim_device(f"CANMotor:Talon FX (v6)[{number}]").get_double("motorVoltage").get()
    rotor = sim_device(f"CANEncoder:Talon FX (v6)[{number}]/Rotor Sensor").get_double("position").get()
    assert (volts, rotor) == ((pytest.approx(3.0), pytest.approx(3.0)) if mirror else (0.0, 0.0))
    assert talon.sim_state.motor_voltage == pytest.approx(3.0)  # nothing was written back


def _scheduled():
    from phoenix6 import signals

    return signals.GainSchedBehaviorValue.USE_SLOT1


REFUSALS = {
    "differential": (
        lambda b, c: b.talon().set_control(c.DifferentialVoltage(1.0, 0.0)),
        r"DifferentialVoltage is not modelled .* --phoenix=real runs",
    ),
    "analog voltage": (lambda b, c: b.device("TalonFXS", 1).sim_state.set_analog_voltage(1.0), "AnalogVoltage"),
    "gain scheduling": (
        lambda b, c: (
            b.talon(2, slot0__gain_sched_behavior=_scheduled()),
            b.emulator.talon(2).apply("PositionVoltage", position=1.0),
        ),
        "gain scheduling",
    ),
    "a request that is no number": (
        lambda b, c: b.talon().set_control(c.VelocityVoltage(math.nan)),
        "talon fx 1: VelocityVoltage: velocity must be a number, got nan",
    ),
    "a rotor that is no number": (lambda b, c: b.talon().sim_state.set_rotor_velocity(math.nan), "RotorVelocity"),
}
"""Call and expected message of each refusal."""


@pytest.mark.parametrize("name", REFUSALS)
def test_the_error_names_an_unmodelled_feature_or_a_nan_value(bench, name):
    from phoenix6 import controls

    from simcore.errors import NonFiniteError

    call, words = REFUSALS[name]
    with pytest.raises(NonFiniteError if "number" in name else NotImplementedError, match=words):
        call(bench, controls)


def test_reported_versions_and_licences_equal_those_of_the_library(bench):
    from phoenix6 import unmanaged

    talon = bench.talon()
    assert (talon.get_version_major().value, talon.get_version_minor().value) == (26, 3)
    assert talon.get_is_pro_licensed().value
    assert talon.get_device_temp().value == pytest.approx(24.0)
    assert not talon.get_fault_hardware().value
    assert unmanaged.get_phoenix_version() == 0x1A0300


def test_stub_devices_accept_every_call(bench):
    from phoenix6 import controls, hardware

    talon = hardware.TalonFX.none()
    assert talon.set_control(controls.VoltageOut(3.0)).is_ok()
    assert talon.get_position().value == 0.0
    assert talon.get_position().status.is_ok()


def test_a_set_position_keeps_its_rotor_count_when_the_gear_ratio_changes(bench):
    """As on CTRE's simulation, setting a position sets the rotor count."""
    from phoenix6 import configs

    talon = bench.talon(feedback__sensor_to_mechanism_ratio=10.0)
    bench.hold(talon, rotations=20.0, rps=30.0)
    talon.set_position(7.0)
    bench.run(0.02)
    assert (talon.get_position().value, talon.get_rotor_position().value) == (pytest.approx(7.0), pytest.approx(70.0))
    assert talon.get_velocity().value == pytest.approx(3.0)
    talon.configurator.apply(configs.FeedbackConfigs().with_sensor_to_mechanism_ratio(5.0))
    bench.run(0.02)
    assert talon.get_position().value == pytest.approx(14.0)

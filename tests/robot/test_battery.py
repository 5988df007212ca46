import math

import pytest
from each_case import each

from simcore.errors import ConfigError
from simcore.loop import battery as loop_battery
from simcore.robot.battery import Battery, BatteryConfig


def draw(battery: Battery, h: float, amps: float, at_voltage: float = math.nan) -> float:
    """Draw for h [s] a current that was computed at a voltage; return the battery's voltage [V]."""
    loop_battery.draw(battery.records, 0, h, amps, at_voltage)
    battery.report()
    return battery.voltage


def test_a_load_drops_the_voltage_at_once_and_then_slowly():
    """V = V_open - R I - R_slow I (1 - exp(-t / tau)); the capacity is infinite."""
    c = BatteryConfig(capacity_ah=math.inf)
    battery = Battery(c)
    draw(battery, 1e-6, 100.0)
    assert battery.voltage == pytest.approx(c.full_voltage - c.resistance * 100.0, abs=1e-3)
    for _ in range(800):
        draw(battery, 0.01, 100.0)
    slow = c.recovery_resistance * 100.0 * (1.0 - math.exp(-8.0 / c.recovery_time))
    assert battery.voltage == pytest.approx(c.full_voltage - c.resistance * 100.0 - slow, abs=1e-5)
    draw(battery, 1e-6, 0.0)
    assert battery.voltage == pytest.approx(c.full_voltage - slow, abs=1e-5)
    draw(battery, 60.0, 0.0)
    assert battery.voltage == pytest.approx(c.full_voltage, abs=1e-3)


def test_the_charge_falls_by_the_ampere_hours_drawn_and_stays_in_range():
    battery = Battery(BatteryConfig(capacity_ah=10.0))
    for _ in range(3600):
        draw(battery, 1.0, 5.0)
    assert battery.charge == pytest.approx(0.5)
    draw(battery, 1e9, 5.0)
    assert battery.charge == 0.0
    draw(battery, 1e9, -5.0)
    assert battery.charge == 1.0, "what is fed back fills it and no more"
    draw(battery, 1e9, 5.0)
    battery.reset()
    assert battery.charge == 1.0


def made(**changes) -> Battery:
    return Battery(BatteryConfig(recovery_resistance=0.0, resistance=0.02, capacity_ah=math.inf, **changes))


def sag(battery: Battery, volts: float, h: float) -> bool:
    """Make one step at this terminal voltage; return whether the motors are off afterwards."""
    draw(battery, h, (12.9 - volts) / 0.02)
    return battery.browned_out


def test_a_brownout_begins_below_6_75_volts_and_ends_above_7_5_volts():
    """With steps as long as a heartbeat, the motors follow each step."""
    battery = made()
    seen = [sag(battery, volts, 0.02) for volts in (7.0, 6.8, 6.7, 7.0, 7.49, 7.51, 7.0)]
    assert seen == [False, False, True, True, True, False, False]
    assert battery.min_voltage == pytest.approx(6.7, abs=1e-6)
    assert (battery.brownouts, battery.off_time) == (1, pytest.approx(0.06))
    exact = Battery(BatteryConfig(full_voltage=12.5, empty_voltage=12.5, resistance=0.5, recovery_resistance=0.0))
    for amps, is_low in ((11.5, False), (11.75, True), (10.0, True), (9.75, False)):  # 6.75, 6.625, 7.5, 7.625 V
        draw(exact, 0.02, amps)
        assert exact.browned_out is is_low


@each("h", [0.00125, 0.0025, 0.005])
def test_motors_stop_and_restart_at_the_heartbeat_after_a_brownout_starts_or_ends(h):
    """A load that returns with the motors is on for half the time at any step.

    It is on until the next heartbeat and off until the following heartbeat. The tick of a brownout reports it.
    """
    battery = made()
    begun = []
    battery.on_brownout = lambda: begun.append((battery.voltage, battery.current))
    sag(battery, 12.0, h)
    drawing = 0
    steps = round(0.4 / h)
    for k in range(steps):
        if k % round(0.02 / h) == 0:
            battery.begin_tick()
        is_off = battery.browned_out
        drawing += not is_off
        sag(battery, 12.8 if is_off else 6.5, h)
    assert drawing * h == pytest.approx(0.2, abs=0.02)
    assert battery.off_time == pytest.approx(0.2, abs=0.02)
    assert battery.brownouts == 10 and begun == [pytest.approx((6.5, 320.0), abs=1e-6)] * 10
    assert battery.tick_browned_out


def test_a_voltage_dip_between_two_heartbeats_stops_no_motor():
    """The battery is at 6 V for 12 ms and back above 7.5 V before the roboRIO's flag is read."""
    battery = made()
    assert not any(sag(battery, volts, 0.004) for volts in (12.0, 6.0, 6.0, 6.0, 7.6, 12.0))
    assert battery.brownouts == 0 and battery.min_voltage == pytest.approx(6.0)


@pytest.mark.parametrize("h", [0.00125, 0.005])
def test_a_roborio_below_4_5_volts_resets_and_boots(h):
    """The roboRIO's capacitors last for 10 ms, not 15 ms, and the boot counts from the end of the sag."""
    battery = made(reboot_time=0.5)
    told = []
    battery.on_reset = lambda: told.append(battery.voltage)
    for seconds, volts in ((0.01, 4.4), (0.09, 12.0), (0.03, 4.4)):
        for _ in range(round(seconds / h)):
            sag(battery, volts, h)
        assert battery.resets == len(told) == (seconds == 0.03)
    off = 0
    while sag(battery, 12.0, h):
        off += 1
    assert off * h == pytest.approx(0.5, abs=0.02)
    assert told == [pytest.approx(4.4)]


@each("load", [0.005, 0.02, 0.1])
def test_a_load_proportional_to_voltage_settles_at_the_voltage_of_a_resistor(load):
    """Currents computed from the previous voltage alone overshoot at once: 12.9 V over 5 mohm would leave -38.7 V."""
    battery = Battery(BatteryConfig(recovery_resistance=0.0, capacity_ah=math.inf, brownout_enabled=False))
    divided = 12.9 * load / (load + battery.config.resistance)
    lowest = math.inf
    for _ in range(20):
        volts = battery.voltage
        lowest = min(lowest, draw(battery, 0.001, volts / load, volts))
    assert battery.voltage == pytest.approx(divided, rel=1e-4)
    assert battery.current == pytest.approx(divided / load, rel=1e-3)
    assert lowest > 0.99 * divided


def test_a_stiff_supply_never_sags():
    battery = Battery(BatteryConfig.stiff(12.0))
    assert draw(battery, 0.02, 5000.0) == 12.0
    assert not battery.browned_out


def test_a_battery_at_zero_volts_is_browned_out_from_the_start():
    assert Battery(BatteryConfig(full_voltage=0.0, empty_voltage=0.0)).browned_out


@each(
    "wrong",
    [
        {"resistance": -0.01},
        {"capacity_ah": 0.0},
        {"full_voltage": math.nan},
        {"initial_charge": 1.5},
        {"empty_voltage": 13.0},
        {"recovered_voltage": 5.0},
        {"heartbeat": -0.1},
        {"reset_hold": -0.1},
        {"reboot_time": -1.0},
    ],
)
def test_invalid_battery_values_are_refused(wrong):
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        BatteryConfig(**wrong)

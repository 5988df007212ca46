"""A robot's 12 V battery, and the roboRIO that switches off when it sags."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simcore.errors import ConfigError
from simcore.loop.battery import begin_battery, open_voltage
from simcore.loop.robot_state import BATTERY, records
from simcore.quantities import DELAY, DURATION, FRACTION, RESISTANCE, VOLTAGE_OR_NONE, Quantity, require_fields

__all__ = ["Battery", "BatteryConfig", "BrownoutLog"]

_log = logging.getLogger(__name__)

_SERIES = 5.0  # [s]; a brown-out that comes sooner after the last one is of the same series
_MOST = 3  # consumers that are named
_LEAST = 1.0  # [A]; what draws less is not named


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig:
    """An 18 Ah lead-acid battery with its cables, and the brown-out levels of the roboRIO that it feeds.

    Defaults: a good competition battery. 12.9 V fresh and rested and 11.7 V empty are the usual AGM table; 15 mohm
    inside plus 5 mohm of breaker and cable is what WPILib's `BatterySim` uses as well.
    """

    full_voltage: float = 12.9
    """Open circuit, full, rested [V]."""
    empty_voltage: float = 11.7
    """Open circuit, no charge left, rested [V]."""
    resistance: float = 0.020
    """Of battery, breaker and cable: the drop that comes and goes at once [ohm]."""
    recovery_resistance: float = 0.008
    """Of the slow part of the drop [ohm]; estimate, +-50 %."""
    recovery_time: float = 8.0
    """Time constant of the slow part [s]; estimate, +-50 %: a battery 'bounces back' within some seconds."""
    capacity_ah: float = 12.0
    """Charge that can be drawn at match currents [A h]; the 18 Ah on the label is a 20-hour figure."""
    initial_charge: float = 1.0
    """State of charge at the start [0..1]."""
    brownout_voltage: float = 6.75
    """Below this the roboRIO wants its outputs off, and with the next heartbeat motors turn with open circuits [V].
    roboRIO 2 default, software settable; a roboRIO 1 has 6.3 V."""
    recovered_voltage: float = 7.5
    """And restores them above this [V]. Source: NI roboRIO user manual, table 2."""
    heartbeat: float = 0.020
    """How often motor controllers on CAN hear whether they may run [s]: a dip between two heartbeats is never heard of,
    and what one of them has switched off stays off until the next. Source: WPILib documentation, "FRC CAN Device
    Specifications", and wpilib-docs #2308 (the roboRIO's flag is read back in a loop of 20 ms)."""
    reset_voltage: float = 4.5
    """Below this the roboRIO itself goes out, and boots when the voltage is back [V]. Source: NI roboRIO user manual,
    table 2, stage 3."""
    reset_hold: float = 0.015
    """For how long its own capacitors carry it below that [s]; estimate, +-50 %: nobody has published it, and at events
    robots with weak batteries brown out often, but hardly ever reboot (Chief Delphi 144371)."""
    reboot_time: float = 25.0
    """From the moment that the voltage is back until robot code moves motors again [s]; estimate, 15 to 40 s, by the
    size of the robot program."""
    brownout_enabled: bool = True
    """False: never cut the outputs (to study a motor, or to repeat a figure that ignores the roboRIO)."""

    def __post_init__(self) -> None:
        require_fields(
            self,
            "battery",
            full_voltage=VOLTAGE_OR_NONE,
            empty_voltage=VOLTAGE_OR_NONE,
            resistance=RESISTANCE,
            recovery_resistance=RESISTANCE,
            recovery_time=DURATION,
            capacity_ah=Quantity("A h", 0.0, 10_000.0, is_open=True, may_be_infinite=True),
            initial_charge=FRACTION,
            brownout_voltage=VOLTAGE_OR_NONE,
            recovered_voltage=VOLTAGE_OR_NONE,
            heartbeat=DELAY,
            reset_voltage=VOLTAGE_OR_NONE,
            reset_hold=DELAY,
            reboot_time=DURATION,
        )
        if self.empty_voltage > self.full_voltage:
            raise ConfigError(
                f"battery: empty_voltage must not exceed full_voltage, got {self.empty_voltage} > {self.full_voltage} V"
            )
        if self.recovered_voltage < self.brownout_voltage:
            raise ConfigError(
                "battery: recovered_voltage must not be below brownout_voltage, "
                f"got {self.recovered_voltage} < {self.brownout_voltage} V"
            )

    @staticmethod
    def stiff(voltage: float = 12.0) -> BatteryConfig:
        """A supply that never sags, for figures and tests."""
        return BatteryConfig(
            full_voltage=voltage,
            empty_voltage=voltage,
            resistance=0.0,
            recovery_resistance=0.0,
            brownout_enabled=False,
        )


class Battery:
    """State of one robot's battery: nothing is shared between robots.

    Open-circuit voltage falls with the charge drawn; behind it sit a resistance and one slow RC element
    (Thevenin model), so that a robot at rest sees its voltage come back over some seconds.

    What keeps a robot that draws too much from standing still is the heartbeat: motors stay on until the next one says
    that the voltage is low, and off until the one after, by which it has long recovered. Inductance of the cables
    (2 uH) and the controllers' capacitors (some mF) smooth over less than a millisecond and are left out.

    The loop of robots draws from it together with all motors of its robot (`simcore.loop.battery`).
    """

    __slots__ = ("_config", "_reported", "on_brownout", "on_reset", "records")

    def __init__(self, config: BatteryConfig | None = None) -> None:
        self.records = records(BATTERY)
        """Its record in the arrays of the loop, shape (1,)."""
        self._set(min_voltage=math.inf)
        self.config = config or BatteryConfig()
        self._reported = 0, 0
        self.on_brownout: Callable[[], None] | None = None
        """Called after a brown-out has begun; `noted` says of that moment."""
        self.on_reset: Callable[[], None] | None = None
        """Called after the roboRIO has gone out."""
        self.reset()

    @property
    def config(self) -> BatteryConfig:
        """What it is; another one counts from the next step on."""
        return self._config

    @config.setter
    def config(self, config: BatteryConfig) -> None:
        self._config = c = config
        model = self.records["model"]
        for name, value in {
            "full": c.full_voltage,
            "empty": c.empty_voltage,
            "resistance": c.resistance,
            "recovery_resistance": c.recovery_resistance,
            "recovery_time": c.recovery_time,
            "capacity": 3600.0 * c.capacity_ah,
            "brownout_voltage": c.brownout_voltage,
            "recovered_voltage": c.recovered_voltage,
            "heartbeat": c.heartbeat,
            "reset_voltage": c.reset_voltage,
            "reset_hold": c.reset_hold,
            "reboot_time": c.reboot_time,
            "browns_out": c.brownout_enabled,
        }.items():
            model[name] = value

    def _set(self, **values: float) -> None:
        for name, value in values.items():
            self.records[name] = value

    def _get(self, name: str) -> float:
        return float(self.records[name][0])

    def reset(self) -> None:
        """Swap in a rested battery with the initial charge; what has been lowest so far stays so."""
        self._set(charge=self.config.initial_charge)
        begin_battery(self.records, 0)
        self.begin_tick()
        self.report()

    def begin_tick(self) -> None:
        """Forget what has been lowest in the last tick."""
        self._set(tick_min_voltage=self.voltage, tick_was_off=self.browned_out)

    def report(self) -> None:
        """Call `on_brownout` and `on_reset` if one has begun since the last call."""
        before, self._reported = self._reported, (self.brownouts, self.resets)
        if self._reported[1] > before[1] and self.on_reset is not None:
            self.on_reset()
        if self._reported[0] > before[0] and self.on_brownout is not None:
            self.on_brownout()

    @property
    def voltage(self) -> float:
        """At the terminals, under the load of the last step [V]."""
        return self._get("voltage")

    @property
    def current(self) -> float:
        """Drawn in the last step [A]; negative while motors feed energy back."""
        return self._get("current")

    @property
    def noted(self) -> tuple[float, float]:
        """Voltage and current as the last brown-out or reset began [V, A]."""
        return self._get("noted_voltage"), self._get("noted_current")

    @property
    def min_voltage(self) -> float:
        """Lowest since the start [V]."""
        return self._get("min_voltage")

    @property
    def tick_min_voltage(self) -> float:
        """Lowest since the tick began [V]."""
        return self._get("tick_min_voltage")

    @property
    def browned_out(self) -> bool:
        """Whether motor controllers keep their bridges off, as the last heartbeat has it."""
        return bool(self.records["is_off"][0])

    @property
    def tick_browned_out(self) -> bool:
        """Whether outputs were off at any moment since the tick began."""
        return bool(self.records["tick_was_off"][0])

    @property
    def brownouts(self) -> int:
        """How many times motors began to be off, since the start."""
        return int(self.records["brownouts"][0])

    @property
    def off_time(self) -> float:
        """For how long they were, since the start [s]."""
        return self._get("off_time")

    @property
    def resets(self) -> int:
        """How often the roboRIO went out and had to boot, since the start."""
        return int(self.records["resets"][0])

    @property
    def charge(self) -> float:
        """State of charge [0..1]."""
        return self._get("charge")

    @property
    def energy(self) -> float:
        """Given at the terminals since the last reset [J]."""
        return self._get("energy")

    @property
    def open_voltage(self) -> float:
        """What the terminals would show if the load vanished now: the voltage behind the resistance [V]."""
        return float(open_voltage(self.records, 0))


class BrownoutLog:
    """Writes one line when a series of brown-outs begins, with what drew the current, and a count at the end.

    A reset of the roboRIO, which ends most matches, has a line of its own, every time.

    Args:
        number: Of the robot.
        battery: That is watched.
        consumers: What each consumer drew as the last brown-out began, by name [A].
    """

    def __init__(self, number: int, battery: Battery, consumers: Callable[[], Mapping[str, float]]) -> None:
        self._number = number
        self._battery = battery
        self._consumers = consumers
        self._first = self._reset = ""  # of the present tick, in words
        self._last = -_SERIES
        battery.on_brownout, battery.on_reset = self._note, self._note_reset

    def _note(self) -> None:
        self._first = self._first or self._in_words()

    def _note_reset(self) -> None:
        self._reset = self._in_words()

    def _in_words(self) -> str:
        largest = sorted(self._consumers().items(), key=lambda one: -one[1])[:_MOST]
        named = ", ".join(f"{name} {amps:.0f} A" for name, amps in largest if amps > _LEAST)
        volts, amps = self._battery.noted
        return f"{volts:.1f} V with {amps:.0f} A" + (f", {named}" if named else "")

    def after_tick(self, time: float) -> None:
        """Tell of a reset, and of a series that has begun, in a tick that ended at a time [s]."""
        if self._reset:
            _log.warning(
                "robot %d: roboRIO reset at %.1f s: %s; no motor runs for %.0f s",
                *(self._number, time, self._reset, self._battery.config.reboot_time),
            )
            self._reset = ""
        if not self._first:
            return
        if time - self._last >= _SERIES:
            _log.warning(
                "robot %d: brown-out at %.1f s: %s; motors are off until %.1f V are back",
                *(self._number, time, self._first, self._battery.config.recovered_voltage),
            )
        self._first, self._last = "", time

    def log_total(self) -> None:
        """At the end of a run: how many there were, if any."""
        battery = self._battery
        if battery.brownouts:
            resets = f", {battery.resets} resets of the roboRIO" if battery.resets else ""
            _log.warning(
                "robot %d: %d brown-outs%s in this run, %.2f s without motors; lowest %.1f V",
                *(self._number, battery.brownouts, resets, battery.off_time, battery.min_voltage),
            )

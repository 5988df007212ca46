"""A robot's 12 V battery, and the roboRIO that switches off when it sags."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from simcore.errors import ConfigError, NonFiniteError
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
    """

    __slots__ = (
        "_boots",
        "_charge",
        "_drawn_as",
        "_eased",
        "_heard",
        "_is_low",
        "_slow_drop",
        "_starved",
        "browned_out",
        "brownouts",
        "config",
        "current",
        "min_voltage",
        "off_time",
        "on_brownout",
        "on_reset",
        "resets",
        "tick_browned_out",
        "tick_min_voltage",
        "voltage",
    )

    def __init__(self, config: BatteryConfig | None = None) -> None:
        self.config = config or BatteryConfig()
        self.min_voltage = math.inf
        """Lowest since the start [V]."""
        self.brownouts = 0
        """How many times motors began to be off, since the start."""
        self.off_time = 0.0
        """For how long they were, since the start [s]."""
        self.resets = 0
        """How often the roboRIO went out and had to boot, since the start."""
        self._eased = 0.0, 0.0  # step [s], and how much of its way the slow drop goes in it
        self.on_brownout: Callable[[], None] | None = None
        """Called as a brown-out begins, with `voltage` and `current` of that moment."""
        self.on_reset: Callable[[], None] | None = None
        """Called as the roboRIO goes out, with those of that moment."""
        self.reset()

    def reset(self) -> None:
        """Swap in a rested battery with the initial charge; what has been lowest so far stays so."""
        self._charge = self.config.initial_charge
        self._slow_drop = 0.0
        self._drawn_as = 0.0
        self.current = 0.0
        """Drawn in the last step [A]; negative while motors feed energy back."""
        self.voltage = self.open_voltage
        """At the terminals, under the load of the last step [V]."""
        self.min_voltage = min(self.min_voltage, self.voltage)
        self.browned_out = False
        """Whether motor controllers keep their bridges off, as the last heartbeat told them."""
        self._is_low = False  # what the roboRIO itself sees, at once
        self._heard = self.config.heartbeat  # since the last heartbeat [s]
        self._starved = 0.0  # for how long below the voltage that it lives on [s]
        self._boots = 0.0  # time until it is back [s]
        if self.config.brownout_enabled:
            self._update_brownout(0.0)
        self.begin_tick()

    def begin_tick(self) -> None:
        """Forget what has been lowest in the last tick."""
        self.tick_min_voltage = self.voltage
        """Lowest since the tick began [V]."""
        self.tick_browned_out = self.browned_out
        """Whether outputs were off at any moment since the tick began."""

    @property
    def charge(self) -> float:
        """State of charge [0..1]."""
        return self._charge

    @property
    def drawn_ah(self) -> float:
        """Net charge drawn since the start [A h]."""
        return self._drawn_as / 3600.0

    @property
    def open_voltage(self) -> float:
        """What the terminals would show if the load vanished now: the voltage behind the resistance [V]."""
        c = self.config
        voltage = c.empty_voltage + (c.full_voltage - c.empty_voltage) * self._charge - self._slow_drop
        return voltage if voltage > 0.0 else 0.0

    def step(self, h: float, current: float, at_voltage: float | None = None) -> float:
        """Draw a current for a while and return the terminal voltage [V].

        Args:
            h: Time step [s].
            current: Net current drawn [A], constant over the step; negative charges.
            at_voltage: What the current was worked out with, if that may be another than the result [V]. Motors draw
                at most in proportion to it, so a load that would pull the terminals below draws less; None: it does
                not depend on the voltage.

        Raises:
            NonFiniteError: When time or current is not a finite number; nothing has changed then.
        """
        if not (math.isfinite(h) and math.isfinite(current)):
            raise NonFiniteError(f"battery: step needs finite numbers, got h={h} s, current={current} A")
        c = self.config
        if at_voltage is not None and current > 0.0 and at_voltage > 0.0:
            share = self.open_voltage / (at_voltage + c.resistance * current)
            if share < 1.0:
                current *= share
        self.current = current
        self._drawn_as += current * h
        charge = self._charge - current * h / (3600.0 * c.capacity_ah)
        self._charge = 0.0 if charge < 0.0 else 1.0 if charge > 1.0 else charge
        # Exact for a constant current: the slow drop relaxes towards I * R_slow.
        if h != self._eased[0]:
            self._eased = h, -math.expm1(-h / c.recovery_time)
        self._slow_drop += (current * c.recovery_resistance - self._slow_drop) * self._eased[1]
        voltage = self.open_voltage - c.resistance * current
        if voltage < 0.0:
            voltage = 0.0
        self.voltage = voltage
        if voltage < self.tick_min_voltage:
            self.tick_min_voltage = voltage
            self.min_voltage = min(self.min_voltage, voltage)
        if c.brownout_enabled:
            self._update_brownout(h)
        return voltage

    def _update_brownout(self, h: float) -> None:
        """Follow the roboRIO and what its motor controllers hear of it, over a step of h [s]."""
        c = self.config
        v = self.voltage
        self._is_low = v <= c.recovered_voltage if self._is_low else v < c.brownout_voltage
        if v < c.reset_voltage:
            self._starved += h
            if self._starved > c.reset_hold - 1e-9:  # a sum of steps: rounding must not cost one more
                if self._boots == 0.0:
                    self.resets += 1
                    if self.on_reset is not None:
                        self.on_reset()
                self._boots = c.reboot_time
        else:
            self._starved = 0.0
            self._boots = self._boots - h if self._boots > h else 0.0
        if self.browned_out:
            self.off_time += h
        self._heard += h
        if self._heard < c.heartbeat - 1e-9:
            return
        self._heard = 0.0
        was_off, self.browned_out = self.browned_out, self._is_low or self._boots > 0.0
        if self.browned_out and not was_off:
            self.tick_browned_out = True
            self.brownouts += 1
            if self.on_brownout is not None:
                self.on_brownout()


class BrownoutLog:
    """Writes one line when a series of brown-outs begins, with what drew the current, and a count at the end.

    A reset of the roboRIO, which ends most matches, has a line of its own, every time.

    Args:
        number: Of the robot.
        battery: That is watched.
        consumers: What each consumer draws now, by name [A].
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
        battery = self._battery
        largest = sorted(self._consumers().items(), key=lambda one: -one[1])[:_MOST]
        named = ", ".join(f"{name} {amps:.0f} A" for name, amps in largest if amps > _LEAST)
        return f"{battery.voltage:.1f} V with {battery.current:.0f} A" + (f", {named}" if named else "")

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

    def tell_total(self) -> None:
        """At the end of a run: how many there were, if any."""
        battery = self._battery
        if battery.brownouts:
            resets = f", {battery.resets} resets of the roboRIO" if battery.resets else ""
            _log.warning(
                "robot %d: %d brown-outs%s in this run, %.2f s without motors; lowest %.1f V",
                *(self._number, battery.brownouts, resets, battery.off_time, battery.min_voltage),
            )

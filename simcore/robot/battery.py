"""Battery of a robot, and brownouts and resets of the roboRIO."""

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

_SERIES = 5.0  # [s]; a brownout within this time after the last one belongs to the same series
_MOST = 3  # largest number of consumers in a message
_LEAST = 1.0  # [A]; smallest current of a consumer in a message


@dataclass(frozen=True, slots=True, kw_only=True)
class BatteryConfig:
    """Config of an 18 Ah lead-acid battery with cables, and of the roboRIO's brownout and reset thresholds.

    The defaults describe a good competition battery. Open-circuit voltages of 12.9 V when charged and 11.7 V when
    empty, both after a rest, are typical of AGM batteries. The series resistance of 20 mohm is the default of WPILib's
    `BatterySim`, whose nominal voltage is 12 V.
    """

    full_voltage: float = 12.9
    """Open-circuit voltage when fully charged and rested [V]."""
    empty_voltage: float = 11.7
    """Open-circuit voltage when empty and rested [V]."""
    resistance: float = 0.020
    """Series resistance of battery, breaker and cable, which causes the immediate voltage drop [ohm]."""
    recovery_resistance: float = 0.008
    """Resistance that causes the slow part of the voltage drop [ohm]; estimate, +-50 %."""
    recovery_time: float = 8.0
    """Time constant of the slow part of the voltage drop [s]; estimate, +-50 %: batteries recover within seconds."""
    capacity_ah: float = 12.0
    """Charge that the battery delivers at match currents [A h]. The 18 Ah on the label apply to a 20-hour discharge."""
    initial_charge: float = 1.0
    """State of charge at the start [0..1]."""
    brownout_voltage: float = 6.75
    """Voltage below which the roboRIO browns out [V]. Motor controllers switch their outputs off at the next heartbeat.
    The default is the factory setting of a roboRIO 2, which robot code can change; a roboRIO 1 has 6.3 V."""
    recovered_voltage: float = 7.5
    """Voltage above which the roboRIO enables outputs again [V]. Source: NI roboRIO user manual, table 2."""
    heartbeat: float = 0.020
    """Period of the enable signal to motor controllers on CAN [s]. A brownout that ends before the next heartbeat has
    no effect. Outputs that a heartbeat disables stay off at least until the next heartbeat. Source: WPILib
    documentation, "FRC CAN Device Specifications", and wpilib-docs #2308 (a loop of 20 ms reads the roboRIO's
    brownout flag)."""
    reset_voltage: float = 4.5
    """Voltage below which the roboRIO shuts down after `reset_hold` [V]. The roboRIO reboots when the voltage is no
    longer below this value. Source: NI roboRIO user manual, table 2, stage 3."""
    reset_hold: float = 0.015
    """Time for which capacitors keep the roboRIO running at a voltage below `reset_voltage` [s]. Estimate, +-50 %: no
    value is published. At events, robots with weak batteries often brown out but rarely reboot (Chief Delphi
    144371)."""
    reboot_time: float = 25.0
    """Time from the recovery of the voltage until robot code can run motors again [s]; estimate, 15 to 40 s, depending
    on the size of the robot program."""
    brownout_enabled: bool = True
    """Whether low voltage causes brownouts and resets of the roboRIO; False for motor tests without a roboRIO."""

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
        """Return the config of a supply with constant voltage [V] and without brownouts, for motor data and tests."""
        return BatteryConfig(
            full_voltage=voltage,
            empty_voltage=voltage,
            resistance=0.0,
            recovery_resistance=0.0,
            brownout_enabled=False,
        )


class Battery:
    """Battery of a robot, with the power states of the roboRIO and the motor controllers.

    The open-circuit voltage falls with the charge drawn. A resistor and a slow RC element are in series with the
    voltage source (Thevenin model), so the terminal voltage recovers over a few seconds while the robot rests.

    An overloaded robot stutters at the rate of the heartbeat instead of stopping. The motors stay on until a heartbeat
    at low voltage, and then stay off until the next heartbeat at a recovered voltage. The model ignores cable
    inductance (2 uH) and the controllers' capacitors (some mF), which act for less than a millisecond.

    The loop steps the battery together with all motors of the robot (`simcore.loop.battery`).
    """

    __slots__ = ("_config", "_reported", "on_brownout", "on_reset", "records")

    def __init__(self, config: BatteryConfig | None = None) -> None:
        self.records = records(BATTERY)
        """Record of this battery in the arrays of the loop, shape (1,)."""
        self._set(min_voltage=math.inf)
        self.config = config or BatteryConfig()
        self._reported = 0, 0
        self.on_brownout: Callable[[], None] | None = None
        """Callback that `report` calls after the start of a brownout; None for no callback. `noted` holds the voltage
        and current at the start."""
        self.on_reset: Callable[[], None] | None = None
        """Callback that `report` calls after a shutdown of the roboRIO; None for no callback."""
        self.reset()

    @property
    def config(self) -> BatteryConfig:
        """Config of the battery; a new config applies from the next step on."""
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
        """Swap in a rested battery at the initial charge, start a new tick, and report events.

        The lowest voltage, the event counts and the off time of the run continue.
        """
        self._set(charge=self.config.initial_charge)
        begin_battery(self.records, 0)
        self.begin_tick()
        self.report()

    def begin_tick(self) -> None:
        """Start a new tick: set `tick_min_voltage` to `voltage` and `tick_browned_out` to `browned_out`."""
        self._set(tick_min_voltage=self.voltage, tick_was_off=self.browned_out)

    def report(self) -> None:
        """Call `on_reset` after a new reset and `on_brownout` after a new brownout, in this order.

        An event is new if the event began after the last call of this method.
        """
        before, self._reported = self._reported, (self.brownouts, self.resets)
        if self._reported[1] > before[1] and self.on_reset is not None:
            self.on_reset()
        if self._reported[0] > before[0] and self.on_brownout is not None:
            self.on_brownout()

    @property
    def voltage(self) -> float:
        """Terminal voltage under the load of the last step [V]."""
        return self._get("voltage")

    @property
    def current(self) -> float:
        """Net current drawn from the battery in the last step [A]; negative while the motors charge the battery."""
        return self._get("current")

    @property
    def noted(self) -> tuple[float, float]:
        """Voltage and current at the start of the last brownout or reset [V, A]."""
        return self._get("noted_voltage"), self._get("noted_current")

    @property
    def min_voltage(self) -> float:
        """Lowest terminal voltage since the start of the run [V]."""
        return self._get("min_voltage")

    @property
    def tick_min_voltage(self) -> float:
        """Lowest terminal voltage since the start of the tick [V]."""
        return self._get("tick_min_voltage")

    @property
    def browned_out(self) -> bool:
        """Whether the last heartbeat disabled the motor controller outputs."""
        return bool(self.records["is_off"][0])

    @property
    def tick_browned_out(self) -> bool:
        """Whether motor controller outputs were off at any time since the start of the tick."""
        return bool(self.records["tick_was_off"][0])

    @property
    def brownouts(self) -> int:
        """Number of brownouts since the start of the run."""
        return int(self.records["brownouts"][0])

    @property
    def off_time(self) -> float:
        """Total time with motor controller outputs off since the start of the run [s]."""
        return self._get("off_time")

    @property
    def resets(self) -> int:
        """Number of roboRIO shutdowns since the start of the run."""
        return int(self.records["resets"][0])

    @property
    def charge(self) -> float:
        """State of charge [0..1]."""
        return self._get("charge")

    @property
    def energy(self) -> float:
        """Energy delivered at the terminals since the last call of `reset` [J]."""
        return self._get("energy")

    @property
    def open_voltage(self) -> float:
        """Open-circuit voltage minus the slow voltage drop [V]: terminal voltage right after a removal of the load."""
        return float(open_voltage(self.records, 0))


class BrownoutLog:
    """Log of the brownouts and roboRIO resets of one robot.

    Brownouts less than 5 s apart form a series. The log has one line per series, with the largest consumers, and one
    line per reset. `log_total` adds the totals of the run.

    Args:
        number: Number of the robot, for messages.
        battery: Battery of the robot; the log sets `on_brownout` and `on_reset` of the battery.
        consumers: Function that returns the current of each consumer at the start of the last brownout or reset, by
            name [A].
    """

    def __init__(self, number: int, battery: Battery, consumers: Callable[[], Mapping[str, float]]) -> None:
        self._number = number
        self._battery = battery
        self._consumers = consumers
        self._first = self._reset = ""  # of the current tick, as text
        self._last = -_SERIES
        battery.on_brownout, battery.on_reset = self._note, self._note_reset

    def _note(self) -> None:
        self._first = self._first or self._describe()

    def _note_reset(self) -> None:
        self._reset = self._describe()

    def _describe(self) -> str:
        largest = sorted(self._consumers().items(), key=lambda one: -one[1])[:_MOST]
        named = ", ".join(f"{name} {amps:.0f} A" for name, amps in largest if amps > _LEAST)
        volts, amps = self._battery.noted
        return f"{volts:.1f} V with {amps:.0f} A" + (f", {named}" if named else "")

    def after_tick(self, time: float) -> None:
        """Log a reset and the start of a series of brownouts, if any, in the tick that ended at `time` [s]."""
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
                "robot %d: brownout at %.1f s: %s; motors are off until %.1f V are back",
                *(self._number, time, self._first, self._battery.config.recovered_voltage),
            )
        self._first, self._last = "", time

    def log_total(self) -> None:
        """Log the numbers of brownouts and resets, the off time and the lowest voltage, if a brownout occurred."""
        battery = self._battery
        if battery.brownouts:
            resets = f", {battery.resets} resets of the roboRIO" if battery.resets else ""
            _log.warning(
                "robot %d: %d brownouts%s in this run, %.2f s without motors; lowest %.1f V",
                *(self._number, battery.brownouts, resets, battery.off_time, battery.min_voltage),
            )

"""Base class of emulated devices, with control requests, configuration, faults, clock and enable signal."""

from __future__ import annotations

import enum
import re
import struct
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeAlias

from phoenix6.spns.spn_value import SpnValue

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress

__all__ = [
    "COMPLIANCY",
    "DEFAULT_HZ",
    "FAULTS",
    "LOOP",
    "LOOP_NS",
    "REQUESTS",
    "VERSION",
    "Axis",
    "Devices",
    "EmulatedDevice",
    "EnableDelays",
    "EnableState",
    "FaultFlags",
    "RequestKind",
    "Setting",
    "SimulatedClock",
    "Unit",
    "config_answer",
    "config_line",
    "number_of",
    "parse_config",
    "period_of",
    "single",
]


class Unit(enum.Enum):
    """Unit of a control law's output."""

    VOLTS = "V"
    DUTY = "DC"
    AMPERES = "A"

    __hash__ = object.__hash__  # hashing members by name instead of identity took 0.06 ms per tick


class Axis(enum.Enum):
    """Controlled quantity or motor behavior that a control request selects."""

    OPEN = "open loop"
    VELOCITY = "velocity"
    POSITION = "position"
    MOTION_MAGIC = "Motion Magic"
    MOTION_MAGIC_VELOCITY = "Motion Magic Velocity"
    MOTION_MAGIC_EXPO = "Motion Magic Expo"
    NEUTRAL = "neutral"
    BRAKE = "brake"
    COAST = "coast"
    FOLLOW = "follow"
    MUSIC = "music"

    __hash__ = object.__hash__


_MODES = {
    Axis.NEUTRAL: "NEUTRAL_OUT",
    Axis.BRAKE: "STATIC_BRAKE",
    Axis.COAST: "COAST_OUT",
    Axis.FOLLOW: "FOLLOWER",
    Axis.MUSIC: "MUSIC_TONE",
}
_VOLT_TAIL = (
    "override_brake_dur_neutral",
    "limit_forward_motion",
    "limit_reverse_motion",
    "ignore_hardware_limits",
    "ignore_software_limits",
    "use_timesync",
)
_AMPERE_TAIL = ("override_coast_dur_neutral", *_VOLT_TAIL[1:])


@dataclass(frozen=True, eq=False)
class RequestKind:
    """Kind of control request, with the controlled quantity, output unit and arguments."""

    name: str
    """Name of the Phoenix 6 class, for example `VoltageOut`."""
    axis: Axis
    """Controlled quantity or motor behavior."""
    unit: Unit
    """Unit of the output."""
    fields: tuple[str, ...]
    """Python names of the native function's arguments after network and device."""

    def mode(self, foc: bool) -> str:
        """Return the name of the `ControlModeValue` that the device reports during this request."""
        if self.axis in _MODES:
            return _MODES[self.axis]
        words = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", self.name.removeprefix("Dynamic")).upper()
        if self.unit is Unit.AMPERES or not foc:
            return words
        return words.removesuffix("_OUT") + "_FOC"

    @cached_property
    def slots(self) -> dict[str, int]:
        """Index of each field in `fields`, by name."""
        return {name: k for k, name in enumerate(self.fields)}


def _kinds() -> list[RequestKind]:
    kinds = [
        RequestKind("NeutralOut", Axis.NEUTRAL, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("StaticBrake", Axis.BRAKE, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("CoastOut", Axis.COAST, Unit.VOLTS, ("update_freq_hz", "use_timesync")),
        RequestKind("MusicTone", Axis.MUSIC, Unit.VOLTS, ("update_freq_hz", "audio_frequency")),
        RequestKind("Empty", Axis.NEUTRAL, Unit.VOLTS, ("update_freq_hz",)),
        RequestKind("Follower", Axis.FOLLOW, Unit.VOLTS, ("update_freq_hz", "leader_id", "motor_alignment")),
        RequestKind("StrictFollower", Axis.FOLLOW, Unit.VOLTS, ("update_freq_hz", "leader_id")),
    ]
    closed: list[tuple[str, Axis, tuple[str, ...]]] = [
        ("Position", Axis.POSITION, ("position", "velocity")),
        ("Velocity", Axis.VELOCITY, ("velocity", "acceleration")),
        ("MotionMagic", Axis.MOTION_MAGIC, ("position",)),
        ("MotionMagicVelocity", Axis.MOTION_MAGIC_VELOCITY, ("velocity", "acceleration")),
        ("MotionMagicExpo", Axis.MOTION_MAGIC_EXPO, ("position",)),
        ("DynamicMotionMagic", Axis.MOTION_MAGIC, ("position", "velocity", "acceleration", "jerk")),
        ("DynamicMotionMagicExpo", Axis.MOTION_MAGIC_EXPO, ("position", "k_v", "k_a", "velocity")),
    ]
    for suffix, unit in (("DutyCycle", Unit.DUTY), ("Voltage", Unit.VOLTS), ("TorqueCurrentFOC", Unit.AMPERES)):
        for prefix, axis, goals in closed:
            foc = () if unit is Unit.AMPERES else ("enable_foc",)
            tail = _AMPERE_TAIL if unit is Unit.AMPERES else _VOLT_TAIL
            fields = ("update_freq_hz", *goals, *foc, "feed_forward", "slot", *tail)
            kinds.append(RequestKind(prefix + suffix, axis, unit, fields))
    open_loop = ("update_freq_hz", "output")
    kinds.append(RequestKind("DutyCycleOut", Axis.OPEN, Unit.DUTY, (*open_loop, "enable_foc", *_VOLT_TAIL)))
    kinds.append(RequestKind("VoltageOut", Axis.OPEN, Unit.VOLTS, (*open_loop, "enable_foc", *_VOLT_TAIL)))
    torque = (*open_loop, "max_abs_duty_cycle", "deadband", *_AMPERE_TAIL)
    kinds.append(RequestKind("TorqueCurrentFOC", Axis.OPEN, Unit.AMPERES, torque))
    return kinds


REQUESTS: dict[str, RequestKind] = {kind.name: kind for kind in _kinds()}
"""Modelled control requests, by Phoenix 6 class name."""


Setting = float | int
"""Configuration value: a float (kind "f" in the library's format), an integer or enum ("s"), or a boolean ("b")."""

_FLOAT = struct.Struct("<f")
_INT = struct.Struct("<i")


def single(value: float) -> float:
    """Return the value rounded to single precision, in which a device stores its settings."""
    return float(_FLOAT.unpack(_FLOAT.pack(value))[0])


def bits_of(value: float) -> int:
    """Return the 32 bits of a single-precision float as a signed integer."""
    return int(_INT.unpack(_FLOAT.pack(value))[0])


def number_of(bits: int) -> float:
    """Return the single-precision float encoded by 32 bits."""
    return float(_FLOAT.unpack(_INT.pack(bits))[0])


def config_line(spn: int, kind: str, value: float | int) -> str:
    """Return one configuration line in the library's format, for example `1877,f_0.5`.

    The kind is "f" for a float, "s" for an integer or enum, and "b" for a boolean.
    """
    return f"{spn},{kind}_{value:.9g}\n" if kind == "f" else f"{spn},{kind}_{int(value)}\n"


def parse_config(text: str) -> dict[int, Setting]:
    """Parse configuration lines into settings by number: floats for kind f, and integers for kinds s and b.

    Raises:
        ValueError: A line is not of the form `number,kind_value`.
    """
    settings: dict[int, Setting] = {}
    for line in text.split():
        try:
            spn, value = line.split(",", 1)
            kind, _, digits = value.partition("_")
            if kind == "f":
                settings[int(spn)] = single(float(digits))
            elif kind in ("s", "b"):
                settings[int(spn)] = int(digits)
            else:
                raise ValueError(kind)
        except ValueError as error:
            raise ValueError(f"config line {line!r} is not of the form 'number,f_1.5' (kinds f, s, b)") from error
    return settings


def config_answer(settings: Mapping[int, Setting]) -> str:
    """Return a device's reply to a configuration read: a line for each setting, with kind s and the value's 32 bits."""
    return "".join(
        f"{spn},s_{bits_of(value) if isinstance(value, float) else value}\n" for spn, value in settings.items()
    )


LOOP_NS = 1_000_000
"""Period of a device's control loop [ns]."""
LOOP = 1e-3
"""Period of a device's control loop [s]."""


class SimulatedClock:
    """Clock of simulated time since power-up of the devices.

    `phoenix6.utils.get_current_time_seconds()` returns this time. The clock counts whole nanoseconds, so rounding
    errors do not accumulate. Devices run a control loop every millisecond.
    """

    __slots__ = ("loop_ns", "next_frame_ns", "ns")

    def __init__(self) -> None:
        self.ns = 0
        """Simulated time [ns]."""
        self.loop_ns = 0
        """Simulated time of the last control loop [ns]."""
        self.next_frame_ns = 0
        """Earliest time at which a device may send a status frame [ns]; 0 after a change of devices or rates."""

    def reset(self, start: float = 0.0) -> None:
        """Set simulated time and the time of the last control loop to `start` [s]."""
        self.ns = self.loop_ns = round(start * 1e9)
        self.next_frame_ns = 0

    @property
    def now(self) -> float:
        """Simulated time [s]."""
        return self.ns * 1e-9


_PERIOD_NS = 10_000_000
"""Period of the enable feed [ns]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EnableDelays:
    """Delays from the enable feed to the devices' response."""

    enable: float = 0.045
    """Delay from the first feed to the first motor voltage [s].

    The measured delay from the driver station is 49 ms, which includes 4 ms from the driver station to the feed.
    """
    disable: float = 0.080
    """Delay from a feed of 0 ms to zero output [s]. The measured delay from the driver station is 86 ms."""

    def __post_init__(self) -> None:
        if not (0.0 <= self.enable < 1.0 and 0.0 <= self.disable < 1.0):
            raise ConfigError(f"enable delays must be 0..1 s, got enable={self.enable}, disable={self.disable}")


class EnableState:
    """Enable signal of all devices, with a delay between the library's enable feed and the devices.

    In CTRE's simulation in real time, a device starts to drive 49 ms after the driver station enables the robot, and
    stops 86 ms after the driver station disables the robot. Most of each delay is the period of the enable frame.

    Args:
        clock: Clock of simulated time.
        delays: Delays from the feed to the devices' response.
    """

    __slots__ = ("_clock", "_fed_until", "_since", "_until", "delays")

    def __init__(self, clock: SimulatedClock, delays: EnableDelays) -> None:
        self._clock = clock
        self.delays = delays
        """Delays from the feed to the devices' response."""
        self._fed_until = -1
        self._since = 0
        self._until = -1

    def feed(self, milliseconds: int) -> None:
        """Feed the enable signal for a duration from now [ms]. A duration of 0 disables the devices.

        The devices respond after the enable or disable delay.
        """
        # The feed runs on its own thread. When a feed coincides with a physics step, either may run first. Rounding the
        # time up to the feed's period gives the same result in both orders.
        now = -(-self._clock.ns // _PERIOD_NS) * _PERIOD_NS
        if milliseconds <= 0:
            if self.is_fed:
                self._fed_until = now
                self._until = now + round(self.delays.disable * 1e9)
            return
        if not self.is_fed:
            # Devices that are still driving continue without a delay.
            self._since = now if self.is_enabled else now + round(self.delays.enable * 1e9)
        self._fed_until = self._until = now + milliseconds * 1_000_000

    @property
    def is_fed(self) -> bool:
        """Whether the library's enable feed is active."""
        return self._fed_until > self._clock.ns

    @property
    def is_enabled(self) -> bool:
        """Whether the devices are enabled at the present simulated time."""
        return self._since <= self._clock.ns < self._until


_CLEAR_ALL = SpnValue.SPN_CLEAR_STICKY_FAULTS.value
"""Number of the setting that clears every sticky fault."""
FAULTS: dict[str, int] = {
    name.removeprefix("FAULT_"): member.value
    for name, member in SpnValue.__members__.items()
    if name.startswith("FAULT_")
}
"""Signal number of each fault, by the `SpnValue` name without `FAULT_`."""
_MEMBERS = SpnValue.__members__
_STICKY = {_MEMBERS[f"STICKY_FAULT_{name}"].value: spn for name, spn in FAULTS.items()}
_CLEAR = {
    _MEMBERS[f"CLEAR_STICKY_FAULT_{name}"].value: spn
    for name, spn in FAULTS.items()
    if f"CLEAR_STICKY_FAULT_{name}" in _MEMBERS
}


class FaultFlags:
    """Active and sticky faults of one device."""

    __slots__ = ("_active", "_sticky")

    def __init__(self) -> None:
        self._active: Set[int] = frozenset()
        self._sticky: set[int] = set()

    def set_active(self, active: Set[int]) -> None:
        """Set the active faults and add them to the sticky faults."""
        self._active = active
        if active:
            self._sticky |= active

    def clear(self, setting: int) -> bool:
        """Clear the sticky faults that a setting addresses; return whether the setting is a clear command."""
        if setting == _CLEAR_ALL:
            self._sticky.clear()
            return True
        fault = _CLEAR.get(setting)
        if fault is None:
            return False
        self._sticky.discard(fault)
        return True

    def read(self, spn: int) -> float | None:
        """Return the value of a fault signal: 1 or 0 for one fault, or the number of faults for a total.

        The method returns None for any other signal.
        """
        if spn in _STICKY:
            return float(_STICKY[spn] in self._sticky)
        if spn in _ALL:
            return float(spn in self._active)
        if spn == SpnValue.ALL_FAULTS.value:
            return float(len(self._active))
        if spn == SpnValue.ALL_STICKY_FAULTS.value:
            return float(len(self._sticky))
        return None


_ALL = frozenset(FAULTS.values())


COMPLIANCY = 19
"""API compliancy level that the devices report, as Phoenix 6 26.x requires."""
VERSION = (26, 3, 0, 0)
"""Firmware version that the devices report."""
_CONSTANTS = {
    SpnValue.COMPLIANCY_VERSION.value: COMPLIANCY,
    SpnValue.VERSION_MAJOR.value: VERSION[0],
    SpnValue.VERSION_MINOR.value: VERSION[1],
    SpnValue.VERSION_BUGFIX.value: VERSION[2],
    SpnValue.VERSION_BUILD.value: VERSION[3],
    SpnValue.VERSION_FULL.value: int.from_bytes(bytes(VERSION), "big"),
    SpnValue.VERSION_IS_PRO_LICENSED.value: 1,
}
_RESET_FLAGS = SpnValue.STARTUP_RESET_FLAGS.value

DEFAULT_HZ = 100.0
"""Default status frame rate on CAN FD, the type of every simulated bus [Hz]."""


def period_of(hz: float) -> int:
    """Return the frame period for a rate [Hz] in whole milliseconds, from 1 to 250; 0 for a rate of 0 or less."""
    return 0 if hz <= 0.0 else min(max(int(1000.0 / hz), 1), 250)


class EmulatedDevice:
    """Base class of emulated devices.

    Robot code reads a device's signals from the last status frame instead of the present state.

    Args:
        address: CAN ID and bus.
        clock: Clock of simulated time.
        defaults: Factory configuration, by setting number.
    """

    __slots__ = (
        *("address", "clock", "config", "defaults", "due_ns", "fault_flags", "frame", "frame_ns"),
        *("_asked", "period_ms", "supply"),
    )
    model: ClassVar[str] = ""
    """Device name in the library, for example "talon fx"."""
    type_number: ClassVar[int] = -1
    """Device type number (`phoenix6.sim.device_type.DeviceType`)."""
    signals: ClassVar[Mapping[int, Callable[[Any], float]]] = {}
    """Functions that return a signal's value from a status frame, by signal number."""

    def __init__(self, address: DeviceAddress, clock: SimulatedClock, defaults: Mapping[int, Setting]) -> None:
        self.address = address
        self.clock = clock
        self.defaults = dict(defaults)
        self.config = dict(defaults)
        self.supply = 12.0
        self.period_ms = 0
        self.fault_flags = FaultFlags()
        self._asked: dict[int, float] = {}
        self.frame: Any = None
        self.frame_ns = clock.ns
        self.due_ns = 0
        self.set_rate(DEFAULT_HZ)

    def __repr__(self) -> str:
        return f"{self.model} {self.address}"

    # ---- configuration

    def configure(self, settings: Mapping[int, Setting], *, reset_others: bool = False) -> None:
        """Store settings, clear sticky faults and execute commands.

        With `reset_others`, all settings that are not in `settings` return to the factory defaults.

        Args:
            settings: Values of settings and commands, by number.
            reset_others: Whether to reset all other settings.

        Raises:
            NotImplementedError: A command is not modelled.
        """
        known = {spn: value for spn, value in settings.items() if spn in self.defaults}
        for spn, value in settings.items():
            if spn not in self.defaults and not self.fault_flags.clear(spn):
                self.command(spn, float(value))
        if not known and not reset_others:
            return
        if reset_others:
            self.config = dict(self.defaults)
        self.config.update(known)
        self.configured()

    def configured(self) -> None:
        """Update the device after a change of configuration. This base class does nothing."""

    def command(self, spn: int, value: float) -> None:
        """Execute a setting that is a command rather than a stored value, for example a new position.

        Raises:
            NotImplementedError: The command is not modelled.
        """
        raise NotImplementedError(f"{self!r}: setting {spn} (value {value}) is not modelled in simulated time")

    # ---- requests

    def receive(self, kind: RequestKind, args: tuple[Any, ...]) -> None:
        """Apply a control request from robot code. This base class supports no requests.

        Raises:
            NotImplementedError: The request is not modelled.
        """
        raise NotImplementedError(f"{self!r}: control request {kind.name} is not modelled in simulated time")

    # ---- physics

    def set_input(self, name: str, value: float) -> None:
        """Set a `sim_state` input from physics. This base class accepts the supply voltage, raised to at least 4 V.

        Raises:
            NotImplementedError: The input is not modelled.
        """
        if name == "SupplyVoltage":
            self.supply = max(value, 4.0)
            return
        raise NotImplementedError(f"{self!r}: sim_state input {name!r} is not modelled in simulated time")

    def get_value(self, name: str) -> float | None:
        """Return the `sim_state` value `name`, or None for an unknown name. This base class has no values."""
        return None

    # ---- status

    def sample(self) -> Any:
        """Return a new status frame with the present state. Each subclass implements this method."""
        raise NotImplementedError

    def send_frame(self) -> None:
        """Store the present readings and time as the status frame that robot code reads."""
        self.frame = self.sample()
        self.frame_ns = self.clock.ns

    def units_of(self, spn: int) -> int:
        """Return the number of the signal that defines the units of signal `spn` in the last frame."""
        return spn

    def read(self, spn: int) -> tuple[float, float, int] | None:
        """Return the value of a signal, the time of the value [s] and the number of the signal that defines the units.

        The method returns None if signal `spn` is not modelled.
        """
        signal = self.signals.get(spn)
        if signal is not None:
            return signal(self.frame), self.frame_ns * 1e-9, self.units_of(spn)
        if spn in _CONSTANTS:
            return _CONSTANTS[spn], self.clock.now, spn
        if spn == _RESET_FLAGS:
            return 0.0, 0.0, spn  # a device sends these flags only after a reset
        fault = self.fault_flags.read(spn)
        return None if fault is None else (fault, self.frame_ns * 1e-9, spn)

    def set_rate(self, hz: float) -> None:
        """Set the rate of the status frame [Hz] and schedule the next frame; 0 turns the frame off."""
        self.period_ms = period_of(hz)
        self.clock.next_frame_ns = 0
        period = self.period_ms * 1_000_000
        if period:
            # Devices send all frames of one rate together, half a period after each multiple of the period. Robot code
            # that reads at a multiple of the period gets a value half a period old, the average age on the wall clock.
            self.due_ns = (self.clock.ns - period // 2) // period * period + period // 2 + period

    def ask_rate(self, spn: int, hz: float) -> None:
        """Request a rate for one signal [Hz], and ignore a signal that is not in the status frame.

        The status frame uses the fastest requested rate of all signals.
        """
        if spn not in self.signals:
            return  # versions, faults and constants are in frames that are not modelled
        self._asked[spn] = hz
        self.set_rate(max(self._asked.values()))

    def optimize_rate(self, hz: float) -> None:
        """Set the rate of the status frame [Hz], unless robot code has requested the rate of a signal."""
        if not self._asked:
            self.set_rate(hz)

    def reset_rate(self) -> None:
        """Discard the requested rates of all signals, and set the status frame to the default rate."""
        self._asked.clear()
        self.set_rate(DEFAULT_HZ)

    @property
    def rate(self) -> float:
        """Actual rate of the status frame [Hz]; 0 if the frame is off."""
        return 1000.0 / self.period_ms if self.period_ms else 0.0


Devices: TypeAlias = Mapping[tuple[int, int], EmulatedDevice]
"""Devices on one bus, by (`DeviceType` number, CAN ID)."""

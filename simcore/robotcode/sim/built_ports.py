"""Ports of the roboRIO and pneumatics modules that the robot program uses, and the WPILib class of each port.

The HAL's simulation data contains ports but no WPILib classes. This module therefore records the constructor calls of
WPILib classes. The class of an object from another source, for example a C++ library, is unknown.
"""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from simcore import season
from simcore.quantities import DeviceAddress, DeviceKey
from simcore.robotcode.program.recorder import after_call, record_class

AnalogInputSim = season.wpilib_simulation.AnalogInputSim
CTREPCMSim = season.wpilib_simulation.CTREPCMSim
DIOSim = season.wpilib_simulation.DIOSim
PWMSim = season.wpilib_simulation.PWMSim
REVPHSim = season.wpilib_simulation.REVPHSim
RelaySim = season.class_before_2027("wpilib.simulation", "RelaySim")
wpilib = season.wpilib

__all__ = ["BuiltPort", "built_ports", "encoder_range", "pneumatics_module", "ports_text"]


def _is_relay_built(channel: int) -> bool:
    if not hasattr(RelaySim, "getInitializedForward"):
        return False  # a controller without relays
    relay = RelaySim(channel)
    return bool(relay.getInitializedForward() or relay.getInitializedReverse())


_MODELS: dict[str, tuple[int, Callable[[int], bool]]] = {
    "PWM": (20, lambda channel: bool(PWMSim(channel).get_initialized())),
    "DIO": (31, lambda channel: bool(DIOSim(channel).get_initialized())),
    "Analog": (8, lambda channel: bool(AnalogInputSim(channel).get_initialized())),
    "Relay": (4, _is_relay_built),
}
"""Number of ports, including MXP ports, and a function that returns whether a port is in use, by kind of port."""
_CLASSES = (
    *("Koors40", "PWMSparkFlex", "PWMSparkMax", "PWMTalonFX", "PWMTalonSRX", "PWMVenom", "PWMVictorSPX"),
    *("Spark", "Talon", "VictorSP", "Servo", "PWM", "AddressableLED"),
    *("DigitalInput", "DigitalOutput", "Encoder", "DutyCycle", "DutyCycleEncoder", "Counter", "Ultrasonic"),
    *("AnalogInput", "AnalogEncoder", "AnalogPotentiometer", "AnalogGyro", "AnalogAccelerometer", "AnalogTrigger"),
    *("SharpIR", "Relay"),
)


@dataclass(frozen=True, slots=True)
class BuiltPort:
    """Object in robot code that uses ports of the roboRIO or of a pneumatics module."""

    model: str
    """Kind of port: `PWM`, `DIO`, `Analog`, `Relay`, or a module's solenoids such as `REVPH 1 Solenoid`."""
    channels: tuple[int, ...]
    made_by: str = ""
    """Name of the WPILib class; empty if this module has not recorded the constructor call."""
    device: Any = None
    """Object in robot code; None if robot code has deleted the object, or if the constructor call was not recorded."""
    args: tuple[Any, ...] = field(default=(), compare=False)
    """Positional arguments of the constructor."""
    settings: dict[str, Any] = field(default_factory=dict, compare=False)
    """Keyword arguments of the constructor."""

    @property
    def keys(self) -> list[DeviceKey]:
        """Device keys of the ports, one key for each channel."""
        return [(self.model, DeviceAddress(channel)) for channel in self.channels]

    def __str__(self) -> str:
        text = f"{self.model} {' '.join(map(str, self.channels))}"
        return f"{text} ({self.made_by})" if self.made_by else text


_records: list[BuiltPort] = []
"""Recorded objects in order of construction, with a weak reference in `device`."""


def built_ports() -> list[BuiltPort]:
    """Return the objects in robot code that use ports now, in order of construction.

    The list ends with one entry for each used port whose class is unknown.
    """
    used = _used()
    found: list[BuiltPort] = []
    for record in _records:
        device = record.device()
        if record.model in used and not used[record.model].issuperset(record.channels):
            continue  # the port has been freed since then
        if record.model not in used and device is None:
            continue
        found.append(replace(record, device=device))
    # a later object may use the ports of a deleted object
    found = [
        port
        for number, port in enumerate(found)
        if port.device is not None
        or {*port.keys}.isdisjoint(key for later in found[number + 1 :] for key in later.keys)
    ]
    known = {key for port in found for key in port.keys}
    for model, channels in used.items():
        unknown = [BuiltPort(model, (channel,)) for channel in sorted(channels)]
        found += [port for port in unknown if known.isdisjoint(port.keys)]
    return found


def pneumatics_module(name: str) -> Any:
    """Return the WPILib simulation object of the pneumatics module `name`, for example `REVPH 1` or `CTREPCM 0`."""
    kind, number = name.split()
    return (REVPHSim if kind == "REVPH" else CTREPCMSim)(int(number))


def encoder_range(model: str, channel: int) -> float:
    """Return the reading of the absolute encoder on a port after one turn, in robot code's unit.

    The value is the full range from the encoder's constructor, or 1 if the constructor call has no range.
    """
    for port in built_ports():
        if port.model == model and channel in port.channels and port.made_by in ("DutyCycleEncoder", "AnalogEncoder"):
            return float(port.settings.get("fullRange", port.args[1] if len(port.args) > 1 else 1.0))
    return 1.0


def ports_text(model: str) -> str:
    """Return the used ports of one kind for an error message, for example `PWM 0 (Spark), PWM 3 (Servo)` or `none`."""
    return ", ".join(str(port) for port in built_ports() if port.model == model) or "none"


def _used() -> dict[str, set[int]]:
    return {model: {n for n in range(count) if is_built(n)} for model, (count, is_built) in _MODELS.items()}


# --- watching constructors ----------------------------------------------------------------------------------------


def _record_ports() -> None:
    """Wrap the constructors of WPILib's classes to record objects and ports.

    The module calls this function once, on import.
    """
    for name in _CLASSES:
        cls = getattr(wpilib, name, None)
        if cls is not None and not getattr(cls.__init__, "_records_ports", False):
            cls.__init__ = _recording(cls.__init__, name)
    for cls in (wpilib.Solenoid, wpilib.DoubleSolenoid):
        record_class(cls, _note_solenoid)
    for maker in (wpilib.PneumaticHub, wpilib.PneumaticsControlModule):
        for method in ("make_solenoid", "make_double_solenoid"):
            after_call(maker, season.own_name(maker, method), _note_made)


def _recording(build: Any, name: str) -> Any:
    @functools.wraps(build)
    def init(self: Any, *args: Any, **settings: Any) -> None:
        before = _used()
        build(self, *args, **settings)
        sources = [value for value in (*args, *settings.values()) if hasattr(value, "get_channel")]
        after = _used()
        for model, known in before.items():
            new = sorted(after[model] - known)
            if not new and sources and model == "DIO":
                new = [int(source.get_channel()) for source in sources]  # built from existing DigitalInputs
            if new:
                _records.append(BuiltPort(model, tuple(new), name, weakref.ref(self), args, settings))

    init._records_ports = True  # type: ignore[attr-defined]
    return init


def _module_of(args: tuple[Any, ...], settings: dict[str, Any]) -> tuple[str, int]:
    """Return the type and CAN ID of the pneumatics module from a solenoid's constructor arguments.

    Without an ID in the arguments, the function returns the type's default ID.
    """
    values = [*args, *settings.values()]
    kind = next(value for value in values if isinstance(value, wpilib.PneumaticsModuleType))
    is_rev = kind == wpilib.PneumaticsModuleType.REVPH
    named = settings.get("module", args[0] if args and isinstance(args[0], int) else None)
    return ("REVPH" if is_rev else "CTREPCM"), (int(is_rev) if named is None else int(named))


def _note_solenoid(solenoid: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    _note(solenoid, *_module_of(args, settings))


def _note_made(module: Any, solenoid: Any, args: tuple[Any, ...], settings: dict[str, Any]) -> None:
    kind = "REVPH" if isinstance(module, wpilib.PneumaticHub) else "CTREPCM"
    _note(solenoid, kind, int(module.get_module_number()))


def _note(solenoid: Any, kind: str, number: int) -> None:
    is_single = isinstance(solenoid, wpilib.Solenoid)
    coils = [solenoid.get_channel()] if is_single else [solenoid.get_fwd_channel(), solenoid.get_rev_channel()]
    name, channels = "Solenoid" if is_single else "DoubleSolenoid", tuple(map(int, coils))
    _records.append(BuiltPort(f"{kind} {number} Solenoid", channels, name, weakref.ref(solenoid)))


_record_ports()

"""Replacement of Phoenix 6's native libraries with the emulator, after a compatibility check.

The installation also changes three features of the Python library:

- The enable feed of device objects, a WPILib Notifier, stops at install and uninstall.
- Device objects do not copy their state to WPILib SimDevices by default. The library makes these copies before every
  robot tick for the simulation GUI. Tests do not need the copies, which would take most of a tick (17-39 us per
  device).
- A `sim_state` identifies a device by the device hash, because a device type and CAN ID do not include the bus.
"""

from __future__ import annotations

import functools
import inspect
from importlib import metadata
from typing import Any

from phoenix6 import hardware, sim
from phoenix6.phoenix_native import Native, ReturnValues, SignalValues
from phoenix6.wpiutils import auto_feed_enable

from simcore.errors import SimcoreError
from simcore.robotcode.emulator.emulated_device import REQUESTS, EnableDelays
from simcore.robotcode.emulator.emulated_native import (
    ADDED,
    GONE,
    IS_2027,
    PREFIX,
    RENAMED,
    EmulatedNative,
    SwerveNative,
)
from simcore.robotcode.emulator.emulator import Emulator

__all__ = ["SeamError", "check_seam", "install", "installed", "uninstall"]

_INSTANCE = "_Native__instance"
_API = "_Native__api_instance"
_FUNCTIONS = "_Native__c_args"
_FEED = "_AutoFeedEnable__instance"
_NOTIFIER = "_AutoFeedEnable__enable_notifier"
_OLD_NAMES = {new: old for old, new in RENAMED.items()}
_CLASSES = ("TalonFX", "TalonFXS", "CANcoder", "Pigeon2", "CANrange", "CANdi", "CANdle")


class SeamError(SimcoreError, RuntimeError):
    """Error raised when the native interface of the installed phoenix6 does not match the emulator."""


class _SimDeviceCopies:
    """Switch that turns the copying of device state to WPILib SimDevices off and on."""

    def __init__(self) -> None:
        self._saved: list[tuple[type, str, Any]] = []

    def off(self) -> None:
        """Turn copying off for all devices built after this call."""
        for name in _CLASSES:
            cls = getattr(hardware, name)
            attribute = f"_{name}__on_periodic"
            method = cls.__dict__.get(attribute)
            if method is not None:
                self._saved.append((cls, attribute, method))
                setattr(cls, attribute, _nothing)

    def on(self) -> None:
        """Turn copying on again by restoring the library's methods."""
        for cls, attribute, method in self._saved:
            setattr(cls, attribute, method)
        self._saved.clear()


def _nothing(device: Any) -> None:
    return None


def _number_states() -> None:
    for name in _CLASSES:
        cls = getattr(sim, f"{name}SimState")
        if not hasattr(cls.__init__, "_numbers_states"):
            cls.__init__ = _numbering(cls.__init__)


def _numbering(build: Any) -> Any:
    @functools.wraps(build)
    def init(self: Any, device: Any, *args: Any, **settings: Any) -> None:
        build(self, device, *args, **settings)
        if installed() is not None:
            self._id = device._device_identifier.device_hash

    init._numbers_states = True  # type: ignore[attr-defined]
    return init


_copies = _SimDeviceCopies()
_current: tuple[Emulator, SwerveNative] | None = None
_real: tuple[Any, Any] | None = None


def check_seam() -> None:
    """Check that the native interface of the installed phoenix6 matches the emulator.

    Raises:
        SeamError: The interface does not match. The message states the difference and the supported versions.
    """
    version = metadata.version("phoenix6")
    wrong = _misfit()
    if wrong:
        raise SeamError(
            f"phoenix6 {version} does not fit simulated time: {wrong}. "
            "Versions that fit: 26.3 (pip install 'phoenix6~=26.3.0') and 26.70.0a2."
        )


def _misfit() -> str | None:
    """Describe the first mismatch between the installed phoenix6 and the emulator; return None if all parts match."""
    for name in (_INSTANCE, _API, _FUNCTIONS):
        if not hasattr(Native, name):
            return f"its phoenix_native.Native has no {name.removeprefix('_Native')}"
    for structure, fields in (
        (SignalValues, ["devicehash", "spn"]),
        (
            ReturnValues,
            [
                "outvalue",
                "unitskey",
                "units",
                "hwtimestampseconds",
                "swtimestampseconds",
                "ecutimestampseconds",
                "error",
            ],
        ),
    ):
        if [field[0].lower() for field in structure._fields_][-len(fields) :] != fields:
            return f"its {structure.__name__} has other fields"
    arguments = {name: len(types) for name, _, types in getattr(Native, _FUNCTIONS)}
    for kind in REQUESTS.values():
        found = arguments.get(f"{PREFIX}RequestControl{kind.name}")
        if found is not None and found != len(kind.fields) + 2:
            return f"its {kind.name} takes {found} arguments and not {len(kind.fields) + 2}"
    for name in dir(EmulatedNative):
        if not name.startswith("c_"):
            continue
        function = getattr(EmulatedNative, name)
        if name in (GONE if IS_2027 else ADDED):
            continue
        theirs = name if IS_2027 else _OLD_NAMES.get(name, name)
        if theirs not in arguments:
            return f"it has no function {theirs}"
        parameters = inspect.signature(function).parameters.values()
        taken = arguments[theirs] if any(p.kind is p.VAR_POSITIONAL for p in parameters) else len(parameters) - 1
        if taken != arguments[theirs]:
            return f"its {theirs} takes {arguments[theirs]} arguments and not {taken}"
    return None


def install(*, delays: EnableDelays | None = None, mirror: bool = False) -> Emulator:
    """Replace Phoenix 6's native libraries with the emulator, and return the emulator.

    Call this function before robot code builds the first device. While an emulator is installed, a further call ignores
    the arguments, removes all devices and returns that emulator.

    Args:
        delays: Delays from the enable feed to the devices' response; None for the defaults.
        mirror: Whether device objects copy their outputs to WPILib SimDevices every tick, for the simulation GUI.

    Raises:
        SeamError: The installed phoenix6 does not match the emulator.
    """
    global _current, _real
    _stop_feed()
    if _current is not None:
        emulator, swerve = _current
        emulator.reset()
        swerve.reset()
        return emulator
    check_seam()
    _real = (getattr(Native, _INSTANCE), getattr(Native, _API))
    emulator = Emulator(delays)
    swerve = SwerveNative(emulator)
    _current = (emulator, swerve)
    setattr(Native, _INSTANCE, EmulatedNative(emulator))
    setattr(Native, _API, swerve)
    _number_states()
    if not mirror:
        _copies.off()
    return emulator


def installed() -> Emulator | None:
    """Return the installed emulator; None while Phoenix 6 uses its own native libraries."""
    return None if _current is None else _current[0]


def uninstall() -> None:
    """Restore Phoenix 6's native libraries.

    After this call, robot code must not use devices that were built in simulated time.
    """
    global _current, _real
    _stop_feed()
    if _real is not None:
        setattr(Native, _INSTANCE, _real[0])
        setattr(Native, _API, _real[1])
    _copies.on()
    _current = _real = None


def _stop_feed() -> None:
    """Stop the Notifier that calls `feed_enable`.

    The library starts a new Notifier for the next device. Without this stop, devices that robot code has not closed
    would enable the devices of the next test, and a Notifier that still runs when Python exits would abort the process.
    """
    cls = getattr(auto_feed_enable, "AutoFeedEnable", None)
    feed = getattr(cls, _FEED, None)
    if cls is None or feed is None:
        return
    getattr(feed, _NOTIFIER).stop()
    setattr(cls, _FEED, None)

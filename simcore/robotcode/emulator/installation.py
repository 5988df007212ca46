"""Replacement of Phoenix 6's native libraries by the emulator, after a check that it fits.

It also switches three features of the Python library. It stops the enable feed of device objects, a WPILib Notifier,
at install and uninstall. Each device object copies its state to WPILib SimDevices before every robot tick, 17-39 us a
device, for the simulation GUI: tests do not need that, and it would be most of the cost of a tick, so it is off in
simulated time by default. And a `sim_state` names its device by type and id without the bus: in
simulated time it uses the name of other functions.
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
    """The installed phoenix6 lacks native functions that the emulator replaces."""


class _SimDeviceCopies:
    """Switch for the copies in WPILib SimDevices."""

    def __init__(self) -> None:
        self._saved: list[tuple[type, str, Any]] = []

    def off(self) -> None:
        """Build devices without copies from now on."""
        for name in _CLASSES:
            cls = getattr(hardware, name)
            attribute = f"_{name}__on_periodic"
            method = cls.__dict__.get(attribute)
            if method is not None:
                self._saved.append((cls, attribute, method))
                setattr(cls, attribute, _nothing)

    def on(self) -> None:
        """Restore the library's behavior."""
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
    """Compare the installed phoenix6 with the functions of the emulator.

    Raises:
        SeamError: It does not fit; the text gives the difference and a version that fits.
    """
    version = metadata.version("phoenix6")
    wrong = _misfit()
    if wrong:
        raise SeamError(
            f"phoenix6 {version} does not fit simulated time: {wrong}. "
            "Versions that fit: 26.3 (pip install 'phoenix6~=26.3.0') and 26.70.0a2."
        )


def _misfit() -> str | None:
    """Return the functions that the installed phoenix6 lacks; None when it fits."""
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
    """Run Phoenix 6 in simulated time from now on; call before robot code builds its first device.

    A second call returns the devices of the first, reset.

    Args:
        delays: Delays from the enable feed to the devices.
        mirror: Whether device objects copy their outputs to WPILib SimDevices every tick, for the simulation GUI.

    Raises:
        SeamError: The installed phoenix6 does not fit.
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
    """Return the devices in simulated time; None while Phoenix 6 uses its own native libraries."""
    return None if _current is None else _current[0]


def uninstall() -> None:
    """Restore Phoenix 6's native libraries; devices made in simulated time become useless."""
    global _current, _real
    _stop_feed()
    if _real is not None:
        setattr(Native, _INSTANCE, _real[0])
        setattr(Native, _API, _real[1])
    _copies.on()
    _current = _real = None


def _stop_feed() -> None:
    """Stop the Notifier that feeds `feed_enable`; the next device makes a new one.

    Devices that robot code left open would otherwise feed the enable signal of the next test, and a Notifier still
    alive at Python's shutdown aborts the process.
    """
    cls = getattr(auto_feed_enable, "AutoFeedEnable", None)
    feed = getattr(cls, _FEED, None)
    if cls is None or feed is None:
        return
    getattr(feed, _NOTIFIER).stop()
    setattr(cls, _FEED, None)

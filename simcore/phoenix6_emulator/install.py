"""Puts the stand-in in place of Phoenix 6's native libraries, and checks first that it fits."""

from __future__ import annotations

import inspect
from importlib import metadata
from typing import Any

from phoenix6.phoenix_native import Native, ReturnValues, SignalValues

from simcore.errors import SimcoreError
from simcore.phoenix6_emulator.api import PREFIX
from simcore.phoenix6_emulator.enable import EnableDelays
from simcore.phoenix6_emulator.feed import stop_feed
from simcore.phoenix6_emulator.mirror import Mirror
from simcore.phoenix6_emulator.native import SimulatedNative
from simcore.phoenix6_emulator.requests import REQUESTS
from simcore.phoenix6_emulator.world import StandIn

__all__ = ["SeamError", "check_seam", "install", "installed", "uninstall"]

_INSTANCE = "_Native__instance"
_API = "_Native__api_instance"
_FUNCTIONS = "_Native__c_args"


class SeamError(SimcoreError, RuntimeError):
    """The installed phoenix6 does not have the seam that the stand-in needs."""


_current: StandIn | None = None
_real: tuple[Any, Any] | None = None
_mirror = Mirror()


def check_seam() -> None:
    """Compare the installed phoenix6 with what the stand-in answers.

    Raises:
        SeamError: It does not fit; the text says what differs and which version would.
    """
    version = metadata.version("phoenix6")
    wrong = _misfit()
    if wrong:
        raise SeamError(
            f"phoenix6 {version} does not fit simulated time: {wrong}. "
            "Install phoenix6 26.3 (pip install 'phoenix6~=26.3.0')."
        )


def _misfit() -> str | None:
    """What the installed phoenix6 does not have; None when it fits."""
    for name in (_INSTANCE, _API, _FUNCTIONS):
        if not hasattr(Native, name):
            return f"its phoenix_native.Native has no {name.removeprefix('_Native')}"
    for structure, fields in (
        (SignalValues, ["devicehash", "spn"]),
        (
            ReturnValues,
            [
                "outValue",
                "unitsKey",
                "units",
                "hwtimestampseconds",
                "swtimestampseconds",
                "ecutimestampseconds",
                "error",
            ],
        ),
    ):
        if [field[0] for field in structure._fields_] != fields:
            return f"its {structure.__name__} has other fields"
    arguments = {name: len(types) for name, _, types in getattr(Native, _FUNCTIONS)}
    for kind in REQUESTS.values():
        found = arguments.get(f"{PREFIX}RequestControl{kind.name}")
        if found is not None and found != len(kind.fields) + 2:
            return f"its {kind.name} takes {found} arguments and not {len(kind.fields) + 2}"
    for name, function in vars(SimulatedNative).items():
        if not name.startswith("c_"):
            continue
        if name not in arguments:
            return f"it has no function {name}"
        taken = len(inspect.signature(function).parameters) - 1
        if taken != arguments[name]:
            return f"its {name} takes {arguments[name]} arguments and not {taken}"
    return None


def install(*, delays: EnableDelays | None = None, mirror: bool = False) -> StandIn:
    """Run Phoenix 6 in simulated time from here on; call before robot code builds its first device.

    A second call returns the devices of the first, reset.

    Args:
        delays: How much later than the enable feed the devices act.
        mirror: Whether device objects copy their outputs into WPILib SimDevices every tick, for the simulation GUI.

    Raises:
        SeamError: The installed phoenix6 does not fit.
    """
    global _current, _real
    stop_feed()
    if _current is not None:
        _current.reset()
        return _current
    check_seam()
    _real = (getattr(Native, _INSTANCE), getattr(Native, _API))
    _current = StandIn(delays)
    setattr(Native, _INSTANCE, SimulatedNative(_current))
    setattr(Native, _API, _current.api)
    if not mirror:
        _mirror.off()
    return _current


def installed() -> StandIn | None:
    """The devices in simulated time, or None when Phoenix 6 is its own self."""
    return _current


def uninstall() -> None:
    """Give Phoenix 6 its native libraries back; devices made in simulated time are of no more use."""
    global _current, _real
    stop_feed()
    if _real is not None:
        setattr(Native, _INSTANCE, _real[0])
        setattr(Native, _API, _real[1])
    _mirror.on()
    _current = _real = None

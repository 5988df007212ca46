"""Puts the stand-in in place of Phoenix 6's native libraries, and checks first that it fits."""

from __future__ import annotations

from importlib import metadata
from typing import Any

from phoenix6.phoenix_native import Native

from simcore.errors import SimcoreError
from simcore.phoenix6.standin.enable import EnableDelays
from simcore.phoenix6.standin.mirror import Mirror
from simcore.phoenix6.standin.native import SimulatedNative
from simcore.phoenix6.standin.requests import REQUESTS
from simcore.phoenix6.standin.world import StandIn

__all__ = ["SeamError", "check_seam", "install", "installed", "uninstall"]

_INSTANCE = "_Native__instance"
_API = "_Native__api_instance"


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
    advice = (
        f"phoenix6 {version} does not fit simulated time: {{}}. Install phoenix6 26.3.x (pip install 'phoenix6~=26.3')."
    )
    for name in (_INSTANCE, _API, "_Native__c_args"):
        if not hasattr(Native, name):
            raise SeamError(advice.format(f"phoenix_native.Native has no {name.removeprefix('_Native')}"))
    arguments = {name: len(types) for name, _, types in getattr(Native, "_Native__c_args")}
    for kind in REQUESTS.values():
        name = f"c_ctre_phoenix6_RequestControl{kind.name}"
        wanted = len(kind.fields) + 2
        if name in arguments and arguments[name] != wanted:
            raise SeamError(advice.format(f"{kind.name} has {arguments[name]} arguments instead of {wanted}"))


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
    if _real is not None:
        setattr(Native, _INSTANCE, _real[0])
        setattr(Native, _API, _real[1])
    _mirror.on()
    _current = _real = None

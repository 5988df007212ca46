"""What a mechanism is probably called, and of which kind it is, by names in robot code."""

from __future__ import annotations

import gc
import re
import types
from typing import Any

__all__ = ["holder_of", "mechanism_kind", "mechanism_name"]

_OF_MOTORS = {
    *("motor", "motors", "talon", "talonfx", "fx", "fxs", "spark", "max", "flex", "controller", "device", "leader"),
    *("main", "master", "primary", "kraken", "neo", "falcon", "vortex", "minion", "hardware", "the", "m", "k", "s"),
}
_OF_CLASSES = {
    *("subsystem", "component", "mechanism", "system", "robot", "container", "map", "hardware", "io", "real", "my"),
    *("main", "constants", "devices"),
}
_SIDES = {
    *("left", "right", "top", "bottom", "upper", "lower", "front", "back", "rear", "inner", "outer", "one", "two"),
    *("first", "second", "1", "2", "3", "4", "a", "b"),
}
_KINDS: dict[str, tuple[str, ...]] = {
    "turret": ("turret",),
    "arm": ("arm", "wrist", "pivot", "hood", "tilt", "shoulder", "elbow", "angle", "joint"),
    "elevator": ("elevator", "lift"),
    "rack": ("rack", "slide", "extension", "extender", "deploy"),
    "flywheel": ("flywheel", "shooter", "launcher"),
}
"""The first kind whose word is in a name: `intake_pivot` is an arm."""


def mechanism_name(attribute: str, owner: str = "") -> str:
    """A name in snake case without what says that it is a motor; empty if nothing is left.

    Args:
        attribute: Of the motor in robot code.
        owner: Class or module that has it, which is named where the attribute says a side alone.

    >>> mechanism_name("Feeder1Motor"), mechanism_name("shooterMotorTop"), mechanism_name("m_wristTalonFX")
    ('feeder1', 'shooter_top', 'wrist')
    >>> mechanism_name("motor", "IntakeSubsystem"), mechanism_name("_left_motor", "Climber"), mechanism_name("motor")
    ('intake', 'climber_left', '')
    """
    words = [word for word in _words(attribute) if word not in _OF_MOTORS]
    if not set(words) - _SIDES:
        words = [word for word in _words(owner) if word not in _OF_CLASSES and word not in words] + words
    return "_".join(words) if set(words) - _SIDES else ""


def mechanism_kind(name: str) -> str:
    """The kind of simcore.toml that a name, as `mechanism_name` has it, probably is of.

    >>> [mechanism_kind(name) for name in ("intake_pivot", "shooter_top", "feeder1")]
    ['arm', 'flywheel', 'roller']
    """
    words = set(re.findall(r"[a-z]+", name))
    return next((kind for kind, those in _KINDS.items() if words.intersection(those)), "roller")


def holder_of(device: Any) -> tuple[str, str]:
    """The attribute that holds a device, and the class or module that has the attribute; empty where none does."""
    found: list[tuple[str, str]] = []
    for owner in gc.get_referrers(device):
        names = owner if isinstance(owner, dict) else getattr(owner, "__dict__", {})
        name = next((key for key, value in list(names.items()) if value is device and isinstance(key, str)), "")
        if name:
            found.append((name, _owner_name(owner)))
    return max(found, key=lambda pair: bool(mechanism_name(*pair)), default=("", ""))


def _owner_name(owner: Any) -> str:
    """Of a namespace or the object that has it."""
    if isinstance(owner, dict):
        if "__name__" in owner or "__qualname__" in owner:
            return str(owner.get("__qualname__", owner.get("__name__"))).rsplit(".", 1)[-1]
        owners = [other for other in gc.get_referrers(owner) if getattr(other, "__dict__", None) is owner]
        return _owner_name(owners[0]) if owners else ""
    named = owner if isinstance(owner, (type, types.ModuleType)) else type(owner)
    return str(named.__name__).rsplit(".", 1)[-1]


def _words(name: str) -> list[str]:
    """`shooterMotorTop` and `SHOOTER_MOTOR_TOP` as words in lower case."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return [word.lower() for word in apart.split("_") if word]

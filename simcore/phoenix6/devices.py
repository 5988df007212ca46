"""Which CTRE devices the robot program builds: noted while it builds them, whatever it calls them."""

from __future__ import annotations

import functools
import weakref
from dataclasses import dataclass
from typing import Any

from phoenix6 import hardware

__all__ = ["Device", "built_devices", "clashes", "key_of", "remember_devices"]

MODELS = ("TalonFX", "TalonFXS", "CANcoder", "CANdi", "CANrange", "Pigeon2")


@dataclass(frozen=True, slots=True)
class Device:
    """One device that was built."""

    model: str
    device_id: int
    bus: str
    hardware: Any
    """The robot code's object."""

    @property
    def key(self) -> tuple[str, int]:
        """What the device simulation tells devices apart by: it does not know buses."""
        return self.model, self.device_id

    def __str__(self) -> str:
        return f"{self.model} {self.device_id}"


_built: list[tuple[str, weakref.ref[Any]]] = []


def remember_devices() -> None:
    """Note every device built from now on. Runs once when this module is imported, as physics is before the robot."""
    for model in MODELS:
        cls = getattr(hardware, model)
        build = cls.__init__
        if getattr(build, "_notes_devices", False):
            continue
        cls.__init__ = _noting(build, model)


def _noting(build: Any, model: str) -> Any:
    @functools.wraps(build)
    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        build(self, *args, **kwargs)
        if self.device_id >= 0:  # below zero: TalonFX.none(), which is no device
            _built.append((model, weakref.ref(self)))

    init._notes_devices = True  # type: ignore[attr-defined]
    return init


remember_devices()


def built_devices() -> list[Device]:
    """One per model and id, in the order they were built; the first object where a program has built two."""
    found: dict[tuple[str, int], Device] = {}
    for model, reference in _built:
        made = reference()
        if made is not None:
            device = Device(model, int(made.device_id), _bus(made), made)
            found.setdefault(device.key, device)
    return list(found.values())


def clashes() -> list[str]:
    """Devices that are two on the robot, on different buses, but one in the simulation; a sentence each."""
    buses: dict[tuple[str, int], set[str]] = {}
    for model, reference in _built:
        made = reference()
        if made is not None:
            buses.setdefault((model, int(made.device_id)), set()).add(_bus(made))
    return [
        f"{model} {number} is on the buses {', '.join(sorted(names))}: the device simulation knows ids only and makes "
        "them one"
        for (model, number), names in buses.items()
        if len(names) > 1
    ]


def key_of(made: Any) -> tuple[str, int]:
    """Model and id of a device object, whatever class a program derived."""
    model = next(m for m in MODELS if isinstance(made, getattr(hardware, m)))
    return model, int(made.device_id)


def _bus(made: Any) -> str:
    """The bus's name; an empty one and `rio` are the same bus."""
    network = getattr(made, "network", "")
    name = str(getattr(network, "name", network))
    return "rio" if name in ("", "rio") else name

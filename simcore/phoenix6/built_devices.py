"""Which CTRE devices the robot program builds, and which of its motor controllers turn one shaft."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Sequence
from typing import Any

from phoenix6 import hardware

from simcore.robot.motor_controllers import BuiltDevice, FollowerGroup

__all__ = ["built_devices", "clashes", "group_followers", "key_of"]

MODELS = ("TalonFX", "TalonFXS", "CANcoder", "CANdi", "CANdle", "CANrange", "Pigeon2")


_built: list[tuple[str, weakref.ref[Any]]] = []


def _record_devices() -> None:
    """Record every device built from now on. Runs once when this module is imported, as physics is before the robot."""
    for model in MODELS:
        cls = getattr(hardware, model)
        build = cls.__init__
        if getattr(build, "_records_devices", False):
            continue
        cls.__init__ = _recording(build, model)


def _recording(build: Any, model: str) -> Any:
    @functools.wraps(build)
    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        build(self, *args, **kwargs)
        if self.device_id >= 0:  # below zero: TalonFX.none(), which is no device
            _built.append((model, weakref.ref(self)))

    init._records_devices = True  # type: ignore[attr-defined]
    return init


_record_devices()


def built_devices() -> list[BuiltDevice]:
    """One per model and id, in the order they were built; the first object where a program has built two."""
    found: dict[tuple[str, int], BuiltDevice] = {}
    for model, reference in _built:
        made = reference()
        if made is not None:
            device = BuiltDevice(model, int(made.device_id), _bus(made), made)
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


def group_followers(devices: Sequence[BuiltDevice]) -> list[FollowerGroup]:
    """Groups by the `Follower` and `StrictFollower` requests that the devices hold now; one alone is a group too.

    A follower whose leader is not among the devices, or of another model, stands for itself.

    Args:
        devices: Motor controllers, one per model and id.
    """
    by_key = {device.key: device for device in devices}
    followers: dict[tuple[str, int], list[tuple[BuiltDevice, bool]]] = {}
    leaders = []
    for device in devices:
        request = device.hardware.control_request
        leader = getattr(request, "leader_id", None) if request.name in ("Follower", "StrictFollower") else None
        key = (device.model, leader) if leader is not None else None
        if key is None or key == device.key or key not in by_key:
            leaders.append(device)
        else:
            is_opposed = getattr(getattr(request, "motor_alignment", None), "name", "ALIGNED") == "OPPOSED"
            followers.setdefault(key, []).append((device, is_opposed))
    groups = []
    for device in leaders:
        own = followers.get(device.key, [])
        opposed = tuple(k for k, (_, is_opposed) in enumerate(own) if is_opposed)
        groups.append(FollowerGroup(device, tuple(d for d, _ in own), opposed))
    return groups

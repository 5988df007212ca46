"""Which SPARKs the robot program builds, which of them turn one shaft, and when they were configured last."""

from __future__ import annotations

import functools
import weakref
from collections.abc import Sequence
from typing import Any

import rev

from simcore.robot.motor_controllers import BuiltDevice, FollowerGroup

__all__ = ["MODELS", "built_sparks", "configuration_count", "group_sparks", "spark_of_controller"]

MODELS: dict[str, Any] = {"SPARK MAX": rev.SparkMax, "SPARK Flex": rev.SparkFlex}
"""Classes of robot code by the name that REV prints on the box, which is also that of their SimDevices."""

_built: list[tuple[str, weakref.ref[Any]]] = []
_configured: dict[tuple[str, int], int] = {}
_controllers: weakref.WeakKeyDictionary[Any, tuple[str, int]] = weakref.WeakKeyDictionary()


def _record_sparks() -> None:
    """Record every SPARK built from now on. Runs once when this module is imported, as physics is before the robot."""
    for model, cls in MODELS.items():
        if not getattr(cls.__init__, "_records_devices", False):
            cls.__init__ = _recording(cls.__init__, model)
            for name in ("configure", "configureAsync"):
                setattr(cls, name, _counting(getattr(cls, name), model))
            cls.getClosedLoopController = _remembering(cls.getClosedLoopController, model)


def _recording(build: Any, model: str) -> Any:
    @functools.wraps(build)
    def init(self: Any, *args: Any, **kwargs: Any) -> None:
        build(self, *args, **kwargs)
        _built.append((model, weakref.ref(self)))

    init._records_devices = True  # type: ignore[attr-defined]
    return init


def _counting(configure: Any, model: str) -> Any:
    @functools.wraps(configure)
    def counted(self: Any, *args: Any, **kwargs: Any) -> Any:
        answer = configure(self, *args, **kwargs)
        key = model, int(self.getDeviceId())
        _configured[key] = _configured.get(key, 0) + 1
        return answer

    return counted


def _remembering(get: Any, model: str) -> Any:
    @functools.wraps(get)
    def remembered(self: Any) -> Any:
        controller = get(self)
        _controllers[controller] = model, int(self.getDeviceId())
        return controller

    return remembered


_record_sparks()


def built_sparks() -> list[BuiltDevice]:
    """One per model and id, in the order they were built."""
    found: dict[tuple[str, int], BuiltDevice] = {}
    for model, reference in _built:
        made = reference()
        if made is not None:
            device = BuiltDevice(model, int(made.getDeviceId()), "rio", made)
            found.setdefault(device.key, device)
    return list(found.values())


def configuration_count(key: tuple[str, int]) -> int:
    """How often the program has configured a SPARK: when it rises, there is something to read again."""
    return _configured.get(key, 0)


def spark_of_controller(controller: Any) -> tuple[str, int] | None:
    """Model and id of the SPARK of a `SparkClosedLoopController`."""
    return _controllers.get(controller)


def group_sparks(devices: Sequence[BuiltDevice]) -> list[FollowerGroup]:
    """Groups by the follower mode that the SPARKs are configured with; one alone is a group too.

    A follower whose leader is not among the devices stands for itself. Leaders are known by their id only, as on the
    bus: a SPARK MAX may follow a SPARK Flex.

    Args:
        devices: SPARKs, one per model and id.
    """
    by_id = {device.device_id: device for device in devices}
    followers: dict[int, list[tuple[BuiltDevice, bool]]] = {}
    leaders = []
    for device in devices:
        accessor = device.hardware.configAccessor
        leader = int(accessor.getFollowerModeLeaderId()) if device.hardware.isFollower() else 0
        if leader in by_id and leader != device.device_id:
            followers.setdefault(leader, []).append((device, bool(accessor.getFollowerModeInverted())))
        else:
            leaders.append(device)
    groups = []
    for device in leaders:
        own = followers.get(device.device_id, [])
        opposed = tuple(k for k, (_, is_opposed) in enumerate(own) if is_opposed)
        groups.append(FollowerGroup(device, tuple(d for d, _ in own), opposed))
    return groups

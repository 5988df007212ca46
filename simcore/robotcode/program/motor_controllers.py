"""Motor controllers and sensors that a robot program has built, of any maker, and which of them turn one shaft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.quantities import DeviceAddress, DeviceKey

__all__ = ["BuiltDevice", "FollowerGroup", "group_by_leader"]


@dataclass(frozen=True, slots=True)
class BuiltDevice:
    """One device that was built."""

    model: str
    """As its maker writes it: `TalonFX`, `SPARK MAX`."""
    address: DeviceAddress
    hardware: Any
    """The robot code's object."""

    @property
    def key(self) -> DeviceKey:
        """Model and address."""
        return self.model, self.address

    def __str__(self) -> str:
        return f"{self.model} {self.address}"


@dataclass(frozen=True, slots=True)
class FollowerGroup:
    """Devices that turn together."""

    leader: BuiltDevice
    followers: tuple[BuiltDevice, ...] = ()
    opposed: tuple[int, ...] = ()
    """Which of the followers oppose the leader, by index."""

    @property
    def devices(self) -> tuple[BuiltDevice, ...]:
        """All, leader first."""
        return (self.leader, *self.followers)

    def __str__(self) -> str:
        return f"{self.leader}" + "".join(f" + {f.address}" for f in self.followers)


def group_by_leader(
    devices: Sequence[BuiltDevice], leader_of: Callable[[BuiltDevice], tuple[object, bool]]
) -> list[FollowerGroup]:
    """Groups by who follows whom; one alone is a group too, and a follower whose leader is not among the devices.

    Args:
        devices: Motor controllers, one per model and address.
        leader_of: Which device one follows, as its key, its address or its object (None: no other), and whether it
            opposes that.
    """
    leads = {device.key: leader_of(device) for device in devices}
    followers: dict[DeviceKey, list[BuiltDevice]] = {}
    leaders = []
    for device in devices:
        leader = leads[device.key][0]
        others = (d for d in devices if d is not device and leader is not None)
        led = next((d for d in others if leader in (d.key, d.address) or leader is d.hardware), None)
        if led is None:
            leaders.append(device)
        else:
            followers.setdefault(led.key, []).append(device)
    groups = []
    for device in leaders:
        own = followers.get(device.key, [])
        opposed = tuple(k for k, follower in enumerate(own) if leads[follower.key][1])
        groups.append(FollowerGroup(device, tuple(own), opposed))
    return groups

"""Motor controllers and sensors that a robot program has built, from any maker, and groups that share a shaft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from simcore.quantities import DeviceAddress, DeviceKey

__all__ = ["BuiltDevice", "FollowerGroup", "group_by_leader"]


@dataclass(frozen=True, slots=True)
class BuiltDevice:
    """Motor controller, sensor or other device that the program has built."""

    model: str
    """Model in the maker's spelling: `TalonFX`, `SPARK MAX`."""
    address: DeviceAddress
    hardware: Any
    """Robot code's object for the device."""

    @property
    def key(self) -> DeviceKey:
        """Model and address of the device."""
        return self.model, self.address

    def __str__(self) -> str:
        return f"{self.model} {self.address}"


@dataclass(frozen=True, slots=True)
class FollowerGroup:
    """Motor controllers that turn together: a leader and its followers."""

    leader: BuiltDevice
    followers: tuple[BuiltDevice, ...] = ()
    opposed: tuple[int, ...] = ()
    """Indices of followers that turn opposite to the leader."""

    @property
    def devices(self) -> tuple[BuiltDevice, ...]:
        """Leader and followers, leader first."""
        return (self.leader, *self.followers)

    def __str__(self) -> str:
        return f"{self.leader}" + "".join(f" + {f.address}" for f in self.followers)


def group_by_leader(
    devices: Sequence[BuiltDevice], leader_of: Callable[[BuiltDevice], tuple[object, bool]]
) -> list[FollowerGroup]:
    """Group motor controllers by leader.

    A controller without followers forms its own group, and so does a follower whose leader is missing.

    Args:
        devices: Motor controllers, one per model and address.
        leader_of: Function that returns the leader of a device as key, address or object (None if the device is not a
            follower), and whether the device turns opposite to the leader.
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

"""Which motor controllers turn one shaft: a leader and those that were told to follow it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from simcore.phoenix6.devices import Device

__all__ = ["Group", "group_followers"]


@dataclass(frozen=True, slots=True)
class Group:
    """Devices that turn together."""

    leader: Device
    followers: tuple[Device, ...] = ()
    opposed: tuple[int, ...] = ()
    """Which of the followers oppose the leader, by index."""

    @property
    def devices(self) -> tuple[Device, ...]:
        """All, leader first."""
        return (self.leader, *self.followers)

    def __str__(self) -> str:
        return f"{self.leader}" + "".join(f" + {f.device_id}" for f in self.followers)


def group_followers(devices: Sequence[Device]) -> list[Group]:
    """Groups by the `Follower` and `StrictFollower` requests that the devices hold now; one alone is a group too.

    A follower whose leader is not among the devices, or of another model, stands for itself.

    Args:
        devices: Motor controllers, one per model and id.
    """
    by_key = {device.key: device for device in devices}
    followers: dict[tuple[str, int], list[tuple[Device, bool]]] = {}
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
        groups.append(Group(device, tuple(d for d, _ in own), opposed))
    return groups

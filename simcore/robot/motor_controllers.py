"""Motor controllers and sensors that a robot program has built, of any maker, and which of them turn one shaft."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

__all__ = ["BuiltDevice", "FollowerGroup", "OwnLoops"]


@dataclass(frozen=True, slots=True)
class BuiltDevice:
    """One device that was built."""

    model: str
    """As its maker writes it: `TalonFX`, `SPARK MAX`."""
    device_id: int
    bus: str
    hardware: Any
    """The robot code's object."""

    @property
    def key(self) -> tuple[str, int]:
        """Model and id: buses make no difference in the device simulations."""
        return self.model, self.device_id

    def __str__(self) -> str:
        return f"{self.model} {self.device_id}"


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
        return f"{self.leader}" + "".join(f" + {f.device_id}" for f in self.followers)


@runtime_checkable
class OwnLoops(Protocol):
    """A motor controller whose loops no vendor's library runs in simulation: `SparkMotorSim`."""

    def run(self, dt: float) -> None:
        """Let its loops run for dt [s]."""
        ...

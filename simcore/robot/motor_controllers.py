"""Motor controllers and sensors that a robot program has built, of any maker, and which of them turn one shaft."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, runtime_checkable

from simcore.quantities import DeviceAddress, DeviceKey

__all__ = [
    "BuiltDevice", "ClosedLoop", "CurrentMeter", "FollowerGroup", "MotorDevices", "OwnLoops", "Setpoint",
    "group_by_leader",
]  # fmt: skip


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


class MotorDevices(Protocol):
    """The devices of a mechanism: `TalonFXMotorSim`, `SparkMotorSim`."""

    def read(self, battery_voltage: float, *, powered: bool = True) -> None:
        """Supply in, volts out to the mechanism [V]."""
        ...

    def write(self) -> None:
        """The mechanism's motion to the sensors."""
        ...


@runtime_checkable
class OwnLoops(Protocol):
    """A motor controller whose loops no vendor's library runs in simulation: `SparkMotorSim`."""

    def run(self, dt: float) -> None:
        """Let its loops run for dt [s]."""
        ...


@runtime_checkable
class DutyHolder(Protocol):
    """A motor controller that may hold a duty cycle between two of its loops, and not volts: `LoopDrivePort`."""

    def duty_cycle(self) -> float | None:
        """The share of its supply that it holds until it is asked next, positive as its volts; None: it holds volts."""
        ...


class Setpoint(NamedTuple):
    """What the closed loop of a motor controller is to reach, positive as its volts."""

    is_velocity: bool
    is_rotor: bool
    """Whether its sensor is the rotor's, and not one on what the motor turns."""
    turns: float
    """Velocity of the sensor's shaft [turns/s], or how far the shaft is to go from where it is now [turns]."""


@runtime_checkable
class ClosedLoop(Protocol):
    """A motor controller whose loops can be asked what they are to reach: `TalonPort`, `LoopDrivePort`."""

    def setpoint(self) -> Setpoint | None:
        """As robot code has commanded it; None: no loop of a position or a velocity runs, or it does not say."""
        ...


@runtime_checkable
class CurrentMeter(Protocol):
    """A motor controller that shows robot code the current of its motor, as the model has it: `LoopDrivePort`."""

    def show_current(self, amps: float) -> None:
        """Of one motor [A]."""
        ...

"""Emulator that creates the emulated devices, advances simulated time and sends status frames."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from phoenix6 import configs

from simcore.errors import ConfigError
from simcore.quantities import DeviceAddress
from simcore.robotcode.emulator.emulated_device import (
    LOOP_NS,
    Devices,
    EmulatedDevice,
    EnableDelays,
    EnableState,
    Setting,
    SimulatedClock,
    parse_config,
)
from simcore.robotcode.emulator.emulated_peripherals import (
    EmulatedCANcoder,
    EmulatedCANdi,
    EmulatedCANdle,
    EmulatedCANrange,
    EmulatedPigeon2,
)
from simcore.robotcode.emulator.emulated_talon import EmulatedTalon, EmulatedTalonFXS

__all__ = ["MODELS", "Emulator"]

_CLASSES: dict[int, type[EmulatedDevice]] = {
    cls.type_number: cls
    for cls in (
        *(EmulatedTalon, EmulatedCANcoder, EmulatedPigeon2, EmulatedTalonFXS),
        *(EmulatedCANrange, EmulatedCANdi, EmulatedCANdle),
    )
}
MODELS: dict[str, int] = {cls.model.lower(): number for number, cls in _CLASSES.items()}
"""`DeviceType` number of each modelled device, by the library's device name in lower case."""
_HASH_BASE = {4: 0x80, 5: 0x4140, 6: 0x8540, 7: 0xC080, 8: 0x10280, 9: 0x142C0, 10: 0x18580}
"""CTRE's device hash of a device with CAN ID 0, by `DeviceType` number. The emulator adds k << 20 for bus k."""
_CONFIGS = {
    4: configs.TalonFXConfiguration,
    5: configs.CANcoderConfiguration,
    6: configs.Pigeon2Configuration,
    7: configs.TalonFXSConfiguration,
    8: configs.CANrangeConfiguration,
    9: configs.CANdiConfiguration,
    10: configs.CANdleConfiguration,
}


@cache
def _defaults(type_number: int) -> dict[int, Setting]:
    """Return the factory configuration of a device type, by setting number."""
    make: Any = _CONFIGS[type_number]
    return parse_config(make().serialize())


@dataclass(slots=True)
class _FrameGroup:
    """Devices that send status frames at the same times."""

    due_ns: int
    period_ns: int
    devices: list[EmulatedDevice] = field(default_factory=list)


class _FrameSchedule:
    """Schedule of status frames. Devices that send at the same times are in one group.

    The groups replace a search of 22 devices, which took 4 us and ran six times per robot tick.
    """

    __slots__ = ("_devices", "_groups")

    def __init__(self) -> None:
        self._devices: list[EmulatedDevice] = []
        self._groups: list[_FrameGroup] = []

    def sort(self, devices: Iterable[EmulatedDevice]) -> None:
        """Group the devices that send frames by due time and period.

        Call this method after a change of the devices or of a frame rate.
        """
        self._devices = [device for device in devices if device.period_ms]
        groups: dict[tuple[int, int], _FrameGroup] = {}
        for device in self._devices:
            key = (device.due_ns, device.period_ms * LOOP_NS)
            groups.setdefault(key, _FrameGroup(*key)).devices.append(device)
        self._groups = list(groups.values())

    def send(self, now: int) -> int:
        """Send the frames that are due at time `now` [ns], and return the time of the next frame [ns].

        If no device sends frames, the returned time is one control loop after `now`.
        """
        due = [group for group in self._groups if group.due_ns <= now]
        # in order of construction, because a controller may read an encoder that sends at the same time
        devices = due[0].devices if len(due) == 1 else [d for d in self._devices if d.due_ns <= now]
        for group in due:
            group.due_ns += ((now - group.due_ns) // group.period_ns + 1) * group.period_ns
            for device in group.devices:
                device.due_ns = group.due_ns
        for device in devices:
            device.send_frame()
        return min([group.due_ns for group in self._groups], default=now + LOOP_NS)


class Emulator:
    """Emulator of the devices behind Phoenix 6's Python API.

    Args:
        delays: Delays from the enable feed to the devices' response; None for the defaults.

    Example:
        emulator = install()
        ...  # robot code builds its devices
        emulator.step(0.005)  # after each physics step
    """

    def __init__(self, delays: EnableDelays | None = None) -> None:
        self.clock = SimulatedClock()
        """Clock of simulated time, shared by all devices."""
        self.enable = EnableState(self.clock, delays or EnableDelays())
        """Enable signal, shared by all devices."""
        self._buses: dict[str, dict[tuple[int, int], EmulatedDevice]] = {"": {}}
        """Devices on each bus, by (`DeviceType` number, CAN ID)."""
        self.by_hash: dict[int, EmulatedDevice] = {}
        """All devices, by the library's device hash."""
        self._talons: list[EmulatedTalon] = []
        self._frames = _FrameSchedule()
        self._tasks: list[tuple[int, int, int, Callable[[], None]]] = []
        self._count = itertools.count()

    # ---- devices

    def create(self, type_number: int, address: DeviceAddress) -> EmulatedDevice:
        """Return the device of a type at an address, creating the device if needed.

        Raises:
            NotImplementedError: The device type is not modelled.
            ConfigError: The CAN ID is not 0..62.
        """
        bus, number = self._buses.setdefault(address.bus, {}), address.number
        device = bus.get((type_number, number))
        if device is None:
            if not 0 <= number <= 62:
                raise ConfigError(f"CAN id must be 0..62, got {number}")
            device = bus[type_number, number] = self._build(type_number, address, bus)
            self.by_hash[self.hash_of(device)] = device
            if isinstance(device, EmulatedTalon):
                self._talons.append(device)
            for talon in self._talons:
                talon.resolve()  # a controller may be configured before its remote sensor is built
        return device

    def hash_of(self, device: EmulatedDevice) -> int:
        """Return a device's hash, the number with which the library identifies the device."""
        return [*self._buses].index(device.address.bus) << 20 | _HASH_BASE[device.type_number] | device.address.number

    def simulated(self, type_number: int, number: int) -> EmulatedDevice:
        """Return the device that a `sim_state` call addresses.

        Args:
            type_number: `DeviceType` number of the device.
            number: Device hash from `hash_of`, or a CAN ID. A CAN ID selects the device on the first bus that has a
                device of this type with this ID.

        Raises:
            ConfigError: If there is no such device.
        """
        some = [bus[type_number, number] for bus in self._buses.values() if (type_number, number) in bus]
        device = self.by_hash.get(number) or next(iter(some), None)
        if device is None:
            raise ConfigError(f"no device of type {type_number} has the id or hash {number}; build it first")
        return device

    def _build(self, type_number: int, address: DeviceAddress, bus: Devices) -> EmulatedDevice:
        cls = _CLASSES.get(type_number)
        if cls is None:
            raise NotImplementedError(
                f"devices of type {type_number} (id {address}) are not modelled in simulated time"
            )
        defaults = _defaults(type_number)
        if issubclass(cls, EmulatedTalon):
            return cls(address, self.clock, defaults, bus)
        return cls(address, self.clock, defaults)

    def talon(self, number: int, bus: str = "") -> EmulatedTalon:
        """Return the TalonFX with a CAN ID on a bus, creating the device if needed."""
        device = self.create(EmulatedTalon.type_number, DeviceAddress(number, bus))
        assert isinstance(device, EmulatedTalon)
        return device

    def cancoder(self, number: int, bus: str = "") -> EmulatedCANcoder:
        """Return the CANcoder with a CAN ID on a bus, creating the device if needed."""
        device = self.create(EmulatedCANcoder.type_number, DeviceAddress(number, bus))
        assert isinstance(device, EmulatedCANcoder)
        return device

    def pigeon(self, number: int, bus: str = "") -> EmulatedPigeon2:
        """Return the Pigeon 2 with a CAN ID on a bus, creating the device if needed."""
        device = self.create(EmulatedPigeon2.type_number, DeviceAddress(number, bus))
        assert isinstance(device, EmulatedPigeon2)
        return device

    def __iter__(self) -> Iterator[EmulatedDevice]:
        return iter(self.by_hash.values())

    def reset(self) -> None:
        """Remove all devices and scheduled tasks, clear the enable signal and set simulated time to zero."""
        self.clock.reset()
        self.enable = EnableState(self.clock, self.enable.delays)
        self._buses = {"": {}}
        self.by_hash.clear()
        self._talons.clear()
        self._tasks.clear()
        self._count = itertools.count()

    # ---- time

    def every(self, period: float, task: Callable[[], None], *, offset: float = 0.0) -> Callable[[], None]:
        """Schedule a periodic task, and return a function that cancels the task.

        `step` runs the task. The first run is `offset` + `period` after the present simulated time.

        Args:
            period: Period, rounded to whole microseconds [s].
            task: Function to call after the devices have advanced to exactly the due time. Tasks due at the same time
                run in the order of the calls of `every`.
            offset: Additional delay of the first run, rounded to whole microseconds [s].

        Raises:
            ConfigError: The rounded period is not positive.
        """
        period_ns = round(period * 1e6) * 1000
        if period_ns <= 0:
            raise ConfigError(f"period must be > 0 s, got {period}")
        number = next(self._count)
        first = self.clock.ns + round(offset * 1e6) * 1000 + period_ns
        heapq.heappush(self._tasks, (first, number, period_ns, task))

        def cancel() -> None:
            self._tasks = [entry for entry in self._tasks if entry[1] != number]
            heapq.heapify(self._tasks)

        return cancel

    def step(self, dt: float) -> None:
        """Advance all devices by dt [s] with constant inputs from physics, and run each task at its due time.

        Raises:
            ConfigError: `dt` is negative.
        """
        if dt < 0.0:
            raise ConfigError(f"dt must be >= 0 s, got {dt}")
        end = self.clock.ns + round(dt * 1e9)
        while self._tasks and self._tasks[0][0] <= end:
            due, number, period, task = self._tasks[0]
            heapq.heapreplace(self._tasks, (due + period, number, period, task))
            self._advance(due)
            task()
        self._advance(end)

    def _advance(self, end: int) -> None:
        clock = self.clock
        loops = (end - clock.loop_ns) // LOOP_NS
        if loops > 0:
            enabled = self.enable.is_enabled
            for talon in self._talons:
                talon.run(loops, enabled)
            clock.loop_ns += loops * LOOP_NS
        clock.ns = end
        next_frame = clock.next_frame_ns
        if end < next_frame:
            return
        if next_frame == 0:
            self._frames.sort(self)
        clock.next_frame_ns = self._frames.send(end)

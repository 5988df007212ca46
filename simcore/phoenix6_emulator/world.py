"""All simulated devices, their time, and the step that moves them on."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable, Iterator

from simcore.errors import ConfigError
from simcore.phoenix6_emulator import factory
from simcore.phoenix6_emulator.api import SimulatedApi
from simcore.phoenix6_emulator.cancoder import CANcoder
from simcore.phoenix6_emulator.clock import LOOP_NS, SimulatedClock
from simcore.phoenix6_emulator.device import Device
from simcore.phoenix6_emulator.enable import EnableDelays, EnableState
from simcore.phoenix6_emulator.pigeon import Pigeon2
from simcore.phoenix6_emulator.schedule import FrameSchedule
from simcore.phoenix6_emulator.talon import Talon

__all__ = ["StandIn"]


class StandIn:
    """The devices behind the native seam.

    Args:
        delays: From the enable feed to the devices.

    Example:
        standin = install()
        ...  # robot code builds its devices
        standin.step(0.005)  # after each step of the physics
    """

    def __init__(self, delays: EnableDelays | None = None) -> None:
        self.clock = SimulatedClock()
        """Simulated time, common to all devices."""
        self.enable = EnableState(self.clock, delays or EnableDelays())
        """Whether actuators may drive."""
        self.devices: dict[tuple[int, int], Device] = {}
        """Every device by (`DeviceType` number, CAN id)."""
        self.by_hash: dict[int, Device] = {}
        """Every device by the number with which the library names it."""
        self.api = SimulatedApi()
        """Functions of the swerve library; `add` answers more of them."""
        self._talons: list[Talon] = []
        self._frames = FrameSchedule()
        self._tasks: list[tuple[int, int, int, Callable[[], None]]] = []
        self._count = itertools.count()
        self.loop_ns = 0
        """Time of the last control loop [ns]."""

    # ---- devices

    def create(self, type_number: int, device_id: int) -> Device:
        """The device of this type and id; made at the first call. The bus is not part of its name.

        Raises:
            NotImplementedError: Devices of this type are not modelled.
            ConfigError: The id is not 0..62.
        """
        device = self.devices.get((type_number, device_id))
        if device is None:
            if not 0 <= device_id <= 62:
                raise ConfigError(f"CAN id must be 0..62, got {device_id}")
            device = self.devices[type_number, device_id] = factory.build(type_number, device_id, self)
            self.by_hash[factory.hash_of(type_number, device_id)] = device
            if isinstance(device, Talon):
                self._talons.append(device)
            for talon in self._talons:
                talon.resolve()  # one that was configured before its remote sensor was built
        return device

    def talon(self, device_id: int) -> Talon:
        """The TalonFX with this id, made if need be."""
        device = self.create(Talon.type_number, device_id)
        assert isinstance(device, Talon)
        return device

    def cancoder(self, device_id: int) -> CANcoder:
        """The CANcoder with this id, made if need be."""
        device = self.create(CANcoder.type_number, device_id)
        assert isinstance(device, CANcoder)
        return device

    def pigeon(self, device_id: int) -> Pigeon2:
        """The Pigeon 2 with this id, made if need be."""
        device = self.create(Pigeon2.type_number, device_id)
        assert isinstance(device, Pigeon2)
        return device

    def __iter__(self) -> Iterator[Device]:
        return iter(self.devices.values())

    def reset(self) -> None:
        """Forget all devices, tasks and time, as for a fresh test."""
        self.clock.ns = self.clock.next_frame_ns = 0
        self.loop_ns = 0
        self.enable = EnableState(self.clock, self.enable.delays)
        self.devices.clear()
        self.by_hash.clear()
        self._talons.clear()
        self._tasks.clear()
        self._count = itertools.count()

    # ---- time

    def every(self, period: float, task: Callable[[], None], *, offset: float = 0.0) -> Callable[[], None]:
        """Call a task in simulated time from within `step`, first after `offset` + `period`; returns its cancel.

        Args:
            period: [s], whole microseconds.
            task: Runs with the devices at exactly that time; tasks of one time run in the order of their making.
            offset: [s]

        Raises:
            ConfigError: The period is not positive.
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
        """Move all devices on by dt [s]; what physics has written stays as it is meanwhile.

        Raises:
            ConfigError: dt is negative.
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
        loops = (end - self.loop_ns) // LOOP_NS
        if loops > 0:
            enabled = self.enable.is_enabled
            for talon in self._talons:
                talon.run(loops, enabled)
            self.loop_ns += loops * LOOP_NS
        self.clock.ns = end
        next_frame = self.clock.next_frame_ns
        if end < next_frame:
            return
        if next_frame == 0:
            self._frames.sort(self.devices.values())
        self.clock.next_frame_ns = self._frames.send(end)

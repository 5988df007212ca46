"""QuestNav's table on NetworkTables: publishes a headset's poses, and collects the commands of robot code."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import ntcore

from simcore.errors import ConfigError
from simcore.vision.camera_manager import NetworkClock
from simcore.vision.quest_headset import PoseReset, QuestFrame
from simcore.vision.questnav_wire import Command, device_message, frame_message, read_command, response_message

__all__ = ["TABLE", "QuestNavTable"]

_log = logging.getLogger(__name__)

TABLE = "QuestNav"
_FRAME = "proto:questnav.protos.data.ProtobufQuestNavFrameData"
_DEVICE = "proto:questnav.protos.data.ProtobufQuestNavDeviceData"
_RESPONSE = "proto:questnav.protos.commands.ProtobufQuestNavCommandResponse"
_DEVICE_PERIOD = 1.0 / 3.0  # [s], as QuestNav's protos/data.proto says


class QuestNavTable:
    """Speaks as the QuestNav app does.

    Source: QuestNav's NetworkTableConnection.cs and questnav-lib's QuestNav.java of 2026, for topics and types.

    Args:
        instance: Where; stays the caller's. In a robot program the default one.
        clock: From simulated time to NetworkTables' time.
    """

    def __init__(self, instance: ntcore.NetworkTableInstance, clock: NetworkClock) -> None:
        self._clock = clock
        every = ntcore.PubSubOptions(periodic=0.005, sendAll=True, keepDuplicates=True, pollStorage=20)
        topic = instance.getRawTopic
        self._frames = topic(f"/{TABLE}/frameData").publish(_FRAME, every)
        self._device = topic(f"/{TABLE}/deviceData").publish(_DEVICE, every)
        self._response = topic(f"/{TABLE}/response").publish(_RESPONSE, every)
        # Of any type: libraries publish it as "proto:..." or as "raw".
        self._request = instance.getTopic(f"/{TABLE}/request").genericSubscribe(every)
        self._next_device = 0.0
        self._is_closed = False

    def read(self) -> list[PoseReset]:
        """Pose resets since the last call, oldest first; every command is answered."""
        if self._is_closed:
            return []
        resets: list[PoseReset] = []
        for value in self._request.readQueue():
            if not value.isValid():
                continue
            command = _command(value)
            if command.problem:
                _log.warning("QuestNav: command %d: %s; it is ignored", command.number, command.problem)
            if command.reset is not None:
                resets.append(command.reset)
            self._response.set(response_message(command.number, command.problem))
        return resets

    def publish(self, frames: Sequence[QuestFrame], battery_percent: int) -> None:
        """Send poses, each with the time at which it was taken, and three times a second how the headset does."""
        for frame in frames:
            self._frames.set(frame_message(frame), self._clock.to_network(frame.time))
        last = frames[-1]
        if last.time >= self._next_device:
            self._next_device = last.time + _DEVICE_PERIOD
            self._device.set(device_message(battery_percent), self._clock.to_network(last.time))

    def close(self) -> None:
        """Withdraw the topics; may be called twice. The instance lives on."""
        self._is_closed = True
        for publisher in (self._frames, self._device, self._response):
            publisher.close()


def _command(value: ntcore.Value) -> Command:
    if not value.isRaw():
        return Command(0, None, "needs a ProtobufQuestNavCommand in raw bytes")
    try:
        return read_command(bytes(value.getRaw()))
    except ConfigError as error:
        return Command(0, None, str(error))

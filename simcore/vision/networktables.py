"""Cameras on NetworkTables: each publishes its frames in a table of its own; one poller collects what robot code asks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import ntcore

from simcore.vision.camera import CameraConfig
from simcore.vision.clock import NetworkClock
from simcore.vision.frames import Frame
from simcore.vision.limelight import Request
from simcore.vision.settings import INPUTS
from simcore.vision.wire import EVERY_FRAME, TOPICS, Value, constant_values, frame_values
from simcore.vision.wire_json import frame_json

__all__ = ["LimelightTable", "RequestPoller"]

_ORIENTATION = "robot_orientation_set"
_EVERY = 0.005  # [s]; how soon ntcore sends


class RequestPoller:
    """Requests to all cameras of one NetworkTables instance.

    One poller for all: asking ten subscribers of three cameras takes 30 us a tick, three pollers 12, one 8.

    Args:
        instance: Stays the caller's.
        clock: From NetworkTables' time to simulated time.
    """

    def __init__(self, instance: ntcore.NetworkTableInstance, clock: NetworkClock) -> None:
        self._instance = instance
        self._clock = clock
        self._poller = ntcore.NetworkTableListenerPoller(instance)
        self._topics: dict[int, tuple[list[Request], str]] = {}
        self._subscribers: dict[str, list[Any]] = {}

    def add(self, table: str) -> list[Request]:
        """Listen to a camera's table; `poll` appends to the list that this returns, oldest first."""
        requests: list[Request] = []
        options = ntcore.PubSubOptions(periodic=_EVERY, sendAll=True, keepDuplicates=True)
        now = ntcore.EventFlags.kValueAll | ntcore.EventFlags.kImmediate
        subscribers = self._subscribers[table] = []
        for name in (*INPUTS, _ORIENTATION):
            subscribers.append(self._instance.getTopic(f"{table}/{name}").genericSubscribe(options))
            self._topics[self._poller.addListener(subscribers[-1], now)] = (requests, name)
        return requests

    def poll(self) -> None:
        """Take what was written since the last call."""
        for event in self._poller.readQueue():
            value = event.data.value
            requests, name = self._topics[event.listener]
            requests.append(Request(name, _numbers(value), self._clock.to_simulated(value.time())))

    def close(self) -> None:
        """Stop listening; may be called twice."""
        self._poller.close()
        self._subscribers.clear()  # a GenericSubscriber has no close; it ends with its last reference


class LimelightTable:
    """Speaks as a Limelight does, under the camera's name.

    Args:
        instance: Where; stays the caller's. In a robot program the default one.
        config: The camera.
        field_size: Length and width [m], for poses with another origin.
        clock: From simulated time to NetworkTables' time.
        poller: Shared with other cameras of the instance; None: one of its own.
    """

    def __init__(
        self,
        instance: ntcore.NetworkTableInstance,
        config: CameraConfig,
        field_size: tuple[float, float],
        clock: NetworkClock,
        poller: RequestPoller | None = None,
    ) -> None:
        self._config = config
        self._field_size = field_size
        self._clock = clock
        table = f"/{config.name}"
        plain = ntcore.PubSubOptions(periodic=_EVERY)
        repeat = ntcore.PubSubOptions(periodic=_EVERY, sendAll=True, keepDuplicates=True)
        self._publishers: dict[str, Any] = {}
        for name, kind in TOPICS.items():
            options = repeat if name in EVERY_FRAME else plain
            self._publishers[name] = _publish(instance, f"{table}/{name}", kind, options)
        constant = constant_values(config)
        for name, value in constant.items():
            self._publishers[name].set(value, clock.to_network(0.0))
        self._setters: list[tuple[str, bool, Callable[[Any, int], None]]] = [
            (name, name in EVERY_FRAME, publisher.set)
            for name, publisher in self._publishers.items()
            if name not in constant
        ]
        """Topics of every frame: name, whether it is sent even if it has not changed, and what sends it."""
        self._poller = poller if poller is not None else RequestPoller(instance, clock)
        self._requests = self._poller.add(table)
        self._last: Mapping[str, Value | None] = dict.fromkeys(TOPICS)

    def read(self) -> list[Request]:
        """Requests since the last call, in order."""
        self._poller.poll()
        requests = self._requests.copy()
        self._requests.clear()
        return requests

    def publish(self, frame: Frame) -> None:
        """Send a frame; all topics carry the time at which it left the camera."""
        stamp = self._clock.to_network(frame.published)
        values = frame_values(frame, self._config, self._field_size)
        last, self._last = self._last, values
        for name, is_repeated, set_value in self._setters:
            value = values[name]
            if is_repeated or last[name] != value:  # a comparison is cheaper than a value that is dropped
                set_value(value, stamp)
        if frame.json:
            self._publishers["json"].set(frame_json(frame, values, stamp), stamp)

    def close(self) -> None:
        """Withdraw the topics; may be called twice. The instance lives on."""
        for publisher in self._publishers.values():
            publisher.close()
        self._poller.close()


def _publish(instance: ntcore.NetworkTableInstance, topic: str, kind: str, options: ntcore.PubSubOptions) -> Any:
    if kind == "int":
        return instance.getIntegerTopic(topic).publish(options)
    if kind == "double":
        return instance.getDoubleTopic(topic).publish(options)
    if kind == "string":
        return instance.getStringTopic(topic).publish(options)
    if kind == "string[]":
        return instance.getStringArrayTopic(topic).publish(options)
    return instance.getDoubleArrayTopic(topic).publish(options)


def _numbers(value: Any) -> tuple[float, ...] | None:
    """Numbers of a value, of whatever kind robot code took; None: it is none."""
    if value.isDoubleArray():  # nearly always: the heading
        return tuple(value.value())
    if value.isDouble() or value.isInteger() or value.isFloat():
        return (float(value.value()),)
    if value.isIntegerArray() or value.isFloatArray():
        return tuple(float(v) for v in value.value())
    return None

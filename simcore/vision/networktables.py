"""A camera's table on NetworkTables: publishes each frame, and collects what robot code asks for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import ntcore

from simcore.vision.camera import CameraConfig
from simcore.vision.clock import NetworkClock
from simcore.vision.frames import Frame
from simcore.vision.limelight import Request
from simcore.vision.settings import INPUTS
from simcore.vision.wire import EVERY_FRAME, TOPICS, Value, constant_values, frame_values
from simcore.vision.wire_json import frame_json

__all__ = ["LimelightTable"]

_ORIENTATION = "robot_orientation_set"
_EVERY = 0.005  # [s]; how soon ntcore sends


class LimelightTable:
    """Speaks as a Limelight does, under the camera's name.

    Args:
        instance: Where; stays the caller's. In a robot program the default one.
        config: The camera.
        field_size: Length and width [m], for poses with another origin.
        clock: From simulated time to NetworkTables' time.
    """

    def __init__(
        self,
        instance: ntcore.NetworkTableInstance,
        config: CameraConfig,
        field_size: tuple[float, float],
        clock: NetworkClock,
    ) -> None:
        self._config = config
        self._field_size = field_size
        self._clock = clock
        table = f"/{config.name}"
        plain = ntcore.PubSubOptions(periodic=_EVERY)
        repeat = ntcore.PubSubOptions(periodic=_EVERY, sendAll=True, keepDuplicates=True)
        self._publishers: dict[str, Any] = {}
        self._set: dict[str, Callable[[Any, int], None]] = {}
        for name, kind in TOPICS.items():
            publisher = _publish(instance, f"{table}/{name}", kind, repeat if name in EVERY_FRAME else plain)
            self._publishers[name], self._set[name] = publisher, publisher.set
        for name, value in constant_values(config).items():
            self._set[name](value, clock.to_network(0.0))
        listen = ntcore.PubSubOptions(periodic=_EVERY, sendAll=True, keepDuplicates=True)
        self._inputs = {
            name: instance.getTopic(f"{table}/{name}").genericSubscribe(listen) for name in (*INPUTS, _ORIENTATION)
        }
        # One poller for all: asking ten subscribers takes 10 us.
        self._poller = ntcore.NetworkTableListenerPoller(instance)
        now = ntcore.EventFlags.kValueAll | ntcore.EventFlags.kImmediate
        self._topics = {self._poller.addListener(sub, now): name for name, sub in self._inputs.items()}
        self._last: dict[str, Value] = {}

    def read(self) -> list[Request]:
        """Requests since the last call, in order."""
        requests: list[Request] = []
        for event in self._poller.readQueue():
            value = event.data.value
            name = self._topics[event.listener]
            requests.append(Request(name, _numbers(value), self._clock.to_simulated(value.time())))
        return requests

    def publish(self, frame: Frame) -> None:
        """Send a frame; all topics carry the time at which it left the camera."""
        stamp = self._clock.to_network(frame.published)
        values = frame_values(frame, self._config, self._field_size)
        if frame.json:
            values["json"] = frame_json(frame, values, stamp)
        last, self._last = self._last, values
        setters = self._set
        for name, value in values.items():
            if name in EVERY_FRAME or last.get(name) != value:  # a comparison is cheaper than a value that is dropped
                setters[name](value, stamp)

    def close(self) -> None:
        """Withdraw the topics; may be called twice. The instance lives on."""
        for publisher in self._publishers.values():
            publisher.close()
        self._poller.close()
        self._inputs.clear()  # a GenericSubscriber has no close; it ends with its last reference


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

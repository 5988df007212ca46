"""A camera's table on NetworkTables: publishes each frame, and collects the requests of robot code."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from simcore import season
from simcore.vision.camera import CameraConfig
from simcore.vision.camera_frame import Frame
from simcore.vision.camera_manager import NetworkClock
from simcore.vision.limelight import CameraRequest
from simcore.vision.limelight_settings import INPUTS
from simcore.vision.limelight_wire import (
    EVERY_FRAME,
    FRAME_TOPICS,
    TOPICS,
    Value,
    constant_values,
    frame_json,
    frame_values,
)

__all__ = ["LimelightTable"]

_ORIENTATION = "robot_orientation_set"
_EVERY = 0.005  # [s]; how soon ntcore sends
_MOST_HEADINGS = 100  # that are kept for a tick; a team's odometry thread sends up to 250 a second
_KINDS = {
    "int": "integer",
    "double": "double",
    "string": "string",
    "string[]": "string_array",
    "double[]": "double_array",
}
"""How ntcore calls the types of `TOPICS`."""


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
        instance: season.NetworkTables,
        config: CameraConfig,
        field_size: tuple[float, float],
        clock: NetworkClock,
    ) -> None:
        self._config = config
        self._field_size = field_size
        self._clock = clock
        table = f"/{config.name}"
        plain = season.pub_sub_options(periodic=_EVERY)
        repeat = season.pub_sub_options(periodic=_EVERY, send_all=True, keep_duplicates=True)
        self._publishers: dict[str, Any] = {}
        for name, kind in TOPICS.items():
            options = repeat if name in EVERY_FRAME else plain
            self._publishers[name] = getattr(instance, f"get_{_KINDS[kind]}_topic")(f"{table}/{name}").publish(options)
        for name, value in constant_values(config).items():
            self._publishers[name].set(value, clock.to_network(0.0))
        listen = season.pub_sub_options(
            periodic=_EVERY, send_all=True, keep_duplicates=True, poll_storage=_MOST_HEADINGS
        )
        self._inputs = {
            name: instance.get_topic(f"{table}/{name}").generic_subscribe(listen) for name in (*INPUTS, _ORIENTATION)
        }
        # One poller for what is rarely written: asking nine subscribers takes 9 us. The heading comes every tick, and
        # an event takes twice as long to unpack as a value.
        self._poller = season.ntcore.NetworkTableListenerPoller(instance)
        flags = season.ntcore.EventFlags
        now = flags.VALUE_ALL | flags.IMMEDIATE
        self._topics = {self._poller.add_listener(self._inputs[name], now): name for name in INPUTS}
        self._prefix = f"{table}/"
        published = flags.PUBLISH | flags.IMMEDIATE
        self._others = self._poller.add_listener([self._prefix], published)
        self._last: list[Value | None] = [None] * len(FRAME_TOPICS)
        self._setters: list[Callable[[Any, int], None]] = [self._publishers[name].set for name in FRAME_TOPICS]
        self._is_repeated = [name in EVERY_FRAME for name in FRAME_TOPICS]

    def read(self) -> list[CameraRequest]:
        """Requests since the last call: headings in order, then settings in order; none once it is closed.

        A topic that a `LimelightSim` has no use for comes once, without numbers.
        """
        orientation = self._inputs.get(_ORIENTATION)
        if orientation is None:
            return []
        # The first value of a topic without any is none.
        requests = [self._request(_ORIENTATION, value) for value in orientation.read_queue() if value.is_valid()]
        for event in self._poller.read_queue():
            if event.listener == self._others:
                topic = event.data.name.removeprefix(self._prefix)
                if topic not in TOPICS and topic not in self._inputs:
                    requests.append(CameraRequest(topic, None))
            else:
                requests.append(self._request(self._topics[event.listener], event.data.value))
        return requests

    def _request(self, topic: str, value: Any) -> CameraRequest:
        return CameraRequest(topic, _numbers(value), self._clock.to_simulated(value.time()))

    def publish(self, frame: Frame) -> None:
        """Send a frame; all topics carry the time at which it left the camera."""
        stamp = self._clock.to_network(frame.published)
        values = frame_values(frame, self._config, self._field_size)
        last, self._last = self._last, [*values.values()]
        for value, before, is_repeated, set_value in zip(
            self._last, last, self._is_repeated, self._setters, strict=True
        ):
            if value != before or is_repeated:  # a comparison is cheaper than a value that is dropped
                set_value(value, stamp)
        if frame.json:
            self._publishers["json"].set(frame_json(frame, values, stamp), stamp)

    def close(self) -> None:
        """Withdraw the topics; may be called twice. The instance lives on."""
        for publisher in self._publishers.values():
            publisher.close()
        self._poller.close()
        self._inputs.clear()  # a GenericSubscriber has no close; it ends with its last reference


def _numbers(value: Any) -> tuple[float, ...] | None:
    """Numbers of a value of any type that robot code may write; None: it holds no numbers."""
    if value.is_double_array():  # nearly always: the heading
        return tuple(value.value())
    if value.is_double() or value.is_integer() or value.is_float():
        return (float(value.value()),)
    if value.is_integer_array() or value.is_float_array():
        return tuple(float(v) for v in value.value())
    return None

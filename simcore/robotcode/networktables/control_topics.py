"""NetworkTables topics that let a dashboard control a match.

`Sim/Control/` contains buttons, choosers, numbers, poses and positions. A button is a boolean that a dashboard sets to
true and `ControlTopics` resets. A chooser has the format of WPILib's `SendableChooser`. The numbers give the position
at which a button acts, and programs write the poses and positions. `Sim/HumanPlayer/` contains a button for each human
player action.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from simcore import season
from simcore.errors import ConfigError, SimcoreError
from simcore.match.match import Match
from simcore.quantities import shown

__all__ = ["TABLE", "ControlTopics"]

TABLE = "/Sim/Control/"
_HUMAN_TABLE = "/Sim/HumanPlayer/"
_POSE2D = struct.Struct("<3d")  # x, y [m], angle [rad]: the struct schema of WPILib's Pose2d
# Each write of a program counts, even of an unchanged value.
_OPTIONS = season.pub_sub_options(periodic=0.02, poll_storage=100, send_all=True, keep_duplicates=True)


class ControlTopics:
    """Listener for dashboard commands to a match, which also publishes the result of each command.

    Tests must not use this class, because values arrive on the wall clock and two runs would differ.

    Args:
        match: Match whose `control` executes the commands before each tick.
        instance: NetworkTables instance of the dashboards, owned by the caller.
        robot: Index of the robot to which the commands apply.
    """

    def __init__(self, match: Match, instance: season.NetworkTables, *, robot: int = 0) -> None:
        self._match, self._control, self._instance = match, match.control, instance
        self._publishers: dict[str, Any] = {}
        self._values: dict[str, Any] = {}
        """Last published value of each topic."""
        self._choices: dict[str, str] = {}
        # Subscribe before publishing, to get the type of a topic that a dashboard has already created.
        self._everything = season.ntcore.MultiSubscriber(instance, [TABLE, _HUMAN_TABLE], _OPTIONS)
        self._poller = season.ntcore.NetworkTableListenerPoller(instance)
        flags = season.ntcore.EventFlags
        self._poller.add_listener(self._everything, flags.VALUE_ALL | flags.IMMEDIATE)
        kinds = [supply.kind.name for supply in match.game.pieces]
        do = self._control.do
        self._buttons: dict[str, Callable[[], object]] = {
            "ResetField": lambda: do("reset", {}),
            "PlaceRobot": lambda: do("place", {"pose": self._place(), "robot": robot}),
            "PlaceAtStart": lambda: do("start", {"robot": robot}),
        }
        self._written: dict[str, Callable[[Any], object]] = {
            "RobotPose": lambda value: do("place", {"pose": _pose_of(value), "robot": robot}),
            **{f"Spawn/{kind}": partial(self._spawn, kind) for kind in kinds},
        }
        if kinds:
            self._chooser("Piece", kinds)
            self._buttons["SpawnPiece"] = lambda: do(
                "put_down", {"kind": self._choices["Piece/selected"], "places": [self._place()[:2]]}
            )
        if match.game.autos and match.robots[robot].devices is None:
            self._chooser("Auto", list(match.game.autos))
            self._buttons["StartAuto"] = lambda: do("auto", {"name": self._choices["Auto/selected"], "robot": robot})
        x, y, yaw = match.start_pose(robot)
        self._numbers = {"X": x, "Y": y, "HeadingDeg": math.degrees(yaw)}
        for name, value in self._numbers.items():
            number = self._publishers[TABLE + name] = instance.get_double_topic(TABLE + name).get_entry(value, _OPTIONS)
            number.set_default(value)  # a default does not override the dashboard's value
        for button in self._buttons:
            self._publish("boolean", TABLE + button, False)
        if names := [action.name for action in match.rules.human_actions()]:
            self._publish("string_array", f"{_HUMAN_TABLE}Actions", names)
        for button in (f"{alliance}/{name}" for alliance in ("Blue", "Red") for name in names):
            self._publish("boolean", _HUMAN_TABLE + button, False)
        self._publish_results()
        now = instance.get_integer_topic(f"{TABLE}Count").subscribe(0)
        self._since = now.get_atomic().time  # older values, kept by a dashboard from an earlier run, are not commands
        now.close()
        self._control.sources.append(self.read)

    def read(self) -> None:
        """Publish the results of earlier commands, then pass new commands to the match control in timestamp order."""
        self._publish_results()
        for event in sorted(self._poller.read_queue(), key=lambda event: event.data.value.time()):
            topic, value = event.data.topic.get_name(), event.data.value
            try:
                if topic.startswith(TABLE):
                    self._take(topic.removeprefix(TABLE), value)
                elif value.time() > self._since:
                    self._take_of_people(topic.removeprefix(_HUMAN_TABLE), value.value())
            except SimcoreError as error:
                self._control.refuse(f"carry out {topic}", str(error))

    def close(self) -> None:
        """Unpublish the topics and stop listening; safe to call more than once."""
        if self.read in self._control.sources:
            self._control.sources.remove(self.read)
        for one in (self._poller, self._everything, *self._publishers.values()):
            one.close()

    # --- received values ------------------------------------------------------------------------------------------

    def _take(self, name: str, value: Any) -> None:
        """Store a number or choice, or request the action of a pose or button.

        The method ignores numbers, choices and buttons of the wrong type, and actions older than this object.
        """
        content = value.value()
        if name in self._numbers:
            if isinstance(content, float):
                self._numbers[name] = content
        elif name in self._choices:
            if isinstance(content, str):
                self._choices[name] = content
                self._publish("string", TABLE + name.replace("selected", "active"), content)
        elif value.time() <= self._since:
            return
        elif name in self._written:
            self._written[name](value)
        elif name in self._buttons and content is True:
            self._release(TABLE + name)
            self._buttons[name]()

    def _take_of_people(self, name: str, value: object) -> None:
        """Request a human player action or a change of manual control.

        Raises:
            ConfigError: The value is not a boolean.
        """
        if name == "Actions" or "/Ready/" in name:
            return
        alliance, _, action = name.partition("/")
        if not isinstance(value, bool):
            raise ConfigError(f"a button is a boolean that is set to true, got {shown(value)}")
        if action == "Manual":
            if value != self._values.get(_HUMAN_TABLE + name):  # an equal value comes from this object
                self._values[_HUMAN_TABLE + name] = value
                self._control.do("take_over", {"alliance": alliance.lower(), "by_person": value})
        elif value:
            self._release(_HUMAN_TABLE + name)
            self._control.do("human", {"alliance": alliance.lower(), "name": action})

    def _spawn(self, kind: str, value: Any) -> None:
        numbers = _array_of(value)
        if len(numbers) % 2:
            raise ConfigError(f"places are pairs x, y [m]; got {len(numbers)} numbers, {numbers}")
        places = [numbers[k : k + 2] for k in range(0, len(numbers), 2)]
        self._control.do("put_down", {"kind": kind, "places": places})

    def _place(self) -> tuple[float, float, float]:
        return self._numbers["X"], self._numbers["Y"], math.radians(self._numbers["HeadingDeg"])

    # --- published values -----------------------------------------------------------------------------------------

    def _publish_results(self) -> None:
        control = self._control
        if control.count != self._values.get(f"{TABLE}Count"):
            self._publish("string", f"{TABLE}Status", str(control.results[-1]) if control.results else "0 ready")
            self._publish("integer", f"{TABLE}Count", control.count)
        for action in self._match.rules.human_actions():
            for alliance, feeder in action.feeders.items():
                folder = _HUMAN_TABLE + alliance.capitalize()
                self._publish("boolean", f"{folder}/Manual", alliance in self._match.persons)
                self._publish("integer", f"{folder}/Ready/{action.name}", feeder.stock)

    def _publish(self, kind: str, topic: str, value: Any) -> None:
        """Publish a value on a topic, which the first call creates, if the value has changed."""
        if topic not in self._publishers:
            full = getattr(self._instance, f"get_{kind}_topic")(topic)
            self._publishers[topic] = full.publish(_OPTIONS)
        if value != self._values.get(topic):
            self._values[topic] = value
            self._publishers[topic].set(value)

    def _release(self, button: str) -> None:
        if button in self._publishers:
            self._publishers[button].set(False)

    def _chooser(self, name: str, options: Sequence[str]) -> None:
        """Publish the topics that `SmartDashboard.putData` publishes for a SendableChooser."""
        table = f"{TABLE}{name}/"
        for key, text in (
            (".type", "String Chooser"),
            (".name", name),
            ("default", options[0]),
            ("active", options[0]),
        ):
            self._publish("string", table + key, text)
        self._publish("integer", f"{table}.instance", 0)
        self._publish("string_array", f"{table}options", list(options))
        self._choices[f"{name}/selected"] = options[0]


def _pose_of(value: Any) -> tuple[float, ...]:
    """Return x, y [m] and heading [rad] from a `Pose2d`, or from a `Field2d` array with the heading in degrees."""
    if value.is_raw() and len(value.get_raw()) == _POSE2D.size:
        return _POSE2D.unpack(value.get_raw())
    numbers = _array_of(value)
    if len(numbers) != 3:
        raise ConfigError(f"a pose is x, y [m] and heading [deg], three numbers; got {numbers}")
    return (*numbers[:2], math.radians(numbers[2]))


def _array_of(value: Any) -> list[float]:
    for is_one, get in (
        (value.is_double_array, value.get_double_array),
        (value.is_float_array, value.get_float_array),
        (value.is_integer_array, value.get_integer_array),
    ):
        if is_one():
            return [float(number) for number in get()]
    return []

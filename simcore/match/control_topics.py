"""The commands of `FieldControl` as NetworkTables topics under `Sim/Control/`, for any dashboard.

Buttons are booleans that somebody sets to true and that are set back here; numbers say where a button acts; choosers
look like a `SendableChooser` of WPILib. Programs write a pose or places, and that is the command.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from simcore import season
from simcore.errors import ConfigError, SimcoreError
from simcore.match.human_actions import ALLIANCES
from simcore.match.match import Match
from simcore.quantities import shown

__all__ = [
    "TABLE",
    "ControlTopics",
]

_HUMAN_TABLE = "/Sim/HumanPlayer/"


class HumanTopics:
    """Listens to the whole table, so that a misspelled topic is told, too.

    Args:
        match: Its `control` gets the commands and says what became of them.
        instance: On which dashboards are; stays the caller's.
        since: What was written before is no command [us of the clock of NetworkTables].
    """

    def __init__(self, match: Match, instance: season.NetworkTables, since: int) -> None:
        self._match, self._instance, self._since = match, instance, since
        self._publishers: dict[str, Any] = {}
        self._values: dict[str, Any] = {}  # by topic, as everybody knows them
        self._poller = season.ntcore.NetworkTableListenerPoller(instance)
        self._poller.add_listener([_HUMAN_TABLE], season.ntcore.EventFlags.VALUE_ALL)
        names = [action.name for action in match.rules.human_actions()]
        if names:
            self._publish("string_array", "Actions", names)
        self._buttons = {f"{alliance.capitalize()}/{name}" for alliance in ALLIANCES for name in names}
        for button in sorted(self._buttons):
            self._publish("boolean", button, False)
        self._publish_all()

    def read(self) -> None:
        """Give the commands that have arrived, and tell how things stand."""
        self._publish_all()
        for event in self._poller.read_queue():
            topic, value = event.data.topic.get_name().removeprefix(_HUMAN_TABLE), event.data.value
            if value.time() > self._since and topic != "Actions" and "/Ready/" not in topic:
                self._carry_out(topic, value.value())

    def close(self) -> None:
        """Withdraw the topics and listen no more; may be called twice."""
        for one in (self._poller, *self._publishers.values()):
            one.close()

    # --- inside ---------------------------------------------------------------------------------------------------

    def _carry_out(self, topic: str, value: object) -> None:
        alliance, _, name = topic.partition("/")
        if not isinstance(value, bool):
            why = f"a button is a boolean that is set to true, got {shown(value)}"
            self._match.control.refuse(f"hear {_HUMAN_TABLE}{topic}", why)
        elif name == "Manual":
            if value != self._values.get(topic):  # otherwise it is what was told here
                self._values[topic] = value
                self._match.control.take_over(alliance.lower(), value)
        elif value:
            if topic in self._buttons:
                self._publishers[topic].set(False)
            self._match.control.human_action(alliance.lower(), name)

    def _publish_all(self) -> None:
        for action in self._match.rules.human_actions():
            for name, alliance in ALLIANCES.items():
                folder = name.capitalize()
                self._publish("boolean", f"{folder}/Manual", alliance in self._match.persons)
                self._publish("integer", f"{folder}/Ready/{action.name}", action.feeders[alliance].stock)

    def _publish(self, kind: str, topic: str, value: Any) -> None:
        if topic not in self._publishers:
            full = getattr(self._instance, f"get_{kind}_topic")(f"{_HUMAN_TABLE}{topic}")
            self._publishers[topic] = full.publish(season.pub_sub_options(keep_duplicates=True))
        if value != self._values.get(topic):
            self._values[topic] = value
            self._publishers[topic].set(value)


TABLE = "/Sim/Control"

_POSE2D = struct.Struct("<3d")  # x, y [m], angle [rad]: the struct schema of WPILib's Pose2d
# What this publishes itself is no command. Each write of a program counts, also of the same value as before.
_OPTIONS = season.pub_sub_options(
    periodic=0.02, poll_storage=100, send_all=True, keep_duplicates=True, exclude_self=True
)


class ControlTopics:
    """Listens for commands to one robot and its field, and publishes what became of them.

    Not for tests: values arrive with the wall clock, so that two runs would differ.

    Args:
        match: Its `control` gets the commands; it looks for them before every tick.
        instance: On which dashboards are; stays the caller's.
        robot: Which robot of the match is placed.
    """

    def __init__(self, match: Match, instance: season.NetworkTables, *, robot: int = 0) -> None:
        self._match = match
        self._control = match.control
        self._instance = instance
        self._robot = robot
        self._open: list[Any] = []
        self._choices: list[tuple[Any, Any]] = []
        x, y, yaw = match.start_pose(robot)
        self._numbers = {
            name: self._number(name, value) for name, value in (("X", x), ("Y", y), ("HeadingDeg", math.degrees(yaw)))
        }
        buttons: dict[str, Callable[[], object]] = {
            "ResetField": self._control.reset_field,
            "PlaceRobot": lambda: self._control.place_robot(self._place(), robot),
            "PlaceAtStart": lambda: self._control.place_at_start(robot),
        }
        kinds = [supply.kind.name for supply in match.game.pieces]
        if kinds:
            piece = self._chooser("Piece", kinds)
            buttons["SpawnPiece"] = lambda: self._control.spawn(piece(), [self._place()[:2]])
        if match.game.autos and match.robots[robot].devices is None:
            auto = self._chooser("Auto", list(match.game.autos))
            buttons["StartAuto"] = lambda: self._control.start_auto(auto(), robot)
        self._buttons = [(name, self._button(name), act) for name, act in buttons.items()]
        self._pose = self._listen("RobotPose")
        self._places = [(kind, self._listen(f"Spawn/{kind}")) for kind in kinds]
        self._status = self._keep(instance.get_string_topic(f"{TABLE}/Status").publish(_OPTIONS))
        self._count = self._keep(instance.get_integer_topic(f"{TABLE}/Count").get_entry(0, _OPTIONS))
        self._published = -1
        self._publish_status()
        self._since = self._count.get_atomic().time  # what a dashboard has kept from a run before is no command
        self._people = self._keep(HumanTopics(match, instance, self._since))
        self._control.sources.append(self.read)

    def read(self) -> None:
        """Give the commands that have arrived, in the order of their time stamps, and tell of those carried out."""
        self._publish_status()
        self._people.read()
        found: list[tuple[int, str, Callable[[], object]]] = []
        for name, button, act in self._buttons:
            for pressed in button.read_queue():
                if pressed.value:
                    button.set(False)
                    found.append((pressed.time, name, act))
        for value in self._pose.read_queue():
            found.append((value.time(), "RobotPose", partial(self._place_at, value)))
        for kind, places in self._places:
            for value in places.read_queue():
                found.append((value.time(), f"Spawn/{kind}", partial(self._spawn_at, kind, value)))
        for selected, active in self._choices:
            for choice in selected.read_queue():
                active.set(choice.value)
        for time, name, act in sorted(found, key=lambda one: one[0]):
            if time > self._since:
                self._try(name, act)

    def close(self) -> None:
        """Withdraw the topics and listen no more; may be called twice."""
        if self.read in self._control.sources:
            self._control.sources.remove(self.read)
        for one in self._open:
            one.close()
        self._open.clear()

    # --- inside ---------------------------------------------------------------------------------------------------

    def _try(self, name: str, act: Callable[[], object]) -> None:
        try:
            act()
        except SimcoreError as error:
            self._control.refuse(f"do what {TABLE}/{name} asks for", str(error))

    def _place_at(self, value: Any) -> None:
        pose = _pose_of(value)
        if pose is None:
            raise ConfigError(f"a pose is x, y [m] and heading [deg], three numbers; got {_array_of(value)}")
        self._control.place_robot(pose, self._robot)

    def _spawn_at(self, kind: str, value: Any) -> None:
        numbers = _array_of(value)
        if len(numbers) % 2:
            raise ConfigError(f"places are pairs x, y [m]; got {len(numbers)} numbers, {numbers}")
        self._control.spawn(kind, [numbers[k : k + 2] for k in range(0, len(numbers), 2)])

    def _publish_status(self) -> None:
        control = self._control
        if control.count != self._published:
            self._published = control.count
            self._status.set(str(control.results[-1]) if control.results else "0 ready")
            self._count.set(control.count)

    def _place(self) -> tuple[float, float, float]:
        x, y, degrees = (self._numbers[name].get() for name in ("X", "Y", "HeadingDeg"))
        return x, y, math.radians(degrees)

    def _keep(self, one: Any) -> Any:
        self._open.append(one)
        return one

    def _button(self, name: str) -> Any:
        button = self._keep(self._instance.get_boolean_topic(f"{TABLE}/{name}").get_entry(False, _OPTIONS))
        button.set(False)
        return button

    def _number(self, name: str, value: float) -> Any:
        number = self._keep(self._instance.get_double_topic(f"{TABLE}/{name}").get_entry(value, _OPTIONS))
        number.set_default(value)
        return number

    def _listen(self, name: str) -> Any:
        """Values of whatever type: a struct or an array, as the dashboard has it."""
        return self._instance.get_topic(f"{TABLE}/{name}").generic_subscribe(_OPTIONS)

    def _chooser(self, name: str, options: Sequence[str]) -> Callable[[], str]:
        """Publish what `SmartDashboard.putData` publishes of a SendableChooser; returns what asks for the choice."""
        table = f"{TABLE}/{name}"
        for key, text in ((".type", "String Chooser"), (".name", name), ("default", options[0])):
            self._keep(self._instance.get_string_topic(f"{table}/{key}").publish()).set(text)
        self._keep(self._instance.get_integer_topic(f"{table}/.instance").publish()).set(0)
        self._keep(self._instance.get_string_array_topic(f"{table}/options").publish()).set(list(options))
        active = self._keep(self._instance.get_string_topic(f"{table}/active").publish())
        active.set(options[0])
        selected = self._keep(self._instance.get_string_topic(f"{table}/selected").subscribe(options[0], _OPTIONS))
        self._choices.append((selected, active))
        return lambda: str(selected.get())


def _pose_of(value: Any) -> tuple[float, ...] | None:
    """x, y [m] and heading [rad] of a `Pose2d`, or of an array with degrees in the third place, as `Field2d` has it.

    None where it is neither.
    """
    if value.is_raw() and len(value.get_raw()) == _POSE2D.size:
        return _POSE2D.unpack(value.get_raw())
    numbers = _array_of(value)
    return (*numbers[:2], math.radians(numbers[2])) if len(numbers) == 3 else None


def _array_of(value: Any) -> list[float]:
    for is_one, get in (
        (value.is_double_array, value.get_double_array),
        (value.is_float_array, value.get_float_array),
        (value.is_integer_array, value.get_integer_array),
    ):
        if is_one():
            return [float(number) for number in get()]
    return []

"""Human players over NetworkTables: buttons under `Sim/HumanPlayer/<Red|Blue>/`, and how many pieces stand ready.

The buttons are booleans that somebody sets to true and that are set back here, as those of `ControlTopics`.
"""

from __future__ import annotations

from typing import Any

from simcore import season
from simcore.match.human_control import ALLIANCES
from simcore.match.match import Match
from simcore.quantities import shown

__all__ = ["HumanTopics"]

_TABLE = "/Sim/HumanPlayer/"


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
        self._poller.add_listener([_TABLE], season.ntcore.EventFlags.VALUE_ALL)
        names = [action.name for action in match.rules.human_actions()]
        if names:
            self._tell("string_array", "Actions", names)
        self._buttons = {f"{alliance.capitalize()}/{name}" for alliance in ALLIANCES for name in names}
        for button in sorted(self._buttons):
            self._tell("boolean", button, False)
        self._tell_all()

    def read(self) -> None:
        """Give the commands that have arrived, and tell how things stand."""
        self._tell_all()
        for event in self._poller.read_queue():
            topic, value = event.data.topic.get_name().removeprefix(_TABLE), event.data.value
            if value.time() > self._since and topic != "Actions" and "/Ready/" not in topic:
                self._hear(topic, value.value())

    def close(self) -> None:
        """Withdraw the topics and listen no more; may be called twice."""
        for one in (self._poller, *self._publishers.values()):
            one.close()

    # --- inside ---------------------------------------------------------------------------------------------------

    def _hear(self, topic: str, value: object) -> None:
        alliance, _, name = topic.partition("/")
        if not isinstance(value, bool):
            why = f"a button is a boolean that is set to true, got {shown(value)}"
            self._match.control.refuse(f"hear {_TABLE}{topic}", why)
        elif name == "Manual":
            if value != self._values.get(topic):  # otherwise it is what was told here
                self._values[topic] = value
                self._match.control.take_over(alliance.lower(), value)
        elif value:
            if topic in self._buttons:
                self._publishers[topic].set(False)
            self._match.control.human_action(alliance.lower(), name)

    def _tell_all(self) -> None:
        for action in self._match.rules.human_actions():
            for name, alliance in ALLIANCES.items():
                folder = name.capitalize()
                self._tell("boolean", f"{folder}/Manual", alliance in self._match.persons)
                self._tell("integer", f"{folder}/Ready/{action.name}", action.feeders[alliance].stock)

    def _tell(self, kind: str, topic: str, value: Any) -> None:
        if topic not in self._publishers:
            full = getattr(self._instance, f"get_{kind}_topic")(f"{_TABLE}{topic}")
            self._publishers[topic] = full.publish(season.pub_sub_options(keep_duplicates=True))
        if value != self._values.get(topic):
            self._values[topic] = value
            self._publishers[topic].set(value)

"""Rows of AdvantageScope layouts: each key exists in logs and live, and nothing is drawn twice.

The client here uses nothing but the layout; it reads topics, types and schemas as AdvantageScope does.
"""

from __future__ import annotations

import json
import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore import Match, RobotEntry, season
from simcore.robotcode.networktables.networktables_sink import NetworkTablesSink
from simcore.show.scope_layout import scope_layout
from simcore.show.view_models import load_models
from simcore.telemetry.sinks import MemorySink
from simcore.telemetry.wpilog import WpilogSink, read_log

log = pytest.importorskip("wpiutil.log", reason="WPILib's own reader reads the logs")

_POSES = {"Pose3d", "Pose3d[]"}
TAKES = {
    **{kind: _POSES for kind in ("robot", "ghost", "component", "gamePiece", "vision")},
    "trajectory": {"Pose3d[]"},
    "stepped": {"Number"},
    "stripes": {"Number", "Boolean", "String"},
    "states": {"SwerveModuleState[]"},
}
"""Types that each kind of row accepts. Source: `*Controller_Config.ts` of AdvantageScope."""
_NAMES = {"double": "Number", "int": "Number", "int64": "Number", "boolean": "Boolean", "string": "String"}
_LISTS = ("sources", "leftSources", "rightSources", "discreteSources")


@dataclass
class Seen:
    """Contents of a log or server as a client sees them: types and last raw values by name."""

    types: dict[str, str]
    values: dict[str, Any]

    def scope_type(self, key: str) -> str:
        """Return AdvantageScope's name of a key's type."""
        return _NAMES.get(self.types[key], self.types[key].removeprefix("struct:"))

    def fields(self, name: str) -> list[str]:
        """Return the doubles of a struct by its schema, including nested structs."""
        found: list[str] = []
        for part in self.values[f"NT:/.schema/struct:{name}"].decode().split(";"):
            kind, field = part.split()
            found += [field] if kind == "double" else [f"{field}/{inner}" for inner in self.fields(kind)]
        return found

    def rows(self, key: str) -> np.ndarray:
        """Return the structs of a key, decoded by their schema, shape (n, fields)."""
        names, raw = self.fields(self.scope_type(key).removesuffix("[]")), self.values[key]
        assert len(raw) % (8 * len(names)) == 0, key
        return np.array(struct.unpack(f"<{len(raw) // 8}d", raw)).reshape(-1, len(names))


def of_log(path: Path) -> Seen:
    names: dict[int, str] = {}
    seen = Seen({}, {})
    for record in log.DataLogReader(str(path)):
        if record.isStart():
            start = record.getStartData()
            names[start.entry], seen.types[start.name] = start.name, start.type
        else:
            seen.values[names[record.getEntry()]] = bytes(record.getRaw())
    return seen


def of_server(instance: Any) -> Seen:
    """Return all topics, with the prefix `NT:` that AdvantageScope uses."""
    seen = Seen({}, {})
    for topic in instance.get_topics():
        name = f"NT:{topic.get_name()}"
        seen.types[name], value = topic.getTypeString(), topic.generic_subscribe().get()
        seen.values[name] = bytes(value.getRaw()) if value.isRaw() else value.value()
    return seen


def tabs_of(layout: dict[str, Any]) -> Iterator[tuple[str, dict[str, list[dict[str, Any]]], list[str]]]:
    """Yield title, lists of sources and plain keys of each tab."""
    (window,) = layout["hubs"]
    for tab in window["state"]["tabs"]["tabs"]:
        controller = tab["controller"]
        if isinstance(controller, list):
            yield tab["title"], {}, controller
        else:
            yield tab["title"], {name: controller[name] for name in _LISTS if name in controller}, []


def require_bound(layout: dict[str, Any], seen: Seen) -> None:
    """Check that each row has a key of an accepted type, and that components follow their robot."""
    for title, lists, plain in tabs_of(layout):
        assert len(set(plain)) == len(plain) and set(plain) <= seen.types.keys(), title
        assert all(seen.scope_type(key) in ("Number", "Boolean", "String") for key in plain)
        for rows in lists.values():
            parent = ""
            for row in rows:
                key, kind = row["logKey"], row["logType"]
                assert key in seen.types, f"{title}: nobody publishes {key}"
                assert seen.scope_type(key) == kind, f"{title}: {key} is {seen.scope_type(key)}"
                assert kind in TAKES[row["type"]], (title, row["type"], kind)
                assert row["visible"]
                parent = key if row["type"] in ("robot", "ghost") else parent
                if row["type"] == "component":
                    assert parent.rpartition("/")[0] == key.rpartition("/")[0], f"{key} moves with {parent}"


def require_drawn_once(layout: dict[str, Any], seen: Seen) -> None:
    """Check that no key occurs twice in a tab, and that robots, ghosts and pieces are at distinct places."""
    for title, lists, _ in tabs_of(layout):
        keys = [row["logKey"] for rows in lists.values() for row in rows]
        assert len(set(keys)) == len(keys), title
    (field,) = (lists["sources"] for title, lists, _ in tabs_of(layout) if title == "3D Field")
    by_kind = {
        kind: [row["logKey"] for row in field if row["type"] == kind] for kind in ("robot", "ghost", "gamePiece")
    }
    for kind in ("robot", "ghost"):
        places = np.concatenate([seen.rows(key)[:, :3] for key in by_kind[kind]])
        assert len(places) == len(by_kind[kind]) and apart(places) > 0.1, kind
    pieces = np.concatenate([seen.rows(key)[:, :3] for key in by_kind["gamePiece"]])
    assert len(pieces) > 20 and apart(pieces) > 0.02, "two pieces at one place"


def apart(places: np.ndarray) -> float:
    """Return the smallest distance between two places [m]; infinite for a single place."""
    distances = np.linalg.norm(places[:, None] - places[None], axis=2)
    return float((distances + 1e3 * np.eye(len(places))).min())


def played(game: Any, robots: int, path: Path) -> tuple[Seen, Seen, Any]:
    """Play until a piece flies, or for some seconds; return log, server and the number of visible pieces at the end."""
    instance = season.ntcore.NetworkTableInstance.create()
    instance.start_local()
    memory = MemorySink()
    half = (robots + 1) // 2
    entries = [RobotEntry(alliance="blue" if number < half else "red") for number in range(robots)]
    auto = game.auto(next(iter(game.autos)))
    try:
        sinks = [WpilogSink(path), memory]
        with Match(game, robots=entries, seed=2, sinks=sinks) as match:
            match.last_tick_ms = 1.0
            for number, alliance in enumerate(match.alliances):
                match.set_controller(number, auto.controller(match, alliance))
            while match.time < (2.0 if game is REEFSCAPE else 5.0) and not len(match.record.flying):
                match.tick()
            flying = len(match.record.flying)
            live = NetworkTablesSink(instance)
            live.write(memory.snapshots[-1])
            count = match.count
        assert flying or game is REEFSCAPE, "something is in the air"
        drawn = count.on_field + count.placed + count.in_flight + count.held
        return of_log(path), of_server(instance), drawn
    finally:
        season.ntcore.NetworkTableInstance.destroy(instance)


@pytest.mark.parametrize(("file", "robots"), [("layout.json", 1), ("layout_six.json", 6)])
@pytest.mark.parametrize("game", [REBUILT, REEFSCAPE], ids=lambda game: game.name)
def test_every_layout_row_has_a_published_value_and_nothing_is_drawn_twice(game, file, robots, tmp_path):
    logged, live, count = played(game, robots, tmp_path / "run.wpilog")
    shipped = json.loads((game.models / file).read_text())
    found = read_log(tmp_path / "run.wpilog")
    own = scope_layout(found.snapshot_at(found.span[1]), load_models(game.models))
    for layout in (shipped, own):
        for seen in (logged, live):
            require_bound(layout, seen)
            require_drawn_once(layout, seen)
    for seen in (logged, live):
        keys = [key for key in seen.types if re.match(r"NT:/Sim/(GamePieces|Held)/", key)]
        assert sum(len(seen.rows(key)) for key in keys) == count, "all that lies, stands, flies or is held"
    (swerve,) = (lists["sources"] for title, lists, _ in tabs_of(shipped) if title == "Swerve")
    for row in swerve:
        assert logged.fields("SwerveModuleState") == ["speed", "angle/value"]
        assert logged.rows(row["logKey"]).shape == (4, 2) and np.abs(logged.rows(row["logKey"])).max() > 0.0

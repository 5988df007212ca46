"""Command `simcore layout`, which writes a layout for AdvantageScope or Elastic with the telemetry of a game or log.

The layout has no rows for unpublished keys, because AdvantageScope would strike these rows through.

Source: a file exported by AdvantageScope 26.0.2, and the names of types, options and colors in its source code,
https://github.com/Mechanical-Advantage/AdvantageScope (`*Controller_Config.ts`, `Colors.ts`).
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from simcore.errors import ConfigError, OutputError
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.match.registry import find_game
from simcore.show.elastic_layout import elastic_layout
from simcore.show.log_page import game_of_log
from simcore.show.view_models import ViewModels, load_models
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import read_log
from simcore.typing import alliance_in

__all__ = ["HANGING", "RED", "add_arguments", "game_snapshot", "run", "scope_layout"]

HANGING = "Hanging"
"""Name of the piece model that shows swinging bodies (`Sim/Hanging`) in a field model."""
RED = " (red)"
"""Suffix of the name of a robot model with red bumpers."""

_VERSION = "26.0.2"
_COLORS = ("#2b66a2", "#e48b32", "#3b875a", "#af2437", "#80588e", "#e5b31b", "#858584", "#d993aa", "#5f4528", "#c0b487")
"""AdvantageScope's default colors for graphs."""
_BLUE, _RED, _GOLD, _GRAY = "#2b66a2", "#af2437", "#e5b31b", "#858584"
_GHOST = "#00ff00"
_LINE = "#00ffff"  # cyan, one of AdvantageScope's colors for the field
_TAB_GRAPH, _TAB_FIELD, _TAB_TABLE, _TAB_SWERVE = 1, 3, 4, 9
_SWERVE = {"Sim/Robot/SwerveStates": "#0000ff", "Sim/Robot/SwerveSetpoints": "#ff0000"}


def scope_layout(snapshot: Snapshot, models: ViewModels = ViewModels()) -> dict[str, Any]:  # noqa: B008  # frozen
    """Return the content of a layout file for AdvantageScope.

    Args:
        snapshot: Snapshot of the run; the layout shows the keys of the snapshot.
        models: Models of the field and the robots; by default AdvantageScope's own models.
    """
    debug = {key.removeprefix("Sim/Debug/"): key for key in snapshot.doubles if key.startswith("Sim/Debug/")}
    volts = _in_order(key for key in snapshot.doubles if key.endswith("/Debug/BatteryVoltage"))
    ticks = _present(snapshot.doubles, "Sim/Performance/TickMs", "Sim/Performance/RealTimeFactor")
    turning, angles, heights, shares = (
        [key for name, key in debug.items() if re.search(rf"{unit}(Setpoint)?$", name)]
        for unit in ("VelocityRPS", "AngleDeg", "HeightM", "ExtendedPct")
    )
    flags = [key for key in snapshot.booleans if re.match(r"Sim/(Debug|Sensors)/", key)]
    battery = ("Sim/Debug/BatteryCurrent", "Sim/Debug/DrivetrainCurrent")
    currents = [key for name, key in debug.items() if name.endswith("CurrentA")]
    tabs = [
        _field_tab(snapshot, models),
        _graph(
            "Score",
            {key: _alliance_color(key) for key in _present(snapshot.integers, "Sim/Score/Blue", "Sim/Score/Red")},
            _colored(_present(snapshot.integers, "Sim/Intake/HeldCount", "Sim/Shots", "Sim/Hits"), start=5),
            discrete=_match_states(snapshot),
        ),
        _graph("Battery", _colored(volts), _colored(_present(snapshot.doubles, *battery), start=len(volts))),
        _graph(
            "Currents", _colored([*_present(snapshot.doubles, battery[1]), *currents]), _colored(volts[:1], start=9)
        ),
        _graph(
            "Mechanisms",
            _colored(turning),
            _colored(angles, start=len(turning)),  # each axis has one unit
            discrete={key: ("Boolean", color) for key, color in _colored(flags).items()},
        ),
        *([_graph("Heights", _colored(heights), _colored(shares, start=len(heights)))] if heights or shares else []),
        *([_swerve_tab()] if _SWERVE.keys() <= snapshot.state_arrays.keys() else []),
        _graph("Tick time", _colored(ticks), {"Sim/Performance/AwakePieces": _GRAY}),
        _tab(_TAB_TABLE, "Table", [_key(name) for name in _table(snapshot)]),
    ]
    expanded = ["/Sim", "/Sim/Robot", "/Sim/Match", "NT:", "NT:/Sim", "NT:/Sim/Robot", "NT:/Sim/Match"]
    state = {"sidebar": {"width": 300, "expanded": expanded}, "tabs": {"selected": 0, "tabs": tabs}}
    window = {"x": 60, "y": 60, "width": 1400, "height": 900, "state": state}
    return {"version": _VERSION, "hubs": [window], "satellites": []}


def game_snapshot(game: Game, *, robots: int = 1) -> Snapshot:
    """Play one tick of a match, and return a snapshot.

    The first half of the robots, rounded up, is in the blue alliance.

    Args:
        game: Game of the match.
        robots: Number of robots.

    Raises:
        ConfigError: If the game does not allow this number of robots.
    """
    if not 1 <= robots <= game.robots:
        raise ConfigError(f"--robots: a match of {game.name} has 1 to {game.robots} robots, got {robots}")
    entries = [RobotEntry(alliance="red" if 2 * number >= robots and number else "blue") for number in range(robots)]
    with Match(game, robots=entries) as match:
        match.last_tick_ms = 1.0
        match.tick()
        return match.snapshot()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore layout`."""
    parser.add_argument("game", nargs="?", metavar="GAME", help="which game (default: the newest that is installed)")
    parser.add_argument("--robots", type=int, default=1, metavar="N", help="number of robots in it (default: 1)")
    parser.add_argument("--log", type=Path, metavar="FILE.wpilog", help="show what this log holds instead")
    parser.add_argument("--models", metavar="FOLDER", help="your own Robot_... and Field3d_... folders")
    parser.add_argument("--elastic", action="store_true", help="for the dashboard Elastic instead")
    parser.add_argument("--output", type=Path, metavar="FILE.json", help="default: out/layout.json, or elastic-layout")


def run(options: argparse.Namespace) -> int:
    """Write the layout file, print the path of the file, and return exit status 0.

    Raises:
        SimcoreError: If the log, the game or the models cannot be used, or the file cannot be written.
    """
    log = None if options.log is None else read_log(options.log)
    game = find_game(options.game or (game_of_log(log) if log else None))
    folder = options.models or game.models
    models = ViewModels() if folder is None else load_models(folder)
    if log is None:
        snapshot = game_snapshot(game, robots=options.robots)
    else:
        snapshot = log.snapshot_at(log.span[1])
    layout = elastic_layout(snapshot) if options.elastic else scope_layout(snapshot, models)
    output: Path = options.output or Path("out", "elastic-layout.json" if options.elastic else "layout.json")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise OutputError(f"cannot write the layout {str(output)!r}: {error.strerror or error}") from error
    print(
        f"{output}: in {'Elastic, File > Open Layout' if options.elastic else 'AdvantageScope, File > Import Layout'}"
    )
    return 0


# --- tabs -------------------------------------------------------------------------------------------------------------


def _field_tab(snapshot: Snapshot, models: ViewModels) -> dict[str, Any]:
    things = []
    for key in _in_order(key for key in snapshot.poses if key.endswith("/Robot/Pose3d")):
        prefix = key.removesuffix("/Robot/Pose3d")
        is_red = snapshot.booleans.get(f"{prefix}/Robot/IsRed", False)
        things.append(_thing("robot", key, "Pose3d", model=_robot_name(models, is_red)))
        if len(snapshot.pose_arrays.get(f"{prefix}/Robot/ComponentPoses", ())):  # a child of the robot above
            things.append(_thing("component", f"{prefix}/Robot/ComponentPoses", "Pose3d[]"))
        believed = f"{prefix}/Robot/EstimatedPose"
        if believed in snapshot.poses:
            things.append(_thing("ghost", believed, "Pose3d", model=_robot_name(models, is_red), color=_GHOST))
    known = models.field.pieces if models.field is not None else {}
    for key in snapshot.pose_arrays:
        where, _, kind = key.removeprefix("Sim/").partition("/")
        if where in ("GamePieces", "Held"):  # these include pieces in flight
            things.append(_thing("gamePiece", key, "Pose3d[]", variant=kind))
        elif key == f"Sim/{HANGING}" and HANGING in known:
            things.append(_thing("gamePiece", key, "Pose3d[]", variant=HANGING))
        elif key.endswith(("/DirectionLine", "/SeenTags")):
            things.append(_thing("trajectory", key, "Pose3d[]", color=_LINE, size="normal"))
    name = models.field.name if models.field is not None else "Evergreen"
    view = {"cameraIndex": -1, "orbitFov": 50, "cameraPosition": [0, 9, 10.5], "cameraTarget": [0, 0.5, 0]}
    return _tab(_TAB_FIELD, "3D Field", {"game": f"FRC:{name}", "sources": things}, renderer=view)


def _swerve_tab() -> dict[str, Any]:
    """Return the swerve tab of the first robot, with modules in CTRE's order (AdvantageScope's default)."""
    order = "0,1,2,3"
    rows = [_thing("states", key, "SwerveModuleState[]", color=c, arrangement=order) for key, c in _SWERVE.items()]
    return _tab(_TAB_SWERVE, "Swerve", {"sources": rows, "maxSpeed": 5, "sizeX": 0.65, "sizeY": 0.65, "orientation": 1})


def _robot_name(models: ViewModels, is_red: bool) -> str:
    names = [robot.name for robot in models.robots]
    if not names:
        return "KitBot"
    own = next(name for name in names if not name.endswith(RED) or len(names) == 1)
    return own + RED if is_red and own + RED in names else own


def _graph(
    title: str,
    left: Mapping[str, str],
    right: Mapping[str, str],
    *,
    discrete: Mapping[str, tuple[str, str]] | None = None,
) -> dict[str, Any]:
    """Return a tab with a line graph that has two axes with automatic ranges.

    Args:
        title: Title of the tab.
        left: Color of each key on the left axis.
        right: Color of each key on the right axis.
        discrete: Type and color of each key shown as stripes.
    """
    plain = {"autoTarget": None, "preset": None}
    stripes = [_thing("stripes", key, kind, color=color) for key, (kind, color) in (discrete or {}).items()]
    controller = {
        "leftSources": [_thing("stepped", key, "Number", color=color, size="normal") for key, color in left.items()],
        "rightSources": [_thing("stepped", key, "Number", color=color, size="normal") for key, color in right.items()],
        "discreteSources": stripes,
        "leftLockedRange": None,
        "rightLockedRange": None,
        "leftUnitConversion": plain,
        "rightUnitConversion": plain,
        "leftFilter": 0,
        "rightFilter": 0,
    }
    return _tab(_TAB_GRAPH, title, controller, height=220)


def _match_states(snapshot: Snapshot) -> dict[str, tuple[str, str]]:
    """Return the type and color for the match period and for each boolean of the match, by telemetry key."""
    keys = [key for key in snapshot.booleans if key.startswith("Sim/Match/")]
    states = {"Sim/Match/Period": ("String", _GOLD)}
    return states | {key: ("Boolean", _alliance_color(key)) for key in keys}


def _table(snapshot: Snapshot) -> list[str]:
    values = {**snapshot.doubles, **snapshot.strings, **snapshot.booleans, **snapshot.integers}
    first = (
        "Sim/Match/",
        "Sim/Score/",
        "Sim/Placed/",
        "Sim/Shots",
        "Sim/Hits",
        "Sim/TakenIn",
        "Sim/Intake/",
        "Sim/Robot/",
    )
    rows = [key for start in first for key in values if key.startswith(start)]
    rest = ("BatteryVoltage", "BatteryVoltageLowest", "Brownouts", "AngleDeg", "ExtendedPct", "HeightM")
    rows += [key for key in values if key.startswith("Sim/Debug/") and key.endswith(rest)]
    return [*rows, *(key for key in values if key.startswith("Sim/Performance/"))]


# --- parts of a tab ---------------------------------------------------------------------------------------------------


def _tab(kind: int, title: str, controller: Any, *, height: int = 200, renderer: Any = None) -> dict[str, Any]:
    return {
        "type": kind,
        "title": title,
        "controller": controller,
        "controllerUUID": "simcore-" + title.lower().replace(" ", "-"),
        "renderer": renderer,
        "controlsHeight": height,
    }


def _thing(kind: str, name: str, log_type: str, **options: str) -> dict[str, Any]:
    """Return an entry for the list of sources of a tab: type, telemetry key, data type and options."""
    return {"type": kind, "logKey": _key(name), "logType": log_type, "visible": True, "options": options}


def _key(name: str) -> str:
    """Return AdvantageScope's name for a telemetry key, which is equal for live data and simcore's logs."""
    return f"NT:/{name}"


def _present(values: Mapping[str, Any], *names: str) -> list[str]:
    return [name for name in names if name in values]


def _in_order(keys: Iterable[str]) -> list[str]:
    """Sort keys by robot number."""
    return sorted(keys, key=lambda key: int((re.findall(r"Sim/Robots/(\d+)/", key) or [0])[0]))


def _colored(keys: Iterable[str], *, start: int = 0) -> dict[str, str]:
    return {key: _COLORS[(start + number) % len(_COLORS)] for number, key in enumerate(keys)}


def _alliance_color(key: str) -> str:
    return {"blue": _BLUE, "red": _RED}.get(alliance_in(key.rpartition("/")[2]) or "", _GRAY)

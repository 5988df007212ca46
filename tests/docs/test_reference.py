"""Tables and names on the pages agree with the code: fields, hooks, telemetry keys, files, commands, errors."""

from __future__ import annotations

import argparse
import ast
import builtins
import importlib
import importlib.util
import re
import shlex
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import REBUILT
from games.rebuilt.robot import rebuilt_robot
from games.reefscape import REEFSCAPE
from games.reefscape.rules import ReefscapeRules
from simcore import ClimberConfig, ElevatorConfig, Game, Match, RobotConfig, RobotEntry, Rules, cli
from simcore.errors import VendorError
from simcore.match.scoring import FoulEvent, ScoreEvent
from simcore.pieces.resting_places import PlaceEvent, RestingPlace
from simcore.show import play_command
from simcore.telemetry.sinks import MemorySink
from simcore.testing import game_laws
from simcore.vision.camera import CameraConfig
from simcore.world.hanging import HangingBody, HangingConfig
from simcore.world.linkage import Joint
from simcore.world.shapes import Sphere
from simcore.world.zones import BoxZone

ROOT = Path(__file__).resolve().parents[2]
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
TEXT = {page.name: page.read_text(encoding="utf-8") for page in PAGES}

# --- names ------------------------------------------------------------------------------------------------------------


def commands(pattern: str) -> list[tuple[str, list[str]]]:
    """Return the page and the words of each command line in code blocks and in the text."""
    found = []
    for name, text in TEXT.items():
        for match in re.finditer(rf"(?:^    |`)({pattern}[^`\n#|]*)", text, re.MULTILINE):
            found.append((name, shlex.split(match.group(1))))
    return found


def test_commands_on_the_pages_are_valid():
    for page, words in commands("simcore [a-z]"):
        assert words[1] in cli.COMMANDS, f"{page}: {' '.join(words)}"
    for page, words in commands("python scripts/"):
        assert (ROOT / words[1]).is_file(), f"{page}: {' '.join(words)}"
    for page, words in commands("simcore play"):
        typed = [word for word in words[2:] if word != "..."]
        parser = argparse.ArgumentParser()
        play_command.add_arguments(parser)
        play_command.add_further_arguments(parser, typed)
        try:
            parser.parse_args(typed)
        except SystemExit:
            pytest.fail(f"{page}: {' '.join(words)}")


def test_the_table_of_commands_lists_exactly_the_existing_commands():
    """The table is in CONTRIBUTING.md."""
    rows = dict(re.findall(r"^\| `simcore ([\w-]+)[^`]*` \| (.+?) \|$", TEXT["CONTRIBUTING.md"], re.MULTILINE))
    assert set(rows) == set(cli.COMMANDS)


def test_command_lines_can_be_pasted_on_windows():
    """`#` starts no comment in cmd, and `&&` joins no commands in PowerShell 5."""
    for page in ("README.md", "first_hour.md", "testing.md", "install.md", "autos.md", "which_robots.md"):
        lines = re.findall(r"^    ((?:python|simcore|git|cd|mkdir) .*)$", TEXT[page], re.MULTILINE)
        assert lines and [line for line in lines if " #" in line or "&&" in line] == [], page


def test_every_extra_on_the_pages_exists_in_the_package():
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    table = project.partition("[project.optional-dependencies]\n")[2].partition("\n[")[0]
    extras = set(re.findall(r"^(\w+) = \[", table, re.MULTILINE))
    assert len(extras) > 8
    told = {
        f"{page}: {extra}"
        for page, text in TEXT.items()
        for group in re.findall(r"(?:\.|simcore)\[([a-z0-9_,]+)\]", text)
        for extra in group.split(",")
    }
    rows = re.findall(
        r"^\| (`[^|]+) \|", TEXT["install.md"].partition("| extra in")[2].partition("\n\n")[0], re.MULTILINE
    )
    told |= {f"install.md: {extra}" for extra in re.findall(r"`(\w+)`", " ".join(rows))}
    assert {name for name in told if name.split(": ")[1] not in extras} == set()


def test_the_documented_rows_of_the_start_screen_match_the_code():
    block = TEXT["connect.md"].partition("    Robot is on the field of")[2].partition("\n\n")[0]
    rows = [row[:12].strip() for row in re.findall(r"^      (\S.*)$", block, re.MULTILINE)]
    summary = (ROOT / "simcore/robotcode/sim/startup_summary.py").read_text(encoding="utf-8")
    assert len(rows) > 7 and [row for row in rows if f'"{row}"' not in summary] == []


DOTTED = re.compile(r"`((?:simcore|games)(?:\.[A-Za-z_]\w*)+)`")
SUFFIXES = ("toml", "whl", "games", "models", "wpilog")  # `simcore.toml`, `simcore.games`: no modules
FILE = re.compile(r"`((?:simcore|games|scripts|tests|models|examples|docs)/[\w./-]+)`")
LATER = ("games/mygame", "games/discs", "tests/test_")
"""Files that the reader makes."""


def exists(dotted: str) -> bool:
    """Return whether a dotted path is a module or a name in one; True if its extra is not installed."""
    words = dotted.split(".")
    for count in range(len(words), 0, -1):
        name = ".".join(words[:count])
        try:
            found = importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name is None or not (name == error.name or name.startswith(f"{error.name}.")):
                return True
            continue
        except ImportError:
            return True
        try:
            return all(hasattr(found, word) for word in words[count : count + 1])
        except VendorError:
            return True
    return False


def test_the_modules_files_and_errors_named_on_the_pages_exist():
    dotted = {name for text in TEXT.values() for name in DOTTED.findall(text)}
    for text in TEXT.values():
        for block in re.findall(r"^```py\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            for node in ast.walk(ast.parse(block)):
                if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in ("simcore", "games"):
                    dotted |= {f"{node.module}.{alias.name}" for alias in node.names}
    assert [name for name in sorted(dotted) if name.split(".")[1] not in SUFFIXES and not exists(name)] == []
    files = {name.rstrip("./") for text in TEXT.values() for name in FILE.findall(text)}
    assert [name for name in sorted(files) if not (ROOT / name).exists() and not name.startswith(LATER)] == []
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "simcore").rglob("*.py"))
    errors = {error for text in TEXT.values() for error in re.findall(r"`(\w+Error)[`:]", text)}
    ours = set(re.findall(r"^class (\w+Error)\(", sources, re.MULTILINE))
    assert [error for error in sorted(errors) if error not in ours and not hasattr(builtins, error)] == []


def described(page: str, part: str) -> set[str]:
    """Return names in the first column of the tables under a heading of a page."""
    text = TEXT[page].partition(f"## {part}\n")[2].partition("\n## ")[0]
    return {name for row in re.findall(r"^\| (`[^|]+) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)", row)}


def test_every_field_and_hook_is_described():
    assert {field.name for field in fields(Game)} <= described("new_game.md", "What a game has")
    assert {field.name for field in fields(RobotConfig)} <= described("robot.md", "In Python")
    assert set(game_laws.__all__) == described("new_game.md", "Test it")
    hooks = {name for name, hook in vars(Rules).items() if not name.startswith("_") and callable(hook)}
    assert set(re.findall(r"^\| `(\w+)\(", TEXT["new_game.md"], re.MULTILINE)) == hooks


@pytest.mark.parametrize(
    ("row", "event"), [("`event` of `scored`", ScoreEvent), ("`event` of `placed`, `removed`", PlaceEvent)]
)
def test_the_page_names_the_fields_of_each_event(row, event):
    told = re.search(rf"^\| {re.escape(row)} \| (.+) \|$", TEXT["new_game.md"], re.MULTILINE)[1]
    names = re.findall(r"`(\w+)`", re.sub(r"\(.*?\)", "", told))
    assert set(names) == {field.name for field in fields(event)}


# --- telemetry --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def published():
    """Return the keys and types that two matches publish: with a camera, and with a climber and lights."""
    rebuilt, bare = MemorySink(), MemorySink()
    sees = replace(rebuilt_robot(), cameras=(CameraConfig(name="<name>"),))
    robots = (RobotEntry(config=sees), RobotEntry(alliance="red"))
    with Match(REBUILT, robots=robots, sinks=[rebuilt], options={"human_players"}) as match:
        match.last_tick_ms = 1.0
        match.record.failure, match.record.warnings = "assert 1 > 2", ["late"]
        match.record.robots[0].player = "collector:3"
        match.tracker.foul(FoulEvent(0.0, "G1", 1, "red", 5, "does something"))
        match.tick()
    lift = ElevatorConfig(
        gearbox=rebuilt_robot().mechanisms["feeder"].gearbox, carriage_mass=2.0, drum_radius=0.02, max_height=1.0
    )
    up = Joint(mechanism="lift", axis=(0.0, 0.0, 1.0), slides=True, ratio=0.02)
    climbs = replace(
        rebuilt_robot(),
        mechanisms={**rebuilt_robot().mechanisms, "lift": lift},
        climbers=(ClimberConfig(joints=(up,)),),
    )
    shelf = RestingPlace(name="shelf", level="<Level>", zone=BoxZone((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)))
    with Match.bare(climbs, sinks=[bare], places=[shelf]) as match:
        (robot,) = match.robots
        hanging = HangingConfig(name="bell", shape=Sphere(0.1), mass=5.0, pivot=(8.0, 4.0, 2.0), drop=0.5)
        match.hanging.append(HangingBody(match.world, hanging))
        robot.sensor_states["<sensor>"] = True  # adapters fill these in
        robot.setpoints.update(FeederVelocityRPS=1.0, LiftPositionRot=0.5)
        robot.light_colors["<name>"] = np.zeros(8, dtype=np.int64)
        robot.light_requests["<name>"] = "SolidColor 0-7 #00FF00"
        match.tick()
    found = {}
    for sink in (rebuilt, bare):
        snapshot = sink.snapshots[-1]
        kinds = {
            "Pose3d": snapshot.poses,
            "Pose3d[]": snapshot.pose_arrays,
            "SwerveModuleState[]": snapshot.state_arrays,
            "double": snapshot.doubles,
            "int": snapshot.integers,
            "boolean": snapshot.booleans,
            "string": snapshot.strings,
            "int[]": snapshot.integer_arrays,
        }
        found |= {key: kind for kind, keys in kinds.items() for key in keys}
    return found


def general(key: str) -> str:
    """Return a key with piece kind, mechanism, alliance, period and robot of REBUILT replaced by placeholders."""
    key = re.sub(r"^(Sim/(?:Score|Match)/)(?:Red|Blue)(?=/|Hub|Outpost)", r"\1<Alliance>", key)
    key = re.sub(r"(/hubScore/)\w+(Count|Points)$", r"\1<period>\2", key)
    key = re.sub(r"^(Sim/Match/\w+TowerRobot)\d$", r"\1<n>", key)
    key = re.sub(r"^(Sim/Debug/)\w+Setpoint$", r"\1<Setpoint>Setpoint", key)
    readings = "VelocityRPS|PositionRot|VoltageIn|CurrentA|AngleDeg|ExtendedPct|HeightM"
    key = re.sub(rf"^(Sim/Debug/)\w+?({readings})$", r"\1<Mechanism>\2", key)
    key = re.sub(r"^(Sim/Sensors/)\w+$", r"\1<Sensor>", key)
    key = re.sub(r"^(Sim/Place[ds]/)\w+$", r"\1<Level>", key)
    return re.sub(r"^(Sim/(?:GamePieces|PieceIds|InFlight|InFlightIds|Held|HeldIds)/)Fuel$", r"\1<Type>", key)


def test_the_page_describes_exactly_the_published_keys_and_their_types(published):
    page = TEXT["telemetry.md"].partition("## Keys of every game")[2]
    rows = re.findall(r"^\| `([^`]+)` \| ([\w\[\]]+) \|", page, re.MULTILINE)
    described = dict(rows)
    assert len(described) == len(rows)
    own = {channel.key: channel.kind for channel in ReefscapeRules.channels}
    assert described.pop("Sim/Score/<name>") == "int" and described.items() >= own.items()
    described = {key: kind for key, kind in described.items() if key not in own}
    assert described == {general(key): kind for key, kind in published.items() if not key.startswith("Sim/Robots/")}


def test_the_key_tables_are_generated_from_the_channels():
    """If this fails: python scripts/write_telemetry_keys.py."""
    spec = importlib.util.spec_from_file_location("page", ROOT / "scripts" / "write_telemetry_keys.py")
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    assert TEXT["telemetry.md"] == page.text()


def test_telemetry_keys_on_every_page_are_published(published):
    of_2025 = MemorySink()
    with Match(REEFSCAPE, sinks=[of_2025]) as match:
        match.tick()
    known = {channel.key for channel in ReefscapeRules.channels}
    known |= {*published, *map(general, published), *of_2025.snapshots[-1].integers, *of_2025.snapshots[-1].strings}
    wrong = []
    for name, text in TEXT.items():
        for key in re.findall(r"`(?:NT:/)?(Sim/[\w/<>-]+[\w>])`", text):
            group = key.split("<")[0].rstrip("/")
            if not {key, general(key)} & known and not any(other.startswith(f"{group}/") for other in known):
                wrong.append(f"{name}: {key}")
    assert wrong == []

"""Every module, name and telemetry key that a page mentions is there."""

from __future__ import annotations

import ast
import importlib
import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from games.rebuilt import REBUILT
from games.rebuilt.robot import rebuilt_robot
from games.reefscape import REEFSCAPE
from simcore import (
    ClimberConfig,
    ElevatorConfig,
    Game,
    HopperConfig,
    IntakeConfig,
    Match,
    PlacerConfig,
    RobotConfig,
    RobotEntry,
    Rules,
    ShooterConfig,
    StorageConfig,
)
from simcore.geometry.linkage import Joint
from simcore.geometry.zones import BoxZone
from simcore.match.scoring import FoulEvent
from simcore.physics.hanging import HangingBody, HangingConfig
from simcore.physics.shapes import Sphere
from simcore.pieces.resting_places import RestingPlace
from simcore.telemetry.sinks import MemorySink
from simcore.vision.camera import CameraConfig

ROOT = Path(__file__).resolve().parents[2]
TEXT = {
    page.name: page.read_text(encoding="utf-8") for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))
}
DOTTED = re.compile(r"\b(?:simcore|games)(?:\.[A-Za-z_]\w*)+")
BLOCK = re.compile(r"^```py(?:thon)?\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"\b(?:simcore|games|scripts|tests|models|examples|docs)(?:/[\w.-]+)+/?")
SUFFIXES = ("toml", "whl", "games", "models", "wpilog")  # `simcore.toml`, `simcore.games`: no modules
LATER = ("games/mygame", "games/discs", "tests/test_", "tests/drive_test")
"""What is not there before somebody makes it."""


def resolve(dotted: str) -> bool:
    """Whether a dotted path is a module, or a name (of a name) in one."""
    words = dotted.split(".")
    for count in range(len(words), 0, -1):
        name = ".".join(words[:count])
        try:
            found = importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name is None or not (name == error.name or name.startswith(f"{error.name}.")):
                return True  # it needs an extra that is not installed
            continue
        except ImportError:
            return True  # the same, said by simcore itself
        for word in words[count:]:
            try:
                found = getattr(found, word)
            except AttributeError:
                return False
            except ImportError:
                return True  # the same, of a name that is loaded when it is asked for
        return True
    return False


@pytest.mark.parametrize("page", TEXT)
def test_modules_and_names_exist(page):
    dotted = {name for name in DOTTED.findall(TEXT[page]) if name.split(".")[1] not in SUFFIXES or name.count(".") > 1}
    for block in BLOCK.findall(TEXT[page]):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in ("simcore", "games"):
                dotted |= {f"{node.module}.{alias.name}" for alias in node.names}
    assert [name for name in sorted(dotted) if not resolve(name)] == []


@pytest.mark.parametrize("page", TEXT)
def test_files_and_folders_exist(page):
    files = {name.rstrip("./") for name in FILE.findall(TEXT[page])}
    assert [name for name in sorted(files) if not (ROOT / name).exists() and not name.startswith(LATER)] == []


@pytest.mark.parametrize(
    ("page", "config"),
    [
        ("new_game.md", Game),
        *(("robot.md", config) for config in (RobotConfig, IntakeConfig, StorageConfig, HopperConfig)),
        *(("robot.md", config) for config in (ShooterConfig, PlacerConfig)),
    ],
)
def test_every_field_is_described(page, config):
    assert [field.name for field in fields(config) if not re.search(rf"`{field.name}\b", TEXT[page])] == []


def test_every_hook_of_the_rules_is_described():
    hooks = {name for name in vars(Rules) if not name.startswith("_")}
    assert set(re.findall(r"^\| `(\w+)\(", TEXT["new_game.md"], re.MULTILINE)) == hooks


def test_the_phases_of_a_tick_are_named_in_their_order():
    with Match(REBUILT) as match:
        phases = [phase.__name__.strip("_").replace("_", " ") for phase in (*match.before, *match.after)]
    told = " ".join(TEXT["README.md"].split()).partition("Before motion: ")[2].partition(" Between")[0]
    places = [told.find(phase) for phase in phases]
    assert min(places) >= 0 and places == sorted(places), (phases, told[:200])


@pytest.fixture(scope="module")
def published():
    """Keys of a match with two robots and a camera, and of one that climbs and has lights, spelled as the page has."""
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
            "double": snapshot.doubles,
            "int": snapshot.integers,
            "boolean": snapshot.booleans,
            "string": snapshot.strings,
            "int[]": snapshot.integer_arrays,
        }
        found |= {key: kind for kind, keys in kinds.items() for key in keys}
    return found


def general(key: str) -> str:
    """The key with the kind of piece, the mechanism, the alliance, the period and the robot of REBUILT left open."""
    key = re.sub(r"^(Sim/(?:Score|Match)/)(?:Red|Blue)(?=/|Hub|Outpost)", r"\1<Alliance>", key)
    key = re.sub(r"(/hubScore/)\w+(Count|Points)$", r"\1<period>\2", key)
    key = re.sub(r"^(Sim/Match/\w+TowerRobot)\d$", r"\1<n>", key)
    readings = "(?:VelocityRPS|PositionRot)(?:Setpoint)?|VoltageIn|CurrentA|AngleDeg|ExtendedPct|HeightM"
    key = re.sub(rf"^(Sim/Debug/)\w+?({readings})$", r"\1<Mechanism>\2", key)
    key = re.sub(r"^(Sim/Sensors/)\w+$", r"\1<Sensor>", key)
    key = re.sub(r"^(Sim/Place[ds]/)\w+$", r"\1<Level>", key)
    return re.sub(r"^(Sim/(?:GamePieces|PieceIds|InFlight|InFlightIds|Held|HeldIds)/)Fuel$", r"\1<Type>", key)


def test_every_published_key_is_described_with_its_type_and_every_described_key_is_published(published):
    rows = re.findall(r"^\| `([^`]+)` \| ([\w\[\]]+) \|", TEXT["telemetry.md"], re.MULTILINE)
    described = dict(rows)
    assert len(described) == len(rows)
    assert described == {general(key): kind for key, kind in published.items() if not key.startswith("Sim/Robots/")}


def test_telemetry_keys_on_every_page_are_published(published):
    of_2025 = MemorySink()
    with Match(REEFSCAPE, sinks=[of_2025]) as match:
        match.tick()
    known = {*published, *map(general, published), *of_2025.snapshots[-1].integers, *of_2025.snapshots[-1].strings}
    wrong = []
    for name, text in TEXT.items():
        for key in re.findall(r"`(?:NT:/)?(Sim/[\w/<>-]+[\w>])`", text):
            group = key.split("<")[0].rstrip("/")
            if not {key, general(key)} & known and not any(other.startswith(f"{group}/") for other in known):
                wrong.append(f"{name}: {key}")
    assert wrong == []

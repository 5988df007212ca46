"""Every public config of simcore and its games, found by looking, refuses what is no number and names the field."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import math
import pkgutil
import re
from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

import games
import simcore
from simcore.errors import SimcoreError
from simcore.geometry.linkage import Joint
from simcore.geometry.symmetry import FieldSymmetry
from simcore.geometry.zones import BoxZone, CapsuleZone, CylinderZone
from simcore.match.clock import Phase
from simcore.match.human_actions import HumanAction
from simcore.match.registry import installed_games
from simcore.physics.field import FieldBoundary
from simcore.physics.shapes import Compound, Cylinder, Hull, Mesh, Part, Sphere
from simcore.pieces.hopper import HopperConfig
from simcore.pieces.intake import IntakeZone
from simcore.pieces.placer import PlacerConfig
from simcore.pieces.resting_places import RestingPlace
from simcore.pieces.shot_opening import ShotOpening
from simcore.robot.chassis_config import ChassisConfig
from simcore.robot.climber import ClimberConfig
from simcore.robot.cots import MODULES
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import FixedWheelConfig, MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig, PositionController, VelocityController
from simcore.robot.mechanisms import (
    ArmConfig,
    ElevatorConfig,
    FlywheelConfig,
    PistonConfig,
    RackConfig,
    RollerConfig,
    ServoConfig,
)
from simcore.vision.camera import CameraConfig, CameraMount
from simcore.vision.quest_headset import QuestConfig

PACKAGES = ("geometry", "match", "physics", "pieces", "robot", "vision")
MADE_BY_SIMCORE = frozenset(
    "AutoRun BodyDefinition BuiltDevice BuiltRobot BumperPart CommandResult CompiledModel DriveShaft FollowerGroup "
    "Footprint FoulEvent GroundClearance GuessedMechanism MassProperties PieceRelease PlaceEvent "
    "LimitedMotor MeshPart ModelLayout NormalLaw ObjGroup PieceCount RayHits RobotMass Score ScoreEvent Shot "
    "ImuReading Mounting PieceVariation ShotErrors ShotOutcomes ShotRows "
    "Placement RecordColumns Spread TagLayout TakenIn TickPlan TickTimes TippingLimit".split()
)
"""Records of what simcore works out: nobody writes them down."""

BOX = GearboxConfig(motor=motor("Kraken X60"), gearing=10.0)
ARM = ArmConfig(gearbox=BOX, inertia=0.2, mass=2.0, center_of_mass=0.3, min_angle=-1.0, max_angle=1.0, start_angle=0.0)
JOINT = Joint(mechanism="arm", axis=(0.0, 0.0, 1.0), origin=(0.1, 0.0, 0.2))
ZONE = IntakeZone(x_min=-0.5, x_max=-0.3, y_min=-0.2, y_max=0.2, z_max=0.2)
SQUARE = ((0.0, 0.0, 2.0), (1.0, 0.0, 2.0), (1.0, 1.0, 2.0), (0.0, 1.0, 2.0))
EXAMPLES = (
    ShotOpening(corners=SQUARE, approach=0.0),
    BOX,
    ARM,
    JOINT,
    ZONE,
    ElevatorConfig(gearbox=BOX, carriage_mass=5.0, drum_radius=0.02, max_height=1.0, start_height=0.5),
    FlywheelConfig(gearbox=BOX, inertia=0.01),
    RackConfig(gearbox=BOX, mass=3.0, pinion_radius=0.02, travel=0.3),
    RollerConfig(gearbox=BOX, inertia=0.001, radius=0.03),
    PistonConfig(stroke=0.2, stroke_time=0.4),
    ServoConfig(min_angle=0.0, max_angle=2.0, speed=5.0, start_angle=1.0),
    VelocityController(kv=0.1),
    PositionController(kp=10.0),
    ClimberConfig(joints=(JOINT,)),
    PlacerConfig(joints=(JOINT,), roller="arm", zone=ZONE, from_storage=True, handover=(0.1, 0.0, 0.5)),
    HumanAction(name="Roll", summary="roll a ball", feeders={}, act=print, period=0.5, lasts=1.0),
    HopperConfig(outlet_width=0.4, outlet_height=0.2, outlet_place=(0.0, 0.3), belt="belt", funnel=0.5, slope=0.1),
    FieldSymmetry("rotate", (16.0, 8.0)),
    BoxZone((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)),
    CylinderZone((1.0, 1.0), 0.5, 0.0, 1.0),
    CapsuleZone((1.0, 1.0, 1.0), (1.0, 1.0, 2.0), 0.1),
    RestingPlace(name="shelf", zone=BoxZone((0.0, 0.0, 0.0), (1.0, 1.0, 1.0)), axis=(0.0, 0.0, 1.0)),
    FieldBoundary(length=16.0, width=8.0, side_height=0.5, end_height=2.0),
    FieldBoundary(length=16.0, width=8.0, side_height=0.5, end_height=2.0).elements(),
    Cylinder(0.2, 0.4),
    Hull(np.vstack([np.zeros(3), np.eye(3)])),
    Phase("auto", 15.0, "auto"),
    MODULES["SDS MK4"],
    CameraConfig(frame_rate=30.0),
    QuestConfig(mount=CameraMount()),
    TankConfig(),
    FixedWheelConfig(),
    MecanumConfig(),
    ChassisConfig(yaw_inertia=5.0, bay=(0.4, 0.3)),
    Mesh(np.eye(3), np.array([[0, 1, 2]])),
    Compound((Part(Sphere(0.1), (0.0, 0.0, 0.1)),)),
)


def config_types() -> list[type]:
    """All public frozen dataclasses of the packages that users write configs of, but for records of results."""
    modules = [
        module.name
        for package in PACKAGES
        for module in pkgutil.walk_packages(
            importlib.import_module(f"{simcore.__name__}.{package}").__path__, f"simcore.{package}."
        )
    ]
    modules += [m.name for m in pkgutil.walk_packages(games.__path__, "games.") if not m.name.endswith("__main__")]
    found = []
    for name in modules:
        for kind in vars(importlib.import_module(name)).values():
            is_config = inspect.isclass(kind) and dataclasses.is_dataclass(kind) and kind.__module__ == name
            if is_config and kind.__dataclass_params__.frozen and not kind.__name__.startswith("_"):
                found.append(kind)
    return [kind for kind in found if kind.__name__ not in MADE_BY_SIMCORE and any(number_places(kind))]


@cache
def examples() -> dict[type, Any]:
    """A working instance of each config: of the table above, of an installed game, or with its defaults."""
    known: dict[type, Any] = {}
    for game in installed_games().values():
        _collect((*EXAMPLES, game, game.robot(), game.staging, *_staged(game)), known)
    for kind in config_types():
        if kind not in known:
            known[kind] = kind()  # it has no field without a default, or it belongs into the table above
    return known


def _staged(game: Any) -> tuple[Any, ...]:
    from simcore.match.game import RobotEntry

    entry = RobotEntry(start=(2.0, 2.0, 0.0), preload=0)
    return entry, *game.staging(np.random.default_rng(0), (entry,))


def _collect(value: Any, known: dict[type, Any]) -> None:
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, tuple | list):
        for part in value:
            _collect(part, known)
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        known.setdefault(type(value), value)
        for field in dataclasses.fields(value):
            _collect(getattr(value, field.name), known)


@cache
def number_places(kind: type) -> tuple[str, ...]:
    """Names of the fields of a config that hold numbers."""
    numbers = re.compile(r"\b(float|int|Vector|Quaternion|Pose|FloatArray|IntArray)\b")
    return tuple(f.name for f in dataclasses.fields(kind) if f.init and numbers.search(_text_of(f.type)))


def _text_of(annotation: Any) -> str:
    text = annotation if isinstance(annotation, str) else getattr(annotation, "__name__", str(annotation))
    return "" if text.startswith("Callable") else text


def test_every_config_has_an_example_and_refuses_no_number_where_a_number_is_due():
    """NaN in each number of each config, whether new or old: none is forgotten."""
    forgotten = []
    for kind in config_types():
        good = examples()[kind]
        for name in number_places(kind):
            before = getattr(good, name)
            bad = math.nan
            if isinstance(before, np.ndarray):
                bad = np.full(before.shape, math.nan) if before.size else np.full((1, 3), math.nan)
            elif isinstance(before, tuple) and before and all(isinstance(n, float | int) for n in before):
                bad = (*before[:-1], math.nan)
            try:
                dataclasses.replace(good, **{name: bad})
            except SimcoreError as error:
                if name not in str(error):
                    forgotten.append(f"{kind.__name__}.{name} is not named in: {error}")
            except Exception as error:
                forgotten.append(f"{kind.__name__}.{name}: {type(error).__name__} {error}")
            else:
                forgotten.append(f"{kind.__name__}.{name} may be {bad}")
    assert forgotten == []


NONSENSE = ({}, set(), [], "x", b"", 1j, object(), len, [None], 10**400, np.zeros(0), np.zeros((2, 2)), np.array(1.0))


def test_no_config_meets_nonsense_with_a_foreign_error():
    """Each field of each config, whatever it is declared as."""
    foreign = []
    for kind in config_types():
        for field in dataclasses.fields(kind):
            for bad in NONSENSE if field.init else ():
                try:
                    dataclasses.replace(examples()[kind], **{field.name: bad})
                except SimcoreError:
                    continue
                except Exception as error:
                    foreign.append(f"{kind.__name__}.{field.name} = {bad!r:.40}: {type(error).__name__} {error}")
    assert foreign == []

"""Every config checks the types of its fields at construction."""

import dataclasses
import importlib
import inspect
import math
import pkgutil
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pytest

import games
import simcore
from games.rebuilt import REBUILT
from games.rebuilt.scoring import EventSettings
from games.rebuilt.staging import Staging
from games.reefscape import REEFSCAPE
from simcore.errors import ConfigError
from simcore.match.game import RobotEntry, StagedPieces
from simcore.match.human_actions import HumanAction
from simcore.match.players.driven_robot import DriverInput
from simcore.match.players.player import Defense
from simcore.match.scatter import Scatter
from simcore.robot.cots import _ROWS
from simcore.robot.dc_motor import motor
from simcore.robot.fixed_wheel_config import FixedWheelConfig, MecanumConfig, TankConfig
from simcore.robot.gearbox import GearboxConfig, PositionController, VelocityController
from simcore.robot.hopper import HopperConfig
from simcore.robot.mechanisms import PistonConfig, RollerConfig, ServoConfig
from simcore.robot.placer import PlacerConfig
from simcore.robot.wheel_config import DrivetrainConfig, WheelConfig
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import Distribution, Factor, RunSetup
from simcore.sweep.results import Results
from simcore.vision.camera import CameraConfig, PiecePipeline, TagPipeline
from simcore.vision.quest_headset import QuestConfig
from simcore.world.contact_law import FoamStiffness
from simcore.world.field import FieldBoundary, FieldGeometry
from simcore.world.shapes import Compound, Cylinder, Hull, Mesh, Part, Sphere
from simcore.world.zones import BoxZone, CapsuleZone, CylinderZone

_PACKAGES = ("match", "pieces", "robot", "sweep", "vision", "world")


def _configs() -> list[type]:
    """Return every frozen dataclass that users construct and that checks its fields."""
    found = set()
    modules = [info.name for info in pkgutil.walk_packages(games.__path__, "games.") if "__main__" not in info.name]
    for package in _PACKAGES:
        found_here = pkgutil.walk_packages([f"{simcore.__path__[0]}/{package}"], f"simcore.{package}.")
        modules += [info.name for info in found_here]
    for module in modules:
        for one in vars(importlib.import_module(module)).values():
            if inspect.isclass(one) and one.__module__ == module and hasattr(one, "__dataclass_params__"):
                if one.__dataclass_params__.frozen and hasattr(one, "__post_init__") and one is not Results:
                    found.add(one)
    return sorted(found, key=lambda one: (one.__module__, one.__qualname__))


SQUARE = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))
POINTS = np.array([*SQUARE, (0.0, 0.0, 1.0)])
FOUND = (
    REBUILT,
    REBUILT.clock.phases,
    REBUILT.field.load().elements,
    REEFSCAPE,
    REBUILT.robot(),
    REEFSCAPE.robot(),
    REEFSCAPE.robot().body,
    BoxZone(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0)),
    _ROWS[0],
    CapsuleZone(start=(0.0, 0.0, 0.0), end=(1.0, 0.0, 0.0), radius=0.1),
    CylinderZone(center=(0.0, 0.0), radius=1.0, bottom=0.0, top=1.0),
    RobotEntry(),
    Staging(),
    EventSettings(),
    StagedPieces(kind="fuel", attitudes=np.zeros((0, 4)), lodged=5.0),
    HumanAction(name="Throw", summary="Throw", feeders={}, act=print, period=1.0),
    Scatter(),
    FieldBoundary(length=16.0, width=8.0, side_height=0.5, end_height=2.0, thickness=0.1),
    FieldGeometry(elements=()),
    FoamStiffness(linear=1000.0, cubic=0.0),
    Cylinder(radius=0.1, height=0.2),
    Hull(points=POINTS),
    Mesh(vertices=POINTS, faces=np.array([[0, 1, 2]])),
    Compound(parts=(Part(shape=Sphere(radius=0.1)),)),
    HopperConfig(outlet="front", outlet_width=0.3),
    Defense(goal=(1.0, 1.0), retreat=(2.0, 2.0), is_left_alone=lambda player, place: False),
    DriverInput(),
    FixedWheelConfig(motor=motor("NEO"), gearing=10.0),
    MecanumConfig(motor=motor("NEO"), gearing=10.0),
    TankConfig(motor=motor("NEO"), gearing=10.0),
    PositionController(kp=1.0),
    VelocityController(kv=1.0, kp=1.0),
    PistonConfig(stroke=0.2, stroke_time=0.3),
    ServoConfig(min_angle=0.0, max_angle=1.0, speed=3.0),
    RollerConfig(gearbox=GearboxConfig(motor=motor("NEO"), gearing=3.0), inertia=0.001, radius=0.02),
    DrivetrainConfig(),
    WheelConfig(),
    Experiment(),
    Factor("mass", distribution=Distribution("uniform", 40.0, 60.0)),
    RunSetup(game=REBUILT, auto=REBUILT.auto("depot"), robot=REBUILT.robot()),
    CameraConfig(pipelines=(TagPipeline(), PiecePipeline(piece_class="fuel"))),
    QuestConfig(),
)
"""Valid configs that, with their parts, include an instance of every config class."""


def _examples(one: Any, into: dict[type, Any]) -> None:
    if dataclasses.is_dataclass(one):
        into.setdefault(type(one), one)
        for field in dataclasses.fields(one):
            _examples(getattr(one, field.name), into)
    elif isinstance(one, (tuple, Mapping)):
        for part in one.values() if isinstance(one, Mapping) else one:
            _examples(part, into)


EXAMPLES: dict[type, Any] = {}
_examples(FOUND, EXAMPLES)
CONFIGS = _configs()
FIELDS = [(config, field.name) for config in CONFIGS for field in dataclasses.fields(config) if field.init]


def test_the_examples_include_every_config_class():
    assert [config.__name__ for config in CONFIGS if config not in EXAMPLES] == []
    assert len(CONFIGS) > 80


def _taken(config: type, field: str, values: Iterable[object], named: str) -> list[str]:
    """Return a line for each value that the field does not refuse with a ConfigError that matches `named`."""
    wrong = []
    for value in values:
        try:
            dataclasses.replace(EXAMPLES[config], **{field: value})
        except ConfigError as error:
            if re.search(named, str(error)):
                continue
            wrong.append(f"{config.__name__}.{field} = {value!r}: {error}")
        except Exception as error:
            wrong.append(f"{config.__name__}.{field} = {value!r}: {error!r}")
        else:
            wrong.append(f"{config.__name__}.{field} takes {value!r}")
    return wrong


def test_a_field_refuses_a_value_of_another_type():
    zone = BoxZone(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0))
    wrong = []
    for config, field in FIELDS:
        takes_zones = field == "zone" and config.__name__ in ("ScoringZone", "RestingPlace")
        nonsense = (object(), np.zeros((2, 7)), 3 + 4j, *(() if takes_zones else (zone,)))
        wrong += _taken(config, field, nonsense, rf"\b{field}\b|^a motor")
    assert wrong == []
    assert len(FIELDS) > 400


def test_a_number_field_refuses_nan_text_booleans_and_a_negative_mass():
    wrong = []
    for config, field in FIELDS:
        before = getattr(EXAMPLES[config], field)
        if isinstance(before, tuple) and before and all(type(one) in (int, float) for one in before):
            wrong += _taken(config, field, [(*before[:-1], math.nan)], rf"\b{field}\b")
        if type(before) not in (int, float):
            continue
        nonsense = [math.nan, -math.inf, "1", True, [1.0], *([-1.0] if field == "mass" else [])]
        if config.__dataclass_fields__[field].default is not None:  # type: ignore[attr-defined]
            nonsense.append(None)
        wrong += _taken(config, field, nonsense, rf"\b{field}\b")
    assert wrong == []


def test_the_error_for_a_zone_of_another_class_names_both_classes():
    zone = BoxZone(low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0))
    with pytest.raises(ConfigError) as caught:
        PlacerConfig(joints=(), zone=zone, roller="claw")
    assert str(caught.value).startswith("PlacerConfig: zone must be an IntakeZone, got a BoxZone")


def test_the_error_names_the_field_and_the_index_or_key_of_an_invalid_value():
    with pytest.raises(ConfigError, match=r"^RobotConfig: placers\[1\] must be a PlacerConfig, got 'claw'$"):
        dataclasses.replace(REEFSCAPE.robot(), placers=(REEFSCAPE.robot().placers[0], "claw"))
    with pytest.raises(ConfigError, match=r"^RobotConfig: mechanisms\['arm'\] must be .* or a ServoConfig, got 5$"):
        dataclasses.replace(REEFSCAPE.robot(), mechanisms={"arm": 5})
    with pytest.raises(ConfigError, match=r"kinds must be a tuple of a string, got 'coral'"):
        dataclasses.replace(REEFSCAPE.robot().placers[0], kinds="coral")
    with pytest.raises(ConfigError, match="alliance must be 'blue' or 'red', got 'green'"):
        RobotEntry(alliance="green")

"""Physics simulator for FIRST Robotics Competition robots programmed in Python.

The package exports the most used names and imports the module of each name on first use (PEP 562). Importing the
package therefore imports neither the physics engine nor wpilib. (PYTEST_DONT_REWRITE prevents pytest's warning that
the package is imported before assertions are rewritten; the package contains no assertions.)

>>> from simcore import FieldSymmetry
>>> FieldSymmetry.__module__
'simcore.world.symmetry'
"""

from __future__ import annotations

import difflib
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import SimcoreError, home_of

if TYPE_CHECKING:
    from simcore.match.clock import MatchClock, Phase
    from simcore.match.game import (
        Auto,
        FieldDefinition,
        Game,
        GameOption,
        PieceSupply,
        RobotEntry,
        Rules,
        StagedPieces,
    )
    from simcore.match.match import Match
    from simcore.match.registry import find_game
    from simcore.match.runner import play_auto
    from simcore.match.scatter import Scatter
    from simcore.match.scoring import ScoringTracker, ScoringZone
    from simcore.match.scripted import ScriptedRobot, ScriptSettings
    from simcore.pieces.kinds import GamePieceConfig
    from simcore.pieces.launch import LaunchParameters
    from simcore.pieces.piece_manager import GamePieceManager
    from simcore.robot.climber import ClimberConfig
    from simcore.robot.fixed_wheel_config import TankConfig
    from simcore.robot.hopper import HopperConfig
    from simcore.robot.intake import IntakeConfig, IntakeZone
    from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
    from simcore.robot.placer import PlacerConfig
    from simcore.robot.robot import Robot
    from simcore.robot.robot_config import RobotConfig
    from simcore.robot.shooter import ShooterConfig
    from simcore.robot.storage import StorageConfig
    from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
    from simcore.robotcode.makers.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
    from simcore.robotcode.makers.phoenix6.talon_motor import TalonFXMotorSim
    from simcore.robotcode.networktables.limelight_table import CameraTables
    from simcore.robotcode.networktables.networktables_sink import NetworkTablesSink
    from simcore.robotcode.sim.robot_physics import RobotPhysics, field_control
    from simcore.robotcode.sim.robot_program import part_of
    from simcore.robotcode.sim.run_variation import run_variation
    from simcore.telemetry.wpilog import WpilogSink
    from simcore.vision.camera import CameraConfig, CameraMount, PiecePipeline, TagPipeline, limelight_type
    from simcore.vision.limelight import LimelightSim
    from simcore.world.field import FieldElement, FieldGeometry
    from simcore.world.symmetry import FieldSymmetry
    from simcore.world.world import PhysicsWorld
    from simcore.world.zones import BoxZone, CylinderZone

_HOMES = {
    "match.clock": ("MatchClock", "Phase"),
    "match.game": (
        "Auto", "FieldDefinition", "Game", "GameOption", "PieceSupply", "RobotEntry", "Rules", "StagedPieces",
    ),
    "match.match": ("Match",),
    "match.registry": ("find_game",),
    "match.runner": ("play_auto",),
    "match.scatter": ("Scatter",),
    "match.scoring": ("ScoringTracker", "ScoringZone"),
    "match.scripted": ("ScriptedRobot", "ScriptSettings"),
    "pieces.kinds": ("GamePieceConfig",),
    "pieces.launch": ("LaunchParameters",),
    "pieces.piece_manager": ("GamePieceManager",),
    "robot.climber": ("ClimberConfig",),
    "robot.fixed_wheel_config": ("TankConfig",),
    "robot.hopper": ("HopperConfig",),
    "robot.intake": ("IntakeConfig", "IntakeZone"),
    "robot.mechanisms": ("ArmConfig", "ElevatorConfig", "FlywheelConfig", "RackConfig", "RollerConfig"),
    "robot.placer": ("PlacerConfig",),
    "robot.robot": ("Robot",),
    "robot.robot_config": ("RobotConfig",),
    "robot.shooter": ("ShooterConfig",),
    "robot.storage": ("StorageConfig",),
    "robot.swerve_config": ("SwerveConfig", "SwerveModuleConfig"),
    "robotcode.makers.phoenix6.swerve": ("SwerveDrivetrainSim", "swerve_config"),
    "robotcode.makers.phoenix6.talon_motor": ("TalonFXMotorSim",),
    "robotcode.networktables.limelight_table": ("CameraTables",),
    "robotcode.networktables.networktables_sink": ("NetworkTablesSink",),
    "robotcode.sim.robot_physics": ("RobotPhysics", "field_control"),
    "robotcode.sim.robot_program": ("part_of",),
    "robotcode.sim.run_variation": ("run_variation",),
    "telemetry.wpilog": ("WpilogSink",),
    "vision.camera": ("CameraConfig", "CameraMount", "PiecePipeline", "TagPipeline", "limelight_type"),
    "vision.limelight": ("LimelightSim",),
    "world.field": ("FieldElement", "FieldGeometry"),
    "world.symmetry": ("FieldSymmetry",),
    "world.world": ("PhysicsWorld",),
    "world.zones": ("BoxZone", "CylinderZone"),
}  # fmt: skip
_HOME = {name: f"simcore.{module}" for module, names in _HOMES.items() for name in names}

__all__ = [
    "ArmConfig", "Auto", "BoxZone", "CameraConfig", "CameraMount", "CameraTables", "ClimberConfig", "CylinderZone",
    "ElevatorConfig", "FieldDefinition", "FieldElement", "FieldGeometry", "FieldSymmetry", "FlywheelConfig", "Game",
    "GameOption", "GamePieceConfig", "GamePieceManager", "HopperConfig", "IntakeConfig", "IntakeZone",
    "LaunchParameters", "LimelightSim", "Match", "MatchClock", "NetworkTablesSink", "Phase", "PhysicsWorld",
    "PiecePipeline", "PieceSupply", "PlacerConfig", "RackConfig", "Robot", "RobotConfig", "RobotEntry",
    "RobotPhysics", "RollerConfig", "Rules", "Scatter", "ScoringTracker", "ScoringZone", "ScriptSettings",
    "ScriptedRobot", "ShooterConfig", "SimcoreError", "StagedPieces", "StorageConfig", "SwerveConfig",
    "SwerveDrivetrainSim", "SwerveModuleConfig", "TagPipeline", "TalonFXMotorSim", "TankConfig", "WpilogSink",
    "__version__", "field_control", "find_game", "limelight_type", "part_of", "play_auto", "run_variation",
    "swerve_config",
]  # fmt: skip
__version__ = "1.0.0rc1"


_OTHERS = {
    "PlayedMatch": "it is Match now",
    "sim": "it is a fixture, which pytest hands to a test: def test_it(sim)",
}
"""Hints for import errors, by name: former names of simcore, and names that are not attributes of the package."""


def __getattr__(name: str) -> Any:
    """Return an exported name from the module that defines the name; import the module on first use.

    Raises:
        ImportError: If simcore exports no such name but has a hint, e.g. a similar name.
        AttributeError: If simcore has no hint.
    """
    if name not in _HOME:
        raise _missing(name)
    return getattr(import_module(_HOME[name]), name)


def _missing(name: str) -> Exception:
    """Return the error for an unknown name: an ImportError with a hint, or an AttributeError without a hint.

    An ImportError is needed because `from simcore import X` replaces the message of an AttributeError.
    """
    folder = Path(__file__).parent
    if name.startswith("_") or (folder / name).is_dir() or (folder / f"{name}.py").is_file():
        return AttributeError(f"module 'simcore' has no attribute {name!r}")
    if name in _OTHERS:
        return ImportError(f"simcore has no {name!r}: {_OTHERS[name]}")
    if home := home_of(name):
        return ImportError(f"simcore has no {name!r}: from {home} import {name}")
    near = difflib.get_close_matches(name, __all__, n=1, cutoff=0.75)
    if near:
        return ImportError(f"simcore has no {name!r}. Did you mean {near[0]!r}?")
    return AttributeError(f"module 'simcore' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the exported names in alphabetical order, for tab completion."""
    return sorted(__all__)

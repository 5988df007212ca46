"""simcore: physics for FIRST Robotics Competition robots written in Python.

The everyday names are here, each loaded when it is first asked for (PEP 562): importing this package loads neither the
physics engine nor wpilib. (PYTEST_DONT_REWRITE: it is imported before pytest comes, and asserts nothing.)

>>> from simcore import FieldSymmetry
>>> FieldSymmetry.__module__
'simcore.geometry.symmetry'
"""

from __future__ import annotations

import difflib
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import SimcoreError, home_of

if TYPE_CHECKING:
    from simcore.geometry.symmetry import FieldSymmetry
    from simcore.geometry.zones import BoxZone, CylinderZone
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
    from simcore.phoenix6.swerve import SwerveDrivetrainSim, swerve_config
    from simcore.phoenix6.talon_motor import TalonFXMotorSim
    from simcore.physics.field import FieldElement, FieldGeometry
    from simcore.physics.world import PhysicsWorld
    from simcore.pieces.hopper import HopperConfig
    from simcore.pieces.intake import IntakeConfig, IntakeZone
    from simcore.pieces.kinds import GamePieceConfig
    from simcore.pieces.launch import LaunchParameters
    from simcore.pieces.piece_manager import GamePieceManager
    from simcore.pieces.placer import PlacerConfig
    from simcore.pieces.shooter import ShooterConfig
    from simcore.pieces.storage import StorageConfig
    from simcore.robot.climber import ClimberConfig
    from simcore.robot.fixed_wheel_config import TankConfig
    from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RackConfig, RollerConfig
    from simcore.robot.robot import Robot
    from simcore.robot.robot_config import RobotConfig
    from simcore.robot.swerve_config import SwerveConfig, SwerveModuleConfig
    from simcore.robotpy.robot_physics import RobotPhysics, field_control
    from simcore.robotpy.robot_program import part_of
    from simcore.robotpy.run_variation import run_variation
    from simcore.telemetry.networktables_sink import NetworkTablesSink
    from simcore.telemetry.wpilog import WpilogSink
    from simcore.vision.camera import CameraConfig, CameraMount, PiecePipeline, TagPipeline, limelight_type
    from simcore.vision.limelight import LimelightSim

_HOMES = {
    "geometry.symmetry": ("FieldSymmetry",),
    "geometry.zones": ("BoxZone", "CylinderZone"),
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
    "physics.field": ("FieldElement", "FieldGeometry"),
    "physics.world": ("PhysicsWorld",),
    "pieces.hopper": ("HopperConfig",),
    "pieces.intake": ("IntakeConfig", "IntakeZone"),
    "pieces.kinds": ("GamePieceConfig",),
    "pieces.launch": ("LaunchParameters",),
    "pieces.piece_manager": ("GamePieceManager",),
    "pieces.placer": ("PlacerConfig",),
    "pieces.shooter": ("ShooterConfig",),
    "pieces.storage": ("StorageConfig",),
    "phoenix6.talon_motor": ("TalonFXMotorSim",),
    "phoenix6.swerve": ("SwerveDrivetrainSim", "swerve_config"),
    "robot.climber": ("ClimberConfig",),
    "robot.mechanisms": ("ArmConfig", "ElevatorConfig", "FlywheelConfig", "RackConfig", "RollerConfig"),
    "robot.robot": ("Robot",),
    "robot.robot_config": ("RobotConfig",),
    "robot.swerve_config": ("SwerveConfig", "SwerveModuleConfig"),
    "robot.fixed_wheel_config": ("TankConfig",),
    "robotpy.robot_physics": ("RobotPhysics", "field_control"),
    "robotpy.robot_program": ("part_of",),
    "robotpy.run_variation": ("run_variation",),
    "telemetry.networktables_sink": ("NetworkTablesSink",),
    "telemetry.wpilog": ("WpilogSink",),
    "vision.camera": ("CameraBias", "CameraConfig", "CameraMount", "PiecePipeline", "TagPipeline", "limelight_type"),
    "vision.limelight": ("LimelightSim",),
}  # fmt: skip
_HOME = {name: f"simcore.{module}" for module, names in _HOMES.items() for name in names}

__all__ = [
    "ArmConfig", "Auto", "BoxZone", "CameraConfig", "CameraMount", "ClimberConfig", "CylinderZone", "ElevatorConfig",
    "FieldDefinition", "FieldElement", "FieldGeometry", "FieldSymmetry", "FlywheelConfig", "Game", "GameOption",
    "GamePieceConfig", "GamePieceManager", "HopperConfig", "IntakeConfig", "IntakeZone", "LaunchParameters",
    "LimelightSim", "Match", "MatchClock", "NetworkTablesSink", "Phase", "PhysicsWorld", "PiecePipeline", "PieceSupply",
    "PlacerConfig", "RackConfig", "Robot", "RobotConfig", "RobotEntry", "RobotPhysics", "RollerConfig", "Rules",
    "Scatter", "ScoringTracker", "ScoringZone", "ScriptSettings", "ScriptedRobot", "ShooterConfig", "SimcoreError",
    "StagedPieces", "StorageConfig", "SwerveConfig", "SwerveDrivetrainSim", "SwerveModuleConfig", "TagPipeline",
    "TalonFXMotorSim", "TankConfig", "WpilogSink", "__version__", "field_control", "find_game", "limelight_type",
    "part_of", "play_auto", "run_variation", "swerve_config",
]  # fmt: skip
__version__ = "1.0.0rc1"


_OTHERS = {
    "PlayedMatch": "it is Match now",
    "sim": "it is a fixture, which pytest hands to a test: def test_it(sim)",
}
"""Names of old, and those that are no names of a module."""


def __getattr__(name: str) -> Any:
    """Load the home of an everyday name."""
    if name not in _HOME:
        raise _missing(name)
    return getattr(import_module(_HOME[name]), name)


def _missing(name: str) -> Exception:
    """Return what to raise for a name that is not here; an ImportError where its home is known.

    `from simcore import X` would hide the words of an AttributeError.
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
    """The everyday names, for completion."""
    return sorted(__all__)

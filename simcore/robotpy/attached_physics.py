"""The match around a robot program that knows nothing of it: its drivetrain's constants, and `simcore.toml`."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any, ClassVar

import ntcore

import simcore.phoenix6.swerve as swerve  # from here on drivetrains are noted; the robot object is built later
from simcore.errors import ConfigError
from simcore.match.game import Game
from simcore.match.registry import find_game, installed_games
from simcore.phoenix6.ownership import Ownership
from simcore.robot.dc_motor import motor
from simcore.robot.swerve_drive import SwerveDrive
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import FILE_NAME, practice_match
from simcore.robotpy.device_assignment import DeviceAssignment, connect_mechanism
from simcore.robotpy.robot_physics import RobotPhysics
from simcore.telemetry.networktables_sink import NetworkTablesSink

__all__ = ["AttachedPhysics", "choose_game"]

_log = logging.getLogger(__name__)


class AttachedPhysics(RobotPhysics):
    """Puts the robot on the field: drivetrain by its constants, mechanisms by the file, the rest by guess.

    Args:
        physics_controller: From pyfrc.
        robot: The robot object.

    Raises:
        ConfigError: There is not one drivetrain, its constants make no sense, or the file does not fit the program.
    """

    replaces_hooks = False
    folder: ClassVar[Path] = Path()
    """Where robot.py is."""
    game_name: ClassVar[str | None] = None
    """As the flag `--game` says; None: it was not given."""
    engine_name: ClassVar[str | None] = None
    """As the flag `--engine` says; None: it was not given."""
    ownership: ClassVar[Ownership]
    """Made before the robot is built."""

    def __init__(self, physics_controller: Any, robot: Any) -> None:
        path = self.folder / FILE_NAME
        settings = read_settings(path)
        drivetrain = swerve.only_drivetrain()
        constants = swerve.module_constants(drivetrain)
        if len(constants) < 3:
            raise ConfigError(f"a swerve drivetrain stands on 3 modules or more (most have 4), got {len(constants)}")
        settings = settings.with_bumper_around(tuple((c.location_x, c.location_y) for c in constants))
        assert settings.bumper is not None
        config = swerve.swerve_config(
            drivetrain,
            mass=settings.mass,
            bumper=settings.bumper,
            height=settings.center_of_mass_height,
            wheel_cof=settings.wheel_cof,
            drive_motor=None if settings.drive_motor is None else motor(settings.drive_motor),
            steer_motor=None if settings.steer_motor is None else motor(settings.steer_motor),
        )
        game = choose_game(self.game_name, settings.game)
        network = ntcore.NetworkTableInstance.getDefault()
        sinks = [NetworkTablesSink(network)]
        match = practice_match(game, settings, config, engine=self.engine_name, sinks=sinks, network=network)
        robot_sim = match.robots[0]
        assert isinstance(robot_sim.drive, SwerveDrive)
        devices = swerve.SwerveDrivetrainSim(drivetrain, robot_sim.drive)
        motors = [connect_mechanism(m, robot_sim, self.ownership) for m in settings.mechanisms]
        says = f"as {path.name} says" if path.exists() else f"there is no {path.name}: `simcore init` writes one"
        _log.info(
            "%s is on the field of %s: %.0f kg, bumpers %.2f x %.2f m, engine %s (%s)",
            *(type(robot).__name__, game.heading, config.mass, *settings.bumper, match.world.engine.name, says),
        )
        starts = settings.auto_starts
        super().__init__(physics_controller, robot, match=match, drivetrain=devices, motors=motors, auto_starts=starts)
        self.settings = settings
        self.assignment = DeviceAssignment(self, robot_sim, self.ownership, settings, devices.devices)

    def _end_tick(self) -> None:
        super()._end_tick()
        self.assignment.after_tick()


def choose_game(flag: str | None, in_file: str | None) -> Game:
    """The game to play: the flag's, else the file's, else that of the newest year.

    Args:
        flag: Name that `--game` gives.
        in_file: Name that `simcore.toml` gives.

    Raises:
        UnknownNameError: No game of that name is installed; the text lists those that are.
        ConfigError: No game is installed.
    """
    game = find_game(flag or in_file)  # which says so itself if it was its choice
    others = [name for name in installed_games() if name != game.name]
    if others and (flag or in_file):
        why = "--game" if flag else FILE_NAME
        _log.info("game %s (%d), as %s says; also installed: %s", game.name, game.year, why, ", ".join(others))
    return game

"""The game around a robot program that knows nothing of it: its drivetrain's constants, and `simcore.toml`."""

from __future__ import annotations

import logging
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any, ClassVar

import ntcore

import simcore.phoenix6.swerve as swerve  # from here on drivetrains are noted; the robot object is built later
from simcore.errors import ConfigError
from simcore.phoenix6.ownership import Ownership
from simcore.robot.dc_motor import motor
from simcore.robot_file.reader import FILE_NAME, read_settings
from simcore.robotpy.owners import Owners, connect_mechanism
from simcore.robotpy.physics import RobotPhysics
from simcore.telemetry.networktables_sink import NetworkTablesSink

__all__ = ["AttachedPhysics"]

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
            wheel_cof=settings.tread,
            drive_motor=None if settings.drive_motor is None else motor(settings.drive_motor),
            steer_motor=None if settings.steer_motor is None else motor(settings.steer_motor),
        )
        network = ntcore.NetworkTableInstance.getDefault()
        game, plant = _only_game()(settings, config, [NetworkTablesSink(network)], network)
        devices = swerve.SwerveDrivetrainSim(drivetrain, plant.drive)
        motors = [connect_mechanism(m, plant, self.ownership) for m in settings.mechanisms]
        says = f"as {path.name} says" if path.exists() else f"there is no {path.name}: `simcore init` writes one"
        _log.info(
            "%s is on the field: %.0f kg, bumpers %.2f x %.2f m (%s)",
            *(type(robot).__name__, config.mass, *settings.bumper, says),
        )
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=devices, motors=motors)
        self.settings = settings
        self.owners = Owners(self, plant, self.ownership, settings, devices.devices)

    def _end_tick(self) -> None:
        super()._end_tick()
        self.owners.after_tick()


def _only_game() -> Any:
    games = list(entry_points(group="simcore.games"))
    if len(games) != 1:
        raise ConfigError(f"--simcore needs one installed game (entry points simcore.games), got {games}")
    return games[0].load()

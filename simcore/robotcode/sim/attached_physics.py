"""Physics for a robot program that does not use simcore, based on the program's devices and `simcore.toml`."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from simcore import season
from simcore.match.game import Game
from simcore.match.registry import find_game, game_names
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot_file.further_robots import players_beside
from simcore.robot_file.reader import read_settings
from simcore.robot_file.robot_settings import PORT_CONTROLLERS, RobotSettings, practice_match
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.networktables.limelight_table import CameraTables
from simcore.robotcode.networktables.networktables_sink import NetworkTablesSink
from simcore.robotcode.program.drivetrain_discovery import find_drivetrain
from simcore.robotcode.program.found_drivetrain import DrivetrainNotFoundError, FoundDrivetrain, guesses
from simcore.robotcode.program.makers import MakersDrivetrain, maker_of, makers, require_distinct_devices
from simcore.robotcode.program.motor_ports import DrivetrainPorts
from simcore.robotcode.program.object_graph import ObjectGraph
from simcore.robotcode.program.ownership import Ownership
from simcore.robotcode.program.recorder import built
from simcore.robotcode.program.unserved import unknown_sim_devices, unserved_devices
from simcore.robotcode.sim.device_assignment import (
    DeviceAssignment,
    connect_mechanism,
    short_names,
    with_configuration,
)
from simcore.robotcode.sim.port_assignment import PortAssignment
from simcore.robotcode.sim.robot_cameras import RobotCameras
from simcore.robotcode.sim.robot_physics import RobotPhysics
from simcore.robotcode.sim.run_variation import run_variation
from simcore.robotcode.sim.startup_summary import StartupSummary
from simcore.world.engine_choice import require_known

SimDeviceSim = season.wpilib_simulation.SimDeviceSim
ntcore = season.ntcore

__all__ = ["AttachedPhysics", "choose", "choose_game", "physics_or_none"]

_log = logging.getLogger(__name__)

_MOST_OF_A_BENCH = 3  # largest number of motors for a bench test without a description
_LOOPS = 3  # number of robot loops in which a project's own physics reveals the devices that it writes


class AttachedPhysics(RobotPhysics):
    """Physics for a robot program without simcore code, with the robot on a game's field.

    The drivetrain comes from the robot program. The mechanisms come from the robot description file or from guesses.

    Args:
        physics_controller: Object whose attribute `field` is the Field2d of the simulation window.
        robot: Robot object of the program.

    Raises:
        ConfigError: The program has no drivetrain, the drivetrain constants are implausible, or the file does not match
            the program.
    """

    folder: ClassVar[Path] = Path()
    """Folder of robot.py."""
    file_name: ClassVar[str] = FILE_NAME
    """Name of the robot description file in `folder`."""
    game_name: ClassVar[str | None] = None
    """Value of the option `--game`; None if the option is not given."""
    engine_name: ClassVar[str | None] = None
    """Value of the option `--engine`; None if the option is not given."""
    match_name: ClassVar[str | None] = None
    """Value of the option `--match`; None if the option is not given."""
    is_on_network: ClassVar[bool | None] = None
    """Whether NetworkTables' port is free for `robotpy sim`; None outside `robotpy sim`."""
    ownership: ClassVar[Ownership]
    """Record of device owners, which `attach` creates before the program builds the robot."""

    def __init__(self, physics_controller: Any, robot: Any) -> None:
        require_distinct_devices()
        path = self.folder / self.file_name
        settings = with_configuration(read_settings(path))
        drivetrain: MakersDrivetrain
        try:
            drivetrain = find_drivetrain(robot, self.folder, settings)
        except DrivetrainNotFoundError as error:
            drivetrain = _stand(settings, error)
        self.found = drivetrain.found
        """Drivetrain that simcore has found in the program."""
        config = drivetrain.config
        settings.require_effect(config)
        settings = settings.with_bumper_around(config.wheel_positions)
        if drivetrain.found.gyro is not None:
            settings = replace(settings, gyro_errors=maker_of(drivetrain.found.gyro).gyro_errors)
        assert settings.bumper is not None
        game = choose_game(self.game_name, settings.game)
        network = ntcore.NetworkTableInstance.get_default()
        sinks = [NetworkTablesSink(network)]
        tables = CameraTables(network)
        variation = run_variation()
        match = practice_match(
            *(variation.game(game), settings, config),
            vary=variation.robot,
            engine=self.engine_name,
            whole=self.match_name,
            seed=variation.seed,
            scatter=variation.scatter,
            sinks=sinks,
            network=tables,
        )
        robot_sim = match.robots[0]
        devices = drivetrain.connect(robot_sim.drive)
        devices.gyro_upside_down = settings.drivetrain.gyro_upside_down
        devices.gyro_reversed = settings.drivetrain.gyro_reversed
        on_can = [m for m in settings.mechanisms if m.controller not in PORT_CONTROLLERS]
        motors = [connect_mechanism(m, robot_sim, self.ownership) for m in on_can]
        self.ports = PortAssignment(match, robot_sim, settings, self.ownership)
        self.ports.of_drivetrain = drivetrain.found.hardware
        self._unserved = unserved_devices(ObjectGraph(robot, self.folder))
        self._path = path
        self._loops = 0
        self._about = (
            f"{type(robot).__name__} is on the field of {game.heading}: {config.mass:.0f} kg, bumpers "
            f"{settings.bumper[0]:.2f} x {settings.bumper[1]:.2f} m, engine {match.world.engine_name} "
            + (f"(as {path.name} says)" if path.exists() else f"(there is no {path.name}: all measures are defaults)")
        )
        super().__init__(
            *(physics_controller, robot),
            match=match,
            drivetrain=devices,
            motors=[*motors, *self.ports.devices],
            # A mechanism on a bench has little inertia: the controller's 1 kHz loop would oscillate at 5 ms per part.
            parts=20 if isinstance(drivetrain, _Stand) else None,
            auto_starts=settings.auto_starts,
        )
        self.settings = settings
        self.assignment = DeviceAssignment(
            self, robot_sim, self.ownership, settings, devices.devices, self.ports, on_assigned=self._say_what_is_there
        )
        self.cameras = RobotCameras(
            *(match, robot_sim.number, settings.cameras, settings.headset),
            clock=tables.clock,
            folder=self.folder,
            file=path.name,
        )

    def update_sim(self, now: float, tm_diff: float) -> None:
        """Count the robot loop, and advance the physics if the robot does not use WPILib's loop."""
        super().update_sim(now, tm_diff)
        self._loops += 1

    def _end_tick(self) -> None:
        super()._end_tick()
        self.ports.after_tick()
        self.cameras.after_tick()
        self.assignment.after_tick(has_seen_loops=self._loops >= _LOOPS)

    def _say_what_is_there(self) -> None:
        """Log the startup summary of the robot, devices, cameras and field."""
        assignment = self.assignment
        nobody = [short_names(assignment.idle)] if assignment.idle else []
        nobody += self.ports.idle
        nobody += [*self._unserved, *unknown_sim_devices(SimDeviceSim.enumerate_devices(""))]
        summary = StartupSummary(
            robot=self._about,
            drivetrain=assignment.drivetrain,
            assumed=", ".join(guesses(self.found)),
            described=[f"{name}: {devices}" for devices, name in assignment.described],
            sensors=[f"{what}: {port}" for port, what in self.ports.sensors],
            lights=", ".join(self.ports.lights),
            guessed=assignment.guessed,
            own=short_names(assignment.foreign),
            nobody=", ".join(nobody),
            cameras=", ".join(self.cameras.running),
            unseen=", ".join(self.cameras.blind),
            pushed=""
            if self.robot_sim.config.intakes
            else " and ".join(k.name.lower() for k in self.match.pieces.types),
            has_file=self._path.exists(),
            is_on_network=self.is_on_network,
        )
        _log.info("%s", "\n".join(summary.lines()))


class _Stand:
    """`MakersDrivetrain` for a program without a drivetrain: a fixed base for mechanisms on a bench."""

    def __init__(self, settings: RobotSettings) -> None:
        self.found = FoundDrivetrain(kind="none", wheels=(), about="a bench")
        self.config = TankConfig(mass=settings.mass)

    def connect(self, drive: Any) -> DrivetrainPorts:
        return DrivetrainPorts([], None)


def _stand(settings: RobotSettings, error: DrivetrainNotFoundError) -> _Stand:
    """Return a fixed base for a bench test of mechanisms, and log a warning.

    Raises:
        DrivetrainNotFoundError: The program may have a drivetrain, or the file describes no mechanism and the program
            has no motors or more than three motors. The function raises `error`.
    """
    motors = [d for maker in makers() for d in maker.built() if d.model in maker.motors]
    may_drive = any(built(kind) for kind in ("drive", "kinematics", "odometry"))
    if may_drive or not (settings.mechanisms or 0 < len(motors) <= _MOST_OF_A_BENCH):
        raise error
    _log.warning(
        "no drivetrain found, so the robot stays where it is placed, and only its mechanisms move; describe a "
        "drivetrain in a [drivetrain] table in %s (docs/which_robots.md)",
        FILE_NAME,
    )
    return _Stand(settings)


def physics_or_none(physics_controller: Any, robot: Any) -> AttachedPhysics | None:
    """Build and return the physics. For a program without a drivetrain, log a warning and return None."""
    try:
        return AttachedPhysics(physics_controller, robot)
    except DrivetrainNotFoundError as error:
        _log.warning("%s", error)
        return None


def choose(folder: Path, *, game: str | None = None, engine: str | None = None, match: str | None = None) -> None:
    """Check the game, engine and match, and store the options for `AttachedPhysics` before the program starts.

    Args:
        folder: Folder of robot.py.
        game: Value of the option `--game`; None for the file's game or the newest game.
        engine: Value of the option `--engine`; None for the file's engine or the default engine.
        match: Value of the option `--match`; None for no scripted players from the command line.

    Raises:
        SimcoreError: simcore.toml is invalid, or the game, match or engine is unknown or not installed.
    """
    settings = read_settings(folder / FILE_NAME)
    found = find_game(game or settings.game, say=str)  # the game is reported at the start of the match
    if match is not None:
        players_beside(found, match)
    if name := engine or settings.engine:
        require_known(name)
    AttachedPhysics.game_name, AttachedPhysics.engine_name, AttachedPhysics.match_name = game, engine, match


def choose_game(flag: str | None, in_file: str | None) -> Game:
    """Return the game of the command line, else the game of the file, else the newest installed game.

    The function logs the reason for the choice if several games are installed.

    Args:
        flag: Value of the option `--game`; None without the option.
        in_file: Value of `game` in `simcore.toml`; None without the value.

    Raises:
        UnknownNameError: The named game is not installed; the message lists the installed games.
        ConfigError: No game is installed.
    """
    game = find_game(flag or in_file)  # `find_game` reports a default choice
    others = [name for name in game_names() if name != game.name]
    if others and (flag or in_file):
        why = "--game" if flag else FILE_NAME
        _log.info("game %s (%d), as %s says; also installed: %s", game.name, game.year, why, ", ".join(others))
    return game

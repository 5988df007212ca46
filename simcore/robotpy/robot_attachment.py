"""Puts any robot whose drivetrain is found on the field, with no line of code: physics under its program."""

from __future__ import annotations

import inspect
import logging
import socket
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simcore.devices.found_drivetrain import DrivetrainNotFoundError
from simcore.match.registry import find_game
from simcore.photonvision.photon_program import photon_program
from simcore.physics.engine_choice import choose_engine
from simcore.robot_file.further_robots import players_beside
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME
from simcore.robotpy.attached_physics import AttachedPhysics
from simcore.robotpy.own_loops import with_own_loop
from simcore.robotpy.physics_hook import PhysicsHook, with_physics
from simcore.robotpy.program_watch import watch_program
from simcore.robotpy.robot_physics import RobotPhysics

__all__ = ["attach_physics", "choose", "is_ours", "is_port_taken"]

_log = logging.getLogger(__name__)

NETWORKTABLES = 5810
"""Port of the NT4 server."""


def choose(folder: Path, *, game: str | None = None, engine: str | None = None, match: str | None = None) -> None:
    """Set what is played on which engine, and refuse what cannot start before anything has started.

    Args:
        folder: Where robot.py is.
        game: As the flag `--game` says.
        engine: As the flag `--engine` says.
        match: As the flag `--match` says.

    Raises:
        SimcoreError: simcore.toml makes no sense, or a game or an engine is not there.
    """
    settings = read_settings(folder / FILE_NAME)
    found = find_game(game or settings.game, say=str)  # said when it is played
    if match is not None:
        players_beside(found, match)
    choose_engine(engine or settings.engine)
    AttachedPhysics.game_name, AttachedPhysics.engine_name, AttachedPhysics.match_name = game, engine, match


def attach_physics(
    interface: Any, robot_class: Any, folder: Path, *, joins: bool = True, needs_field: bool = False
) -> tuple[Any, Any]:
    """Put simcore under a robot program, before its robot is built.

    Args:
        interface: pyfrc's, of the team's own physics.py; None: there is none.
        robot_class: Of the program.
        folder: Where robot.py is.
        joins: Whether simcore comes beside a physics.py that knows nothing of it.
        needs_field: Whether a program whose drivetrain is not found is an error; else it runs without a field.

    Returns:
        Interface and robot class to go on with.
    """
    if interface is not None and (not joins or is_ours(interface.module.PhysicsEngine)):
        return interface, with_own_loop(robot_class, interface)  # it is ours, with more knowledge of the robot
    AttachedPhysics.ownership = watch_program()
    photon_program().begin()
    AttachedPhysics.folder = folder
    if interface is not None:
        _join(interface.module, AttachedPhysics if needs_field else _physics_or_none)
        return interface, with_own_loop(robot_class, interface)
    engine = AttachedPhysics if needs_field else _physics_or_none
    ours = PhysicsHook(types.SimpleNamespace(PhysicsEngine=engine))
    return ours, with_own_loop(with_physics(robot_class, ours), ours)


def is_port_taken(port: int = NETWORKTABLES) -> bool:
    """Whether another program holds a port of this machine: dashboards would go on to show that one.

    Asked before the robot program starts its own server, which would fail with one line among many.
    """
    try:
        socket.create_connection(("127.0.0.1", port), timeout=0.2).close()
    except OSError:
        return False
    return True


def is_ours(engine: Any) -> bool:
    """Whether a PhysicsEngine runs a match of simcore."""
    return isinstance(engine, type) and issubclass(engine, (RobotPhysics, _JoinedPhysics))


class _WithoutField:
    """In place of physics, for a program whose drivetrain is not found: it runs as if simcore were not there."""

    def update_sim(self, now: float, tm_diff: float) -> None:
        """Nothing moves."""


def _physics_or_none(physics_controller: Any, robot: Any) -> AttachedPhysics | _WithoutField:
    try:
        return AttachedPhysics(physics_controller, robot)
    except DrivetrainNotFoundError as error:
        _log.warning("%s", error)
        return _WithoutField()


def _join(module: Any, build: Callable[[Any, Any], Any]) -> None:
    """Let a team's own PhysicsEngine run as before, and ours beside it."""
    theirs = module.PhysicsEngine
    takes_robot = len(inspect.signature(theirs).parameters) == 2

    class PhysicsEngine(_JoinedPhysics):
        def __init__(self, physics_controller: Any, robot: Any) -> None:
            self.theirs = theirs(physics_controller, robot) if takes_robot else theirs(physics_controller)
            self.ours = build(physics_controller, robot)

    _log.info("the project's own physics.py runs beside simcore, which owns the drivetrain")
    module.PhysicsEngine = PhysicsEngine


class _JoinedPhysics:
    """A team's own PhysicsEngine and ours, one after the other."""

    theirs: Any
    ours: AttachedPhysics | _WithoutField

    def update_sim(self, now: float, tm_diff: float) -> None:
        self.theirs.update_sim(now, tm_diff)
        self.ours.update_sim(now, tm_diff)

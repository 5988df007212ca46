"""Puts any robot with a Phoenix 6 swerve drivetrain on the field, with no line of code: physics under its program."""

from __future__ import annotations

import inspect
import logging
import socket
import types
from pathlib import Path
from typing import Any

from pyfrc.physics.core import PhysicsInterface

from simcore.match.registry import find_game
from simcore.physics.engine_choice import choose_engine
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME
from simcore.robotpy.attached_physics import AttachedPhysics
from simcore.robotpy.motor_families import watch_devices
from simcore.robotpy.own_loops import with_own_loop
from simcore.robotpy.robot_cameras import watch_cameras
from simcore.robotpy.robot_physics import RobotPhysics

__all__ = ["attach_physics", "choose", "is_ours", "is_port_taken"]

_log = logging.getLogger(__name__)

NETWORKTABLES = 5810
"""Port of the NT4 server."""


def choose(folder: Path, *, game: str | None = None, engine: str | None = None) -> None:
    """Set what is played on which engine, and refuse what cannot start before anything has started.

    Args:
        folder: Where robot.py is.
        game: As the flag `--game` says.
        engine: As the flag `--engine` says.

    Raises:
        SimcoreError: simcore.toml makes no sense, or a game or an engine is not there.
    """
    settings = read_settings(folder / FILE_NAME)
    find_game(game or settings.game, say=str)  # said when it is played
    choose_engine(engine or settings.engine)
    AttachedPhysics.game_name, AttachedPhysics.engine_name = game, engine


def attach_physics(interface: Any, robot_class: Any, folder: Path, *, joins: bool = True) -> tuple[Any, Any]:
    """Put simcore under a robot program, before its robot is built.

    Args:
        interface: pyfrc's, of the team's own physics.py; None: there is none.
        robot_class: Of the program.
        folder: Where robot.py is.
        joins: Whether simcore comes beside a physics.py that knows nothing of it.

    Returns:
        Interface and robot class to go on with.
    """
    if interface is not None and (not joins or is_ours(interface.module.PhysicsEngine)):
        return interface, with_own_loop(robot_class, interface)  # it is ours, with more knowledge of the robot
    AttachedPhysics.ownership = watch_devices()
    watch_cameras()
    AttachedPhysics.folder = folder
    if interface is not None:
        _join(interface.module)
        return interface, with_own_loop(robot_class, interface)
    ours = PhysicsInterface(types.SimpleNamespace(PhysicsEngine=AttachedPhysics))  # type: ignore[no-untyped-call]
    return ours, with_own_loop(_with_physics(robot_class, ours), ours)


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


def _join(module: Any) -> None:
    """Let a team's own PhysicsEngine run as before, and ours beside it."""
    theirs = module.PhysicsEngine
    takes_robot = len(inspect.signature(theirs).parameters) == 2

    class PhysicsEngine(_JoinedPhysics):
        def __init__(self, physics_controller: Any, robot: Any) -> None:
            self.theirs = theirs(physics_controller, robot) if takes_robot else theirs(physics_controller)
            self.ours = AttachedPhysics(physics_controller, robot)

    _log.info("the project's own physics.py runs beside simcore, which owns the drivetrain")
    module.PhysicsEngine = PhysicsEngine


class _JoinedPhysics:
    """A team's own PhysicsEngine and ours, one after the other."""

    theirs: Any
    ours: AttachedPhysics

    def update_sim(self, now: float, tm_diff: float) -> None:
        self.theirs.update_sim(now, tm_diff)
        self.ours.update_sim(now, tm_diff)


def _with_physics(robot_class: Any, interface: Any) -> Any:
    """The robot class with pyfrc's hooks after its own."""

    class PhysicsRobot(robot_class):  # type: ignore[misc]
        def _simulationInit(self) -> None:
            if hasattr(super(), "_simulationInit"):  # a plain RobotBase has no hooks
                super()._simulationInit()
            interface._simulationInit(self)

        def _simulationPeriodic(self) -> None:
            if hasattr(super(), "_simulationPeriodic"):
                super()._simulationPeriodic()
            interface._simulationPeriodic()

    for name in ("__name__", "__module__", "__qualname__"):
        setattr(PhysicsRobot, name, getattr(robot_class, name))
    return PhysicsRobot

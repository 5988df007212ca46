"""`robotpy sim --simcore`: puts any robot with a Phoenix 6 swerve drivetrain on the field, with no line of code."""

from __future__ import annotations

import argparse
import inspect
import logging
import socket
import sys
import types
from pathlib import Path
from typing import Any

from pyfrc.physics.core import PhysicsInterface

from simcore.physics.engine_choice import ENGINES
from simcore.robotpy.attached_physics import AttachedPhysics
from simcore.robotpy.motor_families import watch_devices
from simcore.robotpy.own_loops import with_own_loop
from simcore.robotpy.robot_cameras import watch_cameras
from simcore.robotpy.robot_physics import RobotPhysics
from simcore.robotpy.sim_window import prepare_window

__all__ = ["attach_physics", "loadExtension", "warn_of_taken_port"]

_log = logging.getLogger(__name__)

NETWORKTABLES = 5810
"""Port of the NT4 server."""


def loadExtension() -> None:
    """What `robotpy sim` calls when the flag is given, after robot.py is imported and before the robot is built."""
    create = PhysicsInterface._create_and_attach
    warn_of_taken_port()

    def create_and_attach(cls: Any, robot_class: Any, robot_path: Path) -> tuple[Any, Any]:
        interface, program = create(robot_class, robot_path)
        return attach_physics(interface, program, Path(robot_path))

    PhysicsInterface._create_and_attach = classmethod(create_and_attach)  # type: ignore[assignment]


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
    if interface is not None and (not joins or _is_ours(interface.module.PhysicsEngine)):
        return interface, with_own_loop(robot_class, interface)  # it is ours, with more knowledge of the robot
    AttachedPhysics.ownership = watch_devices()
    watch_cameras()
    AttachedPhysics.folder = folder
    if interface is not None:
        _join(interface.module)
        return interface, with_own_loop(robot_class, interface)
    ours = PhysicsInterface(types.SimpleNamespace(PhysicsEngine=AttachedPhysics))  # type: ignore[no-untyped-call]
    return ours, with_own_loop(_with_physics(robot_class, ours), ours)


def warn_of_taken_port(port: int = NETWORKTABLES) -> bool:
    """Say it when another program holds NetworkTables' port: dashboards would go on to show that one.

    Asked before the robot program starts its own server, which would fail with one line among many.

    Args:
        port: On this machine.

    Returns:
        Whether somebody listens there.
    """
    try:
        socket.create_connection(("127.0.0.1", port), timeout=0.2).close()
    except OSError:
        return False
    _log.warning(
        "another program (a simulation that is still open?) holds port %d of NetworkTables: dashboards will show that "
        "one, not this; close it and start again",
        port,
    )
    return True


def _is_ours(engine: Any) -> bool:
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


# --- the flags --game and --engine --------------------------------------------------------------------------------


class _Choose(argparse.Action):
    """Keeps a name for when physics is built: `robotpy sim` hands extensions no options."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        setattr(AttachedPhysics, f"{self.dest}_name", values)


def _add_flags() -> None:
    """Add `--game NAME` and `--engine NAME` beside `--simcore`.

    pyfrc makes a flag without a value of each extension, and nothing more, while it loads them. So the parser is taken
    from the caller that imports this module for that purpose.
    """
    frame: types.FrameType | None = sys._getframe()
    while frame is not None:
        parser = frame.f_locals.get("parser")
        if type(frame.f_locals.get("self")).__name__ == "PyFrcSim" and isinstance(parser, argparse.ArgumentParser):
            parser.add_argument(
                "--game",
                metavar="NAME",
                action=_Choose,
                help="with --simcore: the game to play, where several are installed",
            )
            parser.add_argument(
                "--engine",
                choices=tuple(ENGINES),
                action=_Choose,
                help="with --simcore: the physics engine (default: bullet where it is installed)",
            )
            prepare_window(frame.f_locals["self"])
            return
        frame = frame.f_back


_add_flags()

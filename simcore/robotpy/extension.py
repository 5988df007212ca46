"""`robotpy sim --simcore`: puts any robot with a Phoenix 6 swerve drivetrain on the field, with no line of code.

The game comes from the entry points of group `simcore.games`, so that simcore knows none.
"""

from __future__ import annotations

import inspect
import logging
import types
from pathlib import Path
from typing import Any

from pyfrc.physics.core import PhysicsInterface

from simcore.phoenix6.ownership import Ownership
from simcore.robotpy.attached import AttachedPhysics
from simcore.robotpy.physics import RobotPhysics
from simcore.robotpy.taken_port import warn_of_taken_port

__all__ = ["AttachedPhysics", "loadExtension"]

_log = logging.getLogger(__name__)


def loadExtension() -> None:
    """What `robotpy sim` calls when the flag is given, after robot.py is imported and before the robot is built."""
    create = PhysicsInterface._create_and_attach
    AttachedPhysics.ownership = Ownership()
    warn_of_taken_port()

    def attach(cls: Any, robot_class: Any, robot_path: Path) -> tuple[Any, Any]:
        AttachedPhysics.folder = Path(robot_path)
        interface, robot_class = create(robot_class, robot_path)
        if interface is not None:
            _join(interface.module)
            return interface, robot_class
        ours = PhysicsInterface(types.SimpleNamespace(PhysicsEngine=AttachedPhysics))  # type: ignore[no-untyped-call]
        return ours, _with_physics(robot_class, ours)

    PhysicsInterface._create_and_attach = classmethod(attach)  # type: ignore[assignment]


def _join(module: Any) -> None:
    """Let a team's own PhysicsEngine run as before, and ours beside it."""
    theirs = module.PhysicsEngine
    if issubclass(theirs, RobotPhysics):
        return  # it already is ours, with more knowledge of the robot
    takes_robot = len(_parameters(theirs)) == 2

    class PhysicsEngine:
        def __init__(self, physics_controller: Any, robot: Any) -> None:
            self.theirs = theirs(physics_controller, robot) if takes_robot else theirs(physics_controller)
            self.ours = AttachedPhysics(physics_controller, robot)

        def update_sim(self, now: float, tm_diff: float) -> None:
            self.theirs.update_sim(now, tm_diff)
            self.ours.update_sim(now, tm_diff)

    _log.info("the project's own physics.py runs beside simcore, which owns the drivetrain")
    module.PhysicsEngine = PhysicsEngine


def _parameters(engine: Any) -> list[str]:
    return list(inspect.signature(engine).parameters)


def _with_physics(robot_class: Any, interface: Any) -> Any:
    """The robot class with pyfrc's hooks after its own."""

    class PhysicsRobot(robot_class):  # type: ignore[misc]
        def _simulationInit(self) -> None:
            super()._simulationInit()
            interface._simulationInit(self)

        def _simulationPeriodic(self) -> None:
            super()._simulationPeriodic()
            interface._simulationPeriodic()

    for name in ("__name__", "__module__", "__qualname__"):
        setattr(PhysicsRobot, name, getattr(robot_class, name))
    return PhysicsRobot

"""`robotpy sim --simcore`: puts any robot with a Phoenix 6 swerve drivetrain on the field, with no line of code.

The game comes from the entry points of group `simcore.games`, so that simcore knows none.
"""

from __future__ import annotations

import inspect
import logging
import types
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import ntcore
from pyfrc.physics.core import PhysicsInterface

import simcore.phoenix6.swerve as swerve  # from here on drivetrains are noted; the robot object is built later
from simcore.errors import ConfigError
from simcore.robotpy.physics import RobotPhysics
from simcore.telemetry.networktables import NetworkTablesSink

__all__ = ["AttachedPhysics", "loadExtension"]

_log = logging.getLogger(__name__)

_BEYOND_WHEELS = 0.15  # [m]; from a wheel's center to the outside of the bumpers: 2.6 in of module, 3.25 in of bumper


class AttachedPhysics(RobotPhysics):
    """The game around a robot that says nothing of itself but its drivetrain's constants.

    Mass is 55 kg, bumpers follow the wheels; other motors than the drivetrain's are left alone.
    """

    replaces_hooks = False

    def __init__(self, physics_controller: Any, robot: Any) -> None:
        drivetrain = swerve.only_drivetrain()
        constants = swerve.module_constants(drivetrain)
        bumper = (
            2.0 * (max(abs(c.location_x) for c in constants) + _BEYOND_WHEELS),
            2.0 * (max(abs(c.location_y) for c in constants) + _BEYOND_WHEELS),
        )
        config = swerve.swerve_config(drivetrain, bumper=bumper)
        sink = NetworkTablesSink(ntcore.NetworkTableInstance.getDefault())
        game, plant = _only_game()(config, bumper, [sink])
        devices = swerve.SwerveDrivetrainSim(drivetrain, plant.drive)
        _log.info("%s is on the field: %.0f kg, bumpers %.2f x %.2f m", type(robot).__name__, config.mass, *bumper)
        super().__init__(physics_controller, robot, game=game, plant=plant, drivetrain=devices)


def loadExtension() -> None:
    """What `robotpy sim` calls when the flag is given, after robot.py is imported and before the robot is built."""
    create = PhysicsInterface._create_and_attach

    def attach(cls: Any, robot_class: Any, robot_path: Path) -> tuple[Any, Any]:
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

    _log.warning("simcore owns the drivetrain; the project's own physics.py runs beside it and must leave that alone")
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


def _only_game() -> Any:
    games = list(entry_points(group="simcore.games"))
    if len(games) != 1:
        raise ConfigError(f"--simcore needs one installed game (entry points simcore.games), got {games}")
    return games[0].load()

"""What calls physics once a robot loop: in place of pyfrc's `PhysicsInterface`, which 2027 has no more.

WPILib's order of one loop of 20 ms is: robotPeriodic, the callbacks before, simulationPeriodic, the callbacks after.
The hook is simulationPeriodic, after the robot's own; parts of physics between two loops come from `addPeriodic`.
"""

from __future__ import annotations

import importlib.util
import inspect
import logging
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

from simcore import season
from simcore.errors import ConfigError

__all__ = ["PhysicsHook", "hook_of", "load_physics", "with_physics"]

_log = logging.getLogger(__name__)

_SHORTEST = 0.010  # [s]; physics is never asked sooner than that after the last time, as pyfrc has it


class PhysicsHook:
    """Builds a `PhysicsEngine` when the program starts, and calls its `update_sim` in each loop.

    Args:
        module: Has a class `PhysicsEngine`, as a project's physics.py.
    """

    def __init__(self, module: Any) -> None:
        self.module = module
        self.engine: Any = None
        """Of the running program; None: not built yet."""
        self.field: Any = None
        """The `Field2d` of the simulation's window."""
        self.log_init_errors = False
        """Of pyfrc's; errors always pass through."""
        self._last: float | None = None

    def _simulationInit(self, robot: Any) -> None:
        self.field = season.wpilib.Field2d()
        season.show_field(self.field)
        self._last = None
        build = self.module.PhysicsEngine
        takes_robot = len(inspect.signature(build).parameters) == 2
        self.engine = build(self, robot) if takes_robot else build(self)

    def _simulationPeriodic(self) -> None:
        now = float(season.wpilib.Timer.get_monotonic_timestamp())
        elapsed = None if self._last is None else now - self._last
        if elapsed is None or elapsed > _SHORTEST:
            self._last = now
            if elapsed is not None:
                self.engine.update_sim(now, elapsed)
                season.show_field(self.field, again=True)


def with_physics(robot_class: Any, hook: Any) -> Any:
    """The robot class with physics after its own simulation hooks.

    Args:
        robot_class: Of the program.
        hook: A `PhysicsHook`.
    """
    base = season.wpilib.IterativeRobotBase
    init = season.own_name(base, "simulation_init", "_simulationInit")
    periodic = season.own_name(base, "simulation_periodic", "_simulationPeriodic")

    def begin(self: Any) -> None:
        own = getattr(super(physics_robot, self), init, None)  # a plain RobotBase has no hooks
        if own is not None:
            own()
        hook._simulationInit(self)

    def every_loop(self: Any) -> None:
        own = getattr(super(physics_robot, self), periodic, None)
        if own is not None:
            own()
        hook._simulationPeriodic()

    # pybind11 sees by the name of the calling code that an override calls what it overrides, else it calls itself
    for name, function in ((init, begin), (periodic, every_loop)):
        function.__code__ = function.__code__.replace(co_name=name)
    names = {name: getattr(robot_class, name) for name in ("__module__", "__qualname__")}
    physics_robot = type(robot_class.__name__, (robot_class,), {init: begin, periodic: every_loop, **names})
    return physics_robot


def hook_of(plugin: Any) -> Any:
    """The hook of a project's own physics.py under a plugin of pytest; None: it has none.

    pyfrc's plugin has made it and put it under the robot class; for that of wpilib.testing it is made here.
    """
    if not hasattr(plugin, "_physics"):
        folder = plugin._robot_file.parent
        plugin._physics = PhysicsHook(load_physics(folder)) if (folder / "physics.py").is_file() else None
        if plugin._physics is not None:
            plugin._robot_class = with_physics(plugin._robot_class, plugin._physics)
    return plugin._physics


def load_physics(folder: Path) -> ModuleType:
    """Import the physics.py of a project.

    Raises:
        ConfigError: It cannot be imported, or has no class PhysicsEngine.
    """
    path = folder / "physics.py"
    spec = importlib.util.spec_from_file_location("physics", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))
    try:
        spec.loader.exec_module(module)
    except ImportError as error:
        raise ConfigError(f"{path} cannot be imported: {error}") from error
    if not hasattr(module, "PhysicsEngine"):
        raise ConfigError(f"{path} has no class PhysicsEngine: it needs one (docs/connect.md), or do without the file")
    _log.info("physics.py is there: its PhysicsEngine runs in each robot loop")
    return module

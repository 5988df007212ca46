"""Attach simcore to a robot program under `robotpy sim --simcore`, in robot tests and in sweeps of a project.

The module works in three steps:

1. `watch_program` starts recording the program's devices before Python imports robot.py. Programs also build devices
   during the import: at the top of robot.py, in class bodies and in other modules.
2. `attach` adds a `PhysicsHook` to the robot class before the program builds the robot.
3. The hook builds the physics in the robot's simulationInit and advances the physics in each simulationPeriodic. A
   WPILib loop calls robotPeriodic, the HAL's SimPeriodicBefore callbacks, simulationPeriodic and the HAL's
   SimPeriodicAfter callbacks, in this order. TimedRobot, MagicRobot and PyKit's LoggedRobot call the simulation
   hooks. `attach` rejects a robot class without simulation hooks.

RobotPy loads this module as the extension `simcore` for every `robotpy` command, and silently skips an extension that
fails to import. The module therefore imports only the standard library and `simcore.errors` until simcore is needed.
"""

from __future__ import annotations

import argparse
import functools
import importlib
import importlib.util
import inspect
import logging
import os
import socket
import sys
import types
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from simcore.errors import ConfigError, leave

if TYPE_CHECKING:
    from simcore.robotcode.program.ownership import Ownership

__all__ = [
    "PhysicsHook", "attach", "begin_robot", "is_ours", "is_port_taken", "loadExtension", "load_extension",
    "load_physics", "load_watched_class", "watch_program",
]  # fmt: skip

_log = logging.getLogger(__name__)

_PROGRAM = "robotpy sim"
_COMMANDS = ("PyFrcSim", "RobotSim")
"""Names of the classes that implement `robotpy sim` in pyfrc and, since 2027, in WPILib."""
_FLAGS = {
    "--game": "the game to play, where several are installed",
    "--engine": "the physics engine, bullet or mujoco (default: bullet where it is installed)",
    "--match": "a whole match with scripted players, such as practice-2v2, or PARTNERS/OPPONENTS",
}
"""Help texts of the options that apply only with `--simcore`, by option name."""
_chosen: dict[str, str] = {}
"""Values of the `_FLAGS` options on the command line, by option name without dashes."""
_SHORTEST = 0.010  # minimum time between two calls of an engine, as in pyfrc [s]
_NETWORKTABLES = 5810  # port of the NT4 server


# --- 1: watch the program -----------------------------------------------------------------------------------------

_ownership: Ownership | None = None
_robots = 0  # number of robots built by tests in this process


def watch_program(*, simulated: bool = False) -> Ownership:
    """Start recording a program's devices, notifiers and tables, and return the record of device owners.

    A later call starts nothing and returns the same record.

    Args:
        simulated: Whether to switch Phoenix 6 to simulated time.
    """
    global _ownership
    if _ownership is None:
        if simulated and find_spec("phoenix6") is not None:
            from simcore.robotcode.sim.simulated_phoenix import install_simulated_phoenix

            install_simulated_phoenix()
        import simcore.robotcode.program.program_odometry
        import simcore.robotcode.sim.built_ports  # noqa: F401
        from simcore.robotcode.makers.photonvision.photon_program import HOOKS
        from simcore.robotcode.program.import_watch import after_import
        from simcore.robotcode.program.makers import watch_makers
        from simcore.robotcode.program.ownership import Ownership
        from simcore.robotcode.program.simulation_questions import watch_questions
        from simcore.robotcode.sim.hang_watch import watch_notifiers
        from simcore.robotcode.sim.path_planner import wait_for_plans
        from simcore.robotcode.sim.table_watch import table_watch

        _ownership = Ownership()
        watch_makers(_ownership.may_write)
        watch_questions()
        watch_notifiers()
        table_watch()
        for name, hook in {**HOOKS, "pathplannerlib.pathfinders": wait_for_plans}.items():
            after_import(name, hook)
    return _ownership


def begin_robot() -> None:
    """Prepare for the next robot of a test process: switch Phoenix 6 to simulated time and start recording devices.

    A later robot of the process starts without emulated Phoenix 6 devices. The first robot keeps the devices that the
    program built during the import.
    """
    global _robots
    _robots += 1
    watch_program(simulated=True)
    if _robots > 1 and find_spec("phoenix6") is not None:
        from simcore.robotcode.sim.simulated_phoenix import install_simulated_phoenix

        install_simulated_phoenix()


def load_watched_class(module: str, name: str, simulated: bool) -> Any:
    """Import a robot program and return the robot class.

    The function first seeds the random generators and starts recording the program's devices.

    Args:
        module: Name of the module that defines the class.
        name: Dotted name of the class in the module.
        simulated: Whether to switch Phoenix 6 to simulated time.
    """
    from simcore.robotcode.sim.repeatable_runs import seed_generators

    seed_generators()  # a program may use random numbers while it is imported
    watch_program(simulated=simulated)
    return functools.reduce(getattr, name.split("."), importlib.import_module(module))


# --- 2: the robot class -------------------------------------------------------------------------------------------


def attach(
    robot_class: Any,
    folder: Path,
    *,
    physics: types.ModuleType | None = None,
    joins: bool = True,
    needs_field: bool = False,
    guard: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> tuple[PhysicsHook, Any]:
    """Attach physics to a robot class, before the program builds the robot.

    Args:
        robot_class: Robot class of the program.
        folder: Folder of robot.py.
        physics: Project's physics.py module; None if the project has no physics.py.
        joins: Whether simcore also runs if the project has a physics.py that does not use simcore.
        needs_field: Whether a missing drivetrain is an error; False to run the program without a field.
        guard: Function that returns a context manager, which reports errors in the construction of physics.

    Returns:
        The hook, and the robot class to use instead of `robot_class`.

    Raises:
        ConfigError: The robot class has a loop without simulation hooks.
    """
    from simcore import season

    base = season.wpilib.IterativeRobotBase
    names = (
        season.own_name(base, "simulation_init", "_simulationInit"),
        season.own_name(base, "simulation_periodic", "_simulationPeriodic"),
    )
    if not hasattr(robot_class, names[1]):
        raise ConfigError(
            f"{robot_class.__name__} has a loop without simulation hooks, so nothing calls physics: derive it from "
            f"wpilib.TimedRobot, or give it methods {names[0]} and {names[1]} (they may be empty), call the first "
            "before the loop and the second in each loop, and wait in robotpy_ext's NotifierDelay"
        )
    builders: list[Callable[..., Any]] = [] if physics is None else [physics.PhysicsEngine]
    if physics is None or (joins and not is_ours(physics)):
        from simcore.robotcode.makers.photonvision.photon_program import photon_program
        from simcore.robotcode.sim.attached_physics import AttachedPhysics, physics_or_none

        AttachedPhysics.ownership = watch_program()
        AttachedPhysics.folder = folder
        photon_program().begin()
        builders.append(AttachedPhysics if needs_field else physics_or_none)
        if physics is not None:
            _log.info("the project's own physics.py runs next to simcore, which owns the drivetrain")
    hook = PhysicsHook(builders, guard)
    return hook, _with_hook(robot_class, hook, *names)


def load_physics(folder: Path) -> types.ModuleType | None:
    """Import a project's physics.py and return the module; return None if the project has no physics.py.

    Raises:
        ConfigError: physics.py cannot be imported or has no class PhysicsEngine.
    """
    path = folder / "physics.py"
    if not path.is_file():
        return None
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
        raise ConfigError(f"{path} has no class PhysicsEngine: add one (docs/connect.md), or remove the file")
    _log.info("physics.py is there: its PhysicsEngine runs in each robot loop")
    return module


def is_ours(physics: types.ModuleType) -> bool:
    """Return whether the PhysicsEngine of a physics.py is a simcore `RobotPhysics`."""
    from simcore.robotcode.sim.robot_physics import RobotPhysics

    engine = physics.PhysicsEngine
    return isinstance(engine, type) and issubclass(engine, RobotPhysics)


def _with_hook(robot_class: Any, hook: PhysicsHook, init: str, periodic: str) -> Any:
    """Return a subclass of the robot class with simulation hooks that run the program's hook and then physics."""

    def begin(self: Any) -> None:
        getattr(super(physics_robot, self), init, lambda: None)()
        hook.begin(self)

    def every_loop(self: Any) -> None:
        getattr(super(physics_robot, self), periodic)()
        hook.run()

    # pybind11 recognizes an override's call of the base method by the caller's code name; other names would recurse
    for name, function in ((init, begin), (periodic, every_loop)):
        function.__code__ = function.__code__.replace(co_name=name)
    names = {name: getattr(robot_class, name) for name in ("__module__", "__qualname__")}
    physics_robot = type(robot_class.__name__, (robot_class,), {init: begin, periodic: every_loop, **names})
    return physics_robot


# --- 3: every robot loop ------------------------------------------------------------------------------------------


class PhysicsHook:
    """Hook that builds the physics engines at program start and advances the engines in each robot loop.

    Args:
        builders: `PhysicsEngine` classes, as in a physics.py, or functions that return an engine or None.
        guard: Function that returns a context manager, which reports errors in the construction of the engines.
    """

    def __init__(self, builders: list[Callable[..., Any]], guard: Callable[[], AbstractContextManager[None]]) -> None:
        self.engine: list[Any] | None = None
        """Engines of the running program; None before `begin`."""
        self.last_loop: float | None = None
        """FPGA time of the latest robot loop [s]; None before the first loop."""
        self._builders = builders
        self._guard = guard
        self._last: float | None = None
        self._field: Any = None

    def begin(self, robot: Any) -> None:
        """Publish a `Field2d` and build the engines.

        The robot calls this method once, before the first loop.
        """
        from simcore import season

        self._field = season.wpilib.Field2d()
        season.show_field(self._field)
        self._last = self.last_loop = None
        with self._guard():
            self.engine = [engine for build in self._builders if (engine := self._built(build, robot)) is not None]
        # pyfrc waits for robotInit, which may be missing in a program without WPILib's loop
        getattr(robot, "_TestRobot__robotInitialized", lambda: None)()

    def _built(self, build: Callable[..., Any], robot: Any) -> Any:
        controller: Any = types.SimpleNamespace()
        if find_spec("pyfrc") is not None:  # a physics.py may call drive() and get_pose() of the controller
            controller = importlib.import_module("pyfrc.physics.core").PhysicsInterface(None)
        controller.field = self._field
        takes_robot = len(inspect.signature(build).parameters) == 2
        return build(controller, robot) if takes_robot else build(controller)

    def run(self) -> None:
        """Advance the engines to the present FPGA time, unless less than 10 ms have passed since the last advance.

        The robot calls this method in each loop.
        """
        from simcore import season

        now = self.last_loop = float(season.wpilib.Timer.get_monotonic_timestamp())
        elapsed = None if self._last is None else now - self._last
        if elapsed is None or elapsed > _SHORTEST:
            self._last = now
            if elapsed is not None:
                for engine in self.engine or ():
                    engine.update_sim(now, elapsed)
                season.show_field(self._field, again=True)


# --- `robotpy sim --simcore` --------------------------------------------------------------------------------------


def loadExtension() -> None:
    """Do nothing.

    RobotPy calls this function after the wrapped `run` has attached physics to the robot.
    """


load_extension = loadExtension
"""Function `loadExtension` under the name that RobotPy uses since 2027."""


def is_port_taken(port: int = _NETWORKTABLES) -> bool:
    """Return whether a program on this computer already listens on a port, by default NetworkTables' port.

    Dashboards would connect to the other program instead of the robot program. Call this function before the robot
    program starts a server, because a failed start of the server is easily missed in the log.
    """
    try:
        socket.create_connection(("127.0.0.1", port), timeout=0.2).close()
    except OSError:
        return False
    return True


class _Choose(argparse.Action):
    """Argparse action that stores an option's value in `_chosen`.

    RobotPy does not pass option values to extensions.
    """

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        _chosen[self.dest] = values


def _add_flags() -> None:
    """Add the options `--game`, `--engine` and `--match` to `robotpy sim`, and wrap the command to attach physics.

    RobotPy gives each extension only a flag without a value. This function therefore finds the argument parser in the
    stack frame of the RobotPy code that imports this module. Other imports of the module have no effect.
    """
    frame: types.FrameType | None = sys._getframe()
    while frame is not None:
        command, parser = (frame.f_locals.get(name) for name in ("self", "parser"))
        if type(command).__name__ in _COMMANDS and isinstance(parser, argparse.ArgumentParser):
            for flag, sentence in _FLAGS.items():
                parser.add_argument(flag, metavar="NAME", action=_Choose, help=f"with --simcore: {sentence}")
            _run_attached(command)
            _watch_command_line()
            return
        frame = frame.f_back


def _watch_command_line() -> None:
    """Start recording devices before the import of robot.py if the command is `sim` with simcore, or `test`."""
    has_flag = any(len(word) > 2 and "--simcore".startswith(word) for word in sys.argv)
    if "sim" in sys.argv and (has_flag or _mentions_simcore(Path())):
        with _leaving(Path()):
            watch_program(simulated=os.environ.get("SIMCORE_PHOENIX") == "simulated")
    elif "test" in sys.argv:
        watch_program(simulated="--phoenix=real" not in sys.argv and os.environ.get("SIMCORE_PHOENIX") != "real")


def _mentions_simcore(project: Path) -> bool:
    """Return whether a project's physics.py mentions simcore, and the project therefore does not need `--simcore`."""
    try:
        return "simcore" in (project / "physics.py").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False


@contextmanager
def _leaving(folder: Path) -> Iterator[None]:
    """Exit with a one-sentence message if the body of the context raises an exception.

    The process exits immediately, because vendors' threads may crash during Python's shutdown.
    """
    try:
        yield
    except Exception as error:
        sys.stderr = os.fdopen(os.dup(2), "w")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # silence threads of vendors' libraries
        leave(error, program=_PROGRAM, folder=folder)


def _run_attached(command: Any) -> None:
    """Wrap the `robotpy sim` command to attach physics before a run, and to exit with status 1 if the program fails."""
    run = command.run

    @functools.wraps(run)  # RobotPy inspects the argument names
    def run_attached(options: Any, **kwargs: Any) -> Any:
        folder = Path(importlib.import_module("robotpy.main").robot_py_path).parent
        if options.simcore or _mentions_simcore(folder):
            others = (name for name in command.simexts if name != "simcore")
            if options.simcore and options.nogui and not any(getattr(options, n.replace("-", "_")) for n in others):
                _silence_joysticks()
            logging.getLogger("robotpy").addFilter(_is_no_interrupt)
            with _leaving(folder):
                kwargs["robot_class"] = _attached(kwargs["robot_class"], folder, joins=options.simcore)
        result = run(options=options, **kwargs)
        sys.stdout.flush()
        sys.stderr.flush()
        if options.simcore and result is False:
            os._exit(1)
        return result

    command.run = run_attached


def _attached(robot_class: Any, folder: Path, *, joins: bool) -> Any:
    """Attach physics to the robot class according to the options, disable pyfrc's physics, and return the new class."""
    if joins:
        from simcore.robotcode.sim.attached_physics import AttachedPhysics, choose

        choose(folder, **_chosen)
        AttachedPhysics.is_on_network = not is_port_taken()
    if find_spec("pyfrc") is not None:
        interface = importlib.import_module("pyfrc.physics.core").PhysicsInterface
        interface._create_and_attach = classmethod(lambda cls, robot_class, folder: (None, robot_class))
    guard = functools.partial(_leaving, folder)
    return attach(robot_class, folder, physics=load_physics(folder), joins=joins, guard=guard)[1]


def _silence_joysticks() -> None:
    """Turn off WPILib's repeated warnings about missing joysticks for a run without a window."""
    from simcore import season

    season.silence_joystick_warnings()
    _log.info("without a window there are no joysticks: WPILib's warnings of missing ones are off")


def _is_no_interrupt(record: logging.LogRecord) -> bool:
    """Return whether a log record is not the record in which pyfrc reports a Ctrl-C during physics."""
    return not str(record.msg).startswith("THIS IS NOT AN ERROR")


_add_flags()

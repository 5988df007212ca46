"""The flag `--simcore` of `robotpy sim`: always there, so that a start that cannot work says what is missing.

pyfrc loads this module for every `robotpy` command and leaves out an extension that does not import. So nothing but the
standard library is imported here before the flag is seen.
"""

from __future__ import annotations

import argparse
import functools
import logging
import os
import sys
import types
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

from simcore.errors import ConfigError, SimcoreError, VendorError, leave, print_error
from simcore.install_text import install_command
from simcore.robotpy.console_noise import restore_stderr
from simcore.robotpy.sim_window import is_for_simcore, prepare_window

__all__ = ["loadExtension", "load_extension"]

_log = logging.getLogger(__name__)

_PROGRAM = "robotpy sim"
_COMMANDS = ("PyFrcSim", "RobotSim")
"""What `robotpy sim` is: of pyfrc, and since 2027 of WPILib."""
_chosen: dict[str, str] = {}
"""What the flags say."""
_FLAGS = {
    "--game": "the game to play, where several are installed",
    "--engine": "the physics engine, bullet or mujoco (default: bullet where it is installed)",
    "--match": "a whole match with scripted players, such as practice-2v2, or PARTNERS/OPPONENTS",
}
"""Beside `--simcore`, each with a value, and what it chooses."""


def loadExtension() -> None:
    """What `robotpy sim` calls when the flag is given, after robot.py is imported and before the robot is built."""
    _load()
    from simcore.robotpy.attached_physics import AttachedPhysics
    from simcore.robotpy.console_noise import filter_stderr
    from simcore.robotpy.robot_attachment import is_port_taken

    AttachedPhysics.is_on_network = not is_port_taken()
    filter_stderr()


load_extension = loadExtension
"""The same, since 2027."""


def _load() -> None:
    """Import what puts a robot on the field; devices that are built from now on are noted."""
    try:
        import simcore.robotpy.robot_attachment  # noqa: F401
        from simcore.robotpy.program_watch import watch_program

        watch_program(simulated=os.environ.get("SIMCORE_PHOENIX") == "simulated")
    except VendorError as error:
        _leave(error, Path())
    except ImportError as error:
        needs = install_command("robotpy")
        print_error(_PROGRAM, f"--simcore cannot load what it needs ({error}); {needs} brings it")
        os._exit(1)


def _attach(create: Any, robot_class: Any, folder: Path) -> tuple[Any, Any]:
    """In place of pyfrc's own: load the project's physics.py, and put simcore under the robot."""
    from simcore.robotpy.robot_attachment import attach_physics, choose

    try:
        choose(folder, **_chosen)
        with _own_words():
            interface, program = create(robot_class, folder)
        interface, program = attach_physics(interface, program, folder)
    except Exception as error:
        _leave(_cause(error), folder)
    _leave_on_errors(interface, folder)
    return interface, program


def _physics_of_project(robot_class: Any, folder: Path) -> tuple[Any, Any]:
    """The physics.py of a project under its robot class, as pyfrc has it until 2026; none: None and the class."""
    from simcore.robotpy.physics_hook import PhysicsHook, load_physics, with_physics

    if not (folder / "physics.py").is_file():
        return None, robot_class
    hook = PhysicsHook(load_physics(folder))
    return hook, with_physics(robot_class, hook)


def _guard(create: Any, robot_class: Any, folder: Path) -> tuple[Any, Any]:
    """In place of pyfrc's own where the flag is not given: a physics.py of simcore's ends with a sentence as well."""
    is_ours = is_for_simcore(folder, has_flag=False)
    try:
        with _own_words() if is_ours else nullcontext():
            interface, program = create(robot_class, folder)
    except Exception as error:
        if is_ours or isinstance(error.__context__, SimcoreError):
            _leave(_cause(error), folder)
        raise
    if is_ours:
        from simcore.robotpy.console_noise import filter_stderr

        _leave_on_errors(interface, folder)
        filter_stderr()
    return interface, program


def _leave(error: BaseException, folder: Path) -> NoReturn:
    restore_stderr()
    leave(error, program=_PROGRAM, folder=folder)


def _silence_joysticks() -> None:
    """Switch off WPILib's warning of missing joysticks, lines each second: a window or another program brings them."""
    from simcore import season

    season.silence_joystick_warnings()
    _log.info("without a window there are no joysticks: WPILib's warnings of missing ones are off")


def _cause(error: Exception) -> BaseException:
    """What is wrong with a physics.py, for which pyfrc raises an error of its own without a word."""
    if type(error).__name__ != "PhysicsInitException":
        return error
    return error.__context__ or ConfigError(
        "physics.py has no class PhysicsEngine: it needs one (docs/connect.md), or --simcore does without a physics.py"
    )


def _leave_on_errors(interface: Any, folder: Path) -> None:
    """End the program with one sentence if its physics cannot be built; pyfrc would log the error three times over."""
    build = interface._simulationInit
    interface.log_init_errors = False

    def build_or_leave(robot: Any) -> None:
        try:
            build(robot)
        except Exception as error:
            _leave(error, folder)

    interface._simulationInit = build_or_leave


def _is_no_interrupt(record: logging.LogRecord) -> bool:
    """Leaves out where in physics Ctrl-C came, with all local variables; that it came is said after it."""
    return not str(record.msg).startswith("THIS IS NOT AN ERROR")


_THEIR_WORDS = ("Cannot enable physics support", "Error loading user physics module", "User physics module does not")


@contextmanager
def _own_words() -> Iterator[None]:
    """Without pyfrc's lines of a physics.py that is not there, which is no lack here, or that failed, which we say."""

    def is_for_us(record: logging.LogRecord) -> bool:
        return not str(record.msg).startswith(_THEIR_WORDS)

    logger = logging.getLogger("pyfrc.physics")
    logger.addFilter(is_for_us)
    try:
        yield
    finally:
        logger.removeFilter(is_for_us)


# --- while pyfrc makes its flags ------------------------------------------------------------------------------------


class _Choose(argparse.Action):
    """Keeps a name for when physics is built: `robotpy sim` hands extensions no options."""

    def __call__(self, parser: Any, namespace: Any, values: Any, option_string: str | None = None) -> None:
        _chosen[self.dest] = values


def _add_flags() -> None:
    """Add `--game NAME`, `--engine NAME` and `--match NAME` beside `--simcore`.

    pyfrc makes a flag without a value of each extension, and nothing more, while it loads them. So the parser is taken
    from the caller that imports this module for that purpose.
    """
    frame: types.FrameType | None = sys._getframe()
    while frame is not None:
        command, parser = (frame.f_locals.get(name) for name in ("self", "parser"))
        if type(command).__name__ in _COMMANDS and isinstance(parser, argparse.ArgumentParser):
            for flag, sentence in _FLAGS.items():
                parser.add_argument(flag, metavar="NAME", action=_Choose, help=f"with --simcore: {sentence}")
            prepare_window(command)
            _run_guarded(command)
            _watch_program()
            return
        frame = frame.f_back


def _watch_program() -> None:
    """Note what the program builds from now on, before robot.py is imported, where a field is to come under it."""
    is_sim = "sim" in sys.argv
    if is_sim and any(_is_flag(word) for word in sys.argv):
        _load()
    elif is_for_simcore(Path(), has_flag=False) if is_sim else _tests_here():
        from simcore.robotpy.program_watch import watch_program

        mode = "real" if "--phoenix=real" in sys.argv else os.environ.get("SIMCORE_PHOENIX", "real" if is_sim else "")
        watch_program(simulated=mode != "real")


def _tests_here() -> bool:
    """Whether `robotpy test` is about to run tests in this very process, by its flag or as pyproject.toml has it."""
    if "test" not in sys.argv or "--no-isolation" in sys.argv:
        return "test" in sys.argv
    tomli = import_module("tomli")  # pyfrc's own
    try:
        project = tomli.loads(Path("pyproject.toml").read_text("utf-8"))
    except (OSError, ValueError):
        return False
    return project.get("tool", {}).get("robotpy", {}).get("pyfrc", {}).get("isolated") is False


def _is_flag(word: str) -> bool:
    """Whether a word of the command line is `--simcore`, or short for it."""
    return len(word) > 2 and "--simcore".startswith(word)


def _run_guarded(command: Any) -> None:
    """Let a start that fails end with its error.

    After a robot program that failed the process ends at once: vendors' threads may crash while Python ends.
    """
    run = command.run

    @functools.wraps(run)
    def run_guarded(options: Any, *args: Any, **kwargs: Any) -> Any:
        replacement = _attach if options.simcore else _guard
        if find_spec("pyfrc") is None:
            folder = Path(import_module("robotpy.main").robot_py_path).parent
            _, kwargs["robot_class"] = replacement(_physics_of_project, kwargs["robot_class"], folder)
        else:
            from pyfrc.physics.core import PhysicsInterface

            create = PhysicsInterface._create_and_attach

            def create_and_attach(cls: Any, robot_class: Any, robot_path: Path) -> tuple[Any, Any]:
                return replacement(create, robot_class, Path(robot_path))

            PhysicsInterface._create_and_attach = classmethod(create_and_attach)  # type: ignore[assignment, method-assign]

        if (
            options.simcore
            and options.nogui
            and not any(
                getattr(options, name.replace("-", "_"), False) for name in command.simexts if name != "simcore"
            )
        ):
            _silence_joysticks()
        if is_for_simcore(Path(), has_flag=options.simcore):
            logging.getLogger("robotpy").addFilter(_is_no_interrupt)
        result = run(options, *args, **kwargs)
        sys.stdout.flush()
        sys.stderr.flush()
        restore_stderr()
        if options.simcore and result is False:
            os._exit(1)
        return result

    command.run = run_guarded


_add_flags()

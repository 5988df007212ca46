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
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from simcore.errors import ConfigError, SimcoreError, VendorError
from simcore.install_text import install_command
from simcore.robotpy.console_noise import restore_stderr
from simcore.robotpy.sim_window import prepare_window
from simcore.start_errors import leave, print_error

__all__ = ["loadExtension"]

_log = logging.getLogger(__name__)

_PROGRAM = "robotpy sim"
_chosen: dict[str, str] = {}
"""What the flags `--game` and `--engine` say."""


def loadExtension() -> None:
    """What `robotpy sim` calls when the flag is given, after robot.py is imported and before the robot is built."""
    _load()
    from simcore.robotpy.attached_physics import AttachedPhysics
    from simcore.robotpy.console_noise import filter_stderr
    from simcore.robotpy.robot_attachment import is_port_taken

    AttachedPhysics.is_on_network = not is_port_taken()
    filter_stderr()


def _load() -> None:
    """Import what puts a robot on the field; drivetrains that are built from now on are noted."""
    try:
        import simcore.robotpy.robot_attachment  # noqa: F401
    except VendorError as error:
        _leave(error, Path())
    except ImportError as error:
        needs = install_command("phoenix6", "robotpy")
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


def _guard(create: Any, robot_class: Any, folder: Path) -> tuple[Any, Any]:
    """In place of pyfrc's own where the flag is not given: a physics.py of simcore's ends with a sentence as well."""
    try:
        interface, program = create(robot_class, folder)
    except Exception as error:
        if isinstance(error.__context__, SimcoreError):
            leave(error.__context__, program=_PROGRAM, folder=folder)
        raise
    if interface is not None and "simcore.robotpy.robot_physics" in sys.modules:
        from simcore.robotpy.robot_attachment import is_ours

        if is_ours(interface.module.PhysicsEngine):
            _leave_on_errors(interface, folder)
    return interface, program


def _leave(error: BaseException, folder: Path) -> NoReturn:
    restore_stderr()
    leave(error, program=_PROGRAM, folder=folder)


def _silence_joysticks() -> None:
    """Switch off WPILib's warning of missing joysticks, lines each second: a window or another program brings them."""
    from wpilib import DriverStation

    DriverStation.silenceJoystickConnectionWarning(True)
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
    """Add `--game NAME` and `--engine NAME` beside `--simcore`.

    pyfrc makes a flag without a value of each extension, and nothing more, while it loads them. So the parser is taken
    from the caller that imports this module for that purpose.
    """
    frame: types.FrameType | None = sys._getframe()
    while frame is not None:
        command, parser = (frame.f_locals.get(name) for name in ("self", "parser"))
        if type(command).__name__ == "PyFrcSim" and isinstance(parser, argparse.ArgumentParser):
            parser.add_argument(
                "--game",
                metavar="NAME",
                action=_Choose,
                help="with --simcore: the game to play, where several are installed",
            )
            parser.add_argument(
                "--engine",
                metavar="NAME",
                action=_Choose,
                help="with --simcore: the physics engine, bullet or mujoco (default: bullet where it is installed)",
            )
            prepare_window(command)
            _run_guarded(command)
            if any(word == "sim" for word in sys.argv) and any(_is_flag(word) for word in sys.argv):
                _load()  # before robot.py is imported: it may build its drivetrain then
            return
        frame = frame.f_back


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
        from pyfrc.physics.core import PhysicsInterface

        create = PhysicsInterface._create_and_attach
        replacement = _attach if options.simcore else _guard

        def create_and_attach(cls: Any, robot_class: Any, robot_path: Path) -> tuple[Any, Any]:
            return replacement(create, robot_class, Path(robot_path))

        if (
            options.simcore
            and options.nogui
            and not any(
                getattr(options, name.replace("-", "_"), False) for name in command.simexts if name != "simcore"
            )
        ):
            _silence_joysticks()
        PhysicsInterface._create_and_attach = classmethod(create_and_attach)  # type: ignore[assignment, method-assign]
        result = run(options, *args, **kwargs)
        if options.simcore:
            sys.stdout.flush()
            sys.stderr.flush()
            restore_stderr()
            if result is False:
                os._exit(1)
        return result

    command.run = run_guarded


_add_flags()

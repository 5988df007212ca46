"""The `simcore` command, which imports the module of a subcommand only when the subcommand is called."""

from __future__ import annotations

import argparse
import difflib
import importlib
import os
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple, NoReturn

from simcore import __version__
from simcore.errors import SimcoreError, UnknownNameError, outside_part, print_error
from simcore.install_text import install_command

__all__ = ["COMMANDS", "Command", "main"]


class Command(NamedTuple):
    """Subcommand of `simcore`: the module that implements the subcommand, and the help text.

    The module defines `add_arguments(parser)` and `run(args) -> int`. A module whose options depend on other arguments
    also defines `add_further_arguments(parser, words)`. If the module sets `takes_command` to True, `args.behind`
    contains the words after `--`.
    """

    module: str
    help: str


COMMANDS = {
    "doctor": Command("simcore.robotcode.sim.doctor", "check this computer and this folder, and say what to do"),
    "play": Command("simcore.show.play_command", "play an auto of a game: score, page and log"),
    "sweep": Command(
        "simcore.sweep.sweep_command", "play an auto many times: share of successes, and effects of changes"
    ),
    "compare": Command(
        "simcore.sweep.compare_command", "compare two versions of robot code, or two autos, on common seeds"
    ),
    "shots": Command(
        "simcore.sweep.shots_command", "make the shot table of a shooter: speed and elevation by distance"
    ),
    "calibrate": Command(
        "simcore.calibrate.calibrate_command",
        "fit a robot to its own log: values with intervals, and what they predict",
    ),
    "view": Command("simcore.show.view_command", "open the page of a log in the browser"),
    "layout": Command("simcore.show.scope_layout", "make a layout for AdvantageScope or Elastic, for a game or a log"),
    "new-game": Command("simcore.new_game.new_game_command", "write a package for a new year's game, ready to play"),
    "serve": Command("simcore.bridge.serve_command", "play with a robot program in Java or C++, stepped in lock-step"),
    "check": Command(
        "simcore.robotcode.sim.check_command",
        "run each mechanism of the described robot, and report implausible results",
    ),
    "init": Command("simcore.robot_file.init_command", "write a simcore.toml next to robot.py"),
}
"""Subcommands by name.

Each module is imported only when the subcommand is called, because a module may need optional packages.
"""


def main(argv: Sequence[str] | None = None, *, program: str = "simcore") -> int:
    """Run a subcommand, or print the help if the arguments contain no subcommand.

    Args:
        argv: Arguments without the program's name; None for `sys.argv[1:]`.
        program: Program name in messages: `simcore`, or the whole command before the options of a subcommand.

    Returns:
        Exit status: status of the subcommand, 0 for success; 1 after a reported error, 2 for an argument with a NUL
        character, 130 after Ctrl-C.

    Raises:
        SystemExit: If the arguments are invalid (status 2), or after printing the help or version (status 0).
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if any("\0" in word for word in words):
        print(f"{program}: an argument contains a NUL character, which file names cannot have", file=sys.stderr)
        return 2
    if sys.stdout is None:  # closed by the caller
        sys.stdout = open(os.devnull, "w")
    try:
        status = _run(words, program)
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader has closed the pipe, e.g. `| head -1`, which is not an error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # otherwise Python reports it at exit
        return 0


class _Parser(argparse.ArgumentParser):
    """Argument parser that reports a usage error in one line instead of printing all options."""

    def error(self, message: str) -> NoReturn:
        print_error(self.prog, f"{message} (`{self.prog} --help` lists what there is)")
        raise SystemExit(2)


def _run(words: list[str], program: str) -> int:
    called = f"simcore {words[0]}" if words and program == "simcore" else program
    try:
        with _modules_of_folder():
            args = _parse(words, program)
            return 0 if args is None else int(args.run(args))
    except SimcoreError as error:
        print_error(called, str(error))
        return 1
    except Exception as error:  # start the traceback of an error in a game or robot file at its own code
        start = outside_part(error)
        if start is None and isinstance(error, ImportError) and (error.name or "simcore").split(".")[0] != "simcore":
            print_error(called, f"{error}: {install_command()} installs what simcore needs")
            return 1
        if start is None:
            raise
        sys.stdout.flush()
        traceback.print_exception(type(error), error, start)
        return 1


def _parse(words: list[str], program: str) -> argparse.Namespace | None:
    """Parse the arguments; without a subcommand, print the help and return None.

    Raises:
        SystemExit: If the arguments are invalid, or `--help` or `--version` was given.
        SimcoreError: If the options of the subcommand cannot be determined, e.g. for an unknown game.
    """
    parser = _Parser(prog="simcore", description="A physics simulator for FRC robot code.")
    parser.add_argument("--version", action="version", version=f"simcore {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    behind: list[str] = []
    for name, command in COMMANDS.items():
        called = f"simcore {name}" if program == "simcore" else program
        subparser = subparsers.add_parser(name, prog=called, help=command.help, description=command.help)
        if words[:1] == [name]:
            module = importlib.import_module(command.module)
            if getattr(module, "takes_command", False) and "--" in words:
                words, behind = words[: words.index("--")], words[words.index("--") + 1 :]
            module.add_arguments(subparser)
            if hasattr(module, "add_further_arguments"):
                module.add_further_arguments(subparser, words[1:])
            subparser.set_defaults(run=module.run, behind=behind)
    if words and not words[0].startswith("-") and words[0] not in COMMANDS:
        parser.error(str(UnknownNameError("command", words[0], COMMANDS)))
    args, unknown = parser.parse_known_args(words)
    if unknown:
        asked = subparsers.choices.get(args.command, parser)
        near = difflib.get_close_matches(unknown[0].partition("=")[0], asked.format_usage().split(), n=1)
        hint = f". Did you mean {near[0].strip('[]')}?" if near and near[0].startswith("[-") else ""
        asked.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
    if args.command is None:
        parser.print_help()
        return None
    return args


@contextmanager
def _modules_of_folder() -> Iterator[None]:
    """Append the working directory to `sys.path` for the duration of the context.

    Python adds the working directory for `python -m simcore`, but not for the console script `simcore`.
    """
    folder, before = os.getcwd(), list(sys.path)
    if folder not in before and "" not in before:
        sys.path.append(folder)
    try:
        yield
    finally:
        sys.path[:] = before


if __name__ == "__main__":
    raise SystemExit(main())

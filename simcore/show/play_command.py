"""Command `simcore play [GAME]`, which plays an auto or a whole match and reports the result."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from simcore.errors import ConfigError, SimcoreError, UnknownNameError
from simcore.match.game import Auto, Game, PlayedMatch
from simcore.match.match import Match
from simcore.match.players.driven_robot import DriverControls, HandedOver
from simcore.match.players.lineup import ME, lineup, match_seconds, play_match, plays
from simcore.match.players.player import SKILLS
from simcore.match.registry import find_game, installed_games
from simcore.match.runner import AutoRun, auto_seconds, play_auto, print_report
from simcore.match.scatter import Scatter
from simcore.match.scoring import Alliance
from simcore.quantities import Quantity, number_flag, text_flag
from simcore.robot.robot import Controller
from simcore.robot.swerve_config import SwerveConfig
from simcore.show.run_outputs import RunOutputs
from simcore.show.view_driving import ViewDriving
from simcore.show.watch import Watch, add_options
from simcore.telemetry.snapshot import TelemetrySink
from simcore.units import TICK
from simcore.world.engine_choice import add_engine_option

__all__ = ["InterruptFlag", "add_arguments", "add_further_arguments", "run"]

_SEED = number_flag(Quantity("", 0, 2**32 - 1, is_whole=True))
_DRIVE = "drive"
"""Name of the auto without scripted motion, for a person who drives the robot from the page."""
_FREE = 3600.0  # [s]; longest time that a person may drive
_SECONDS = number_flag(Quantity("s", 0.0, 3600.0, is_open=True))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore play` that are common to all games."""
    parser.add_argument("game", nargs="?", metavar="GAME", help="which game (default: the newest that is installed)")
    parser.add_argument("--auto", metavar="NAME", help="which auto (see --list; default: the game's first), or 'drive'")
    parser.add_argument("--list", action="store_true", help="list games with their autos and players' roles, and stop")
    parser.add_argument("--match", action="store_true", help="a whole match of scripted players, with --red and --blue")
    players = f"up to three ROLE[:LEVEL] separated by commas, levels 1 to {len(SKILLS)}; 'me' plays --auto"
    parser.add_argument("--red", metavar="PLAYERS", default="", help=f"the red alliance: {players}")
    parser.add_argument("--blue", metavar="PLAYERS", default="", help="the blue alliance, in the form of --red")
    parser.add_argument(
        "--alliance", choices=("blue", "red"), default="blue", help="alliance of the robot (default: blue)"
    )
    parser.add_argument("--seed", type=_SEED, default=0, metavar="N", help="seed of everything left to chance")
    parser.add_argument(
        "--scatter",
        type=text_flag(Scatter.parse),
        nargs="?",
        const=Scatter(),
        metavar="SPREADS",
        help="vary robot, pieces and shots from seed to seed: by the default spreads, by a factor of them (0.5), or "
        "with some set by name (1,exit_speed=0.03; 0,elevation=0.01 varies that one alone)",
    )
    parser.add_argument("--seconds", type=_SECONDS, metavar="S", help="simulated time (default: as long as auto is)")
    parser.add_argument("--field", type=Path, metavar="FILE.obj", help="field mesh to use in place of the game's own")
    parser.add_argument("--log", type=Path, metavar="FILE.wpilog", help="default: out/NAME.wpilog")
    parser.add_argument(
        "--page", type=Path, metavar="FILE.html", help="a page that plays the run; default: out/NAME.html"
    )
    add_engine_option(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.add_argument(
        "--verbose", action="store_true", help="also print the engine, tick times and a digest of the run"
    )
    add_options(parser)
    parser.epilog = "`simcore play GAME --help` also lists the options of that game."


def add_further_arguments(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Add a flag for each option of the game.

    The function loads the game only if the command line has unknown words, or names a game and requests help.

    Args:
        parser: Parser of the command.
        words: Arguments typed after the command.

    Raises:
        SimcoreError: If the game is not installed or fails to load.
    """
    asked = [word for word in words if word not in ("-h", "--help")]
    known, further = parser.parse_known_args(asked)
    if further or (known.game and len(asked) < len(words)):
        try:
            game = find_game(known.game, say=str)
        except UnknownNameError as error:
            if further and not error.nearest:
                return  # the name may be the value of an unknown option, which the parser reports
            raise
        for option in game.options:
            parser.add_argument("--" + option.name.replace("_", "-"), action="store_true", help=option.help)


def run(options: argparse.Namespace) -> int:
    """Play an auto or a match and report the result, or list the games with `--list`.

    Returns:
        Exit status: 0 for success, 2 if printing fails, 130 after Ctrl-C.

    Raises:
        SimcoreError: If the options are invalid or the run cannot be played.
    """
    try:
        status = _list(options.game) if options.list else _play(options)
        sys.stdout.flush()
    except (BrokenPipeError, SimcoreError):
        raise
    except OSError as error:
        print(f"OutputError: cannot print: {error.strerror or error}", file=sys.stderr)
        return 2
    return status


def _list(name: str | None) -> int:
    def say(sentence: str) -> None:
        print(f"simcore: {sentence}", file=sys.stderr)

    for game in installed_games(say=say).values() if name is None else [find_game(name)]:
        print(f"{game.heading} ({game.year}), `{game.name}`")
        rows = {auto.name: auto.summary for auto in game.autos.values()}
        if _can_be_driven(game):
            rows.setdefault(_DRIVE, "stand until you drive, from the page of --view")
        wide = max(map(len, [*rows, *game.roles]), default=0)
        for row in rows.items():
            print(f"    {row[0]:{wide}} {row[1]}")
        for role in game.roles.values():
            print(f"    {role.name:{wide}} in a match: {role.summary}")
    return 0


def _play(options: argparse.Namespace) -> int:
    game = find_game(options.game, say=lambda which: print(f"simcore: {which}", file=sys.stderr))
    plan = _plan(options, game)
    outputs = _outputs(options, plan)
    if options.field is not None:
        game.field.load(options.field)  # before the last run's log is overwritten, in case the mesh is invalid
    watch = Watch(options, game, plan.driving)  # also before, in case the port is in use
    seed: int | None = options.seed
    try:
        sinks = outputs.sinks()
        with InterruptFlag() as interrupted:
            watch.wait(interrupted)
            if interrupted():
                return 130
            while seed is not None:
                played = _run(options, plan, seed, [*sinks, *watch.sinks()], watch, interrupted)
                played.match.close()  # completes the log
                if not watch.wants_restart:
                    _report(options, played, outputs)
                seed = None if interrupted() else watch.next_seed(outputs.recording, interrupted)
                if seed is not None:
                    outputs = _outputs(options, plan)
                    sinks = outputs.sinks()
    finally:
        watch.close()
    return 130 if played.was_interrupted else 0


@dataclass(frozen=True, slots=True)
class _Plan:
    """Auto or match to play: name, simulated duration [s], function that plays a run, and input of drivers."""

    game: Game
    name: str
    seconds: float
    play: Callable[..., AutoRun]
    driving: ViewDriving | None
    """Input of the drivers at the pages; None without `--view`, or if a person cannot drive the robots of the game."""


def _plan(options: argparse.Namespace, game: Game) -> _Plan:
    if not options.match and (options.red or options.blue):
        raise ConfigError("--red and --blue say who plays a whole match: give --match, too")
    seats = lineup(game, red=options.red, blue=options.blue) if options.match else ()
    me = any(seat.role == ME for seat in seats)
    if options.match and options.auto is not None and not me:
        raise ConfigError(
            f"--auto {options.auto} is what {ME!r} plays in a match, but neither --red nor --blue has {ME!r}"
        )
    driving = None
    if options.view and _can_be_driven(game):
        actions = tuple((game.driving or DriverControls()).actions)
        at_once = me or options.auto == _DRIVE
        driving = ViewDriving(actions, robots=len(seats) or 1, at_once=at_once, is_free=_is_free(options, game))

    def hand_over(match: PlayedMatch, number: int, own: Controller) -> Controller:
        if driving is None or not isinstance(match.robots[number].config.drivetrain, SwerveConfig):
            return own
        person = partial(driving.input, number)
        return HandedOver(match, match.alliances[number], own, person, from_teleop=options.match)

    if options.match and not me:
        play = partial(play_match, game, seats, hand_over=hand_over)
        return _Plan(game, "match", options.seconds or match_seconds(game), play, driving)
    auto = _auto(options, game)
    mine = replace(auto, controller=lambda match, alliance: hand_over(match, 0, auto.controller(match, alliance)))
    if options.match:
        play = partial(play_match, game, seats, me=plays(mine), hand_over=hand_over)
        return _Plan(game, "match", options.seconds or match_seconds(game), play, driving)
    is_free = _is_free(options, game)
    play = partial(play_auto, game, mine, alliance=options.alliance, practice=is_free)
    return _Plan(game, auto.name, options.seconds or (_FREE if is_free else auto_seconds(game)), play, driving)


def _auto(options: argparse.Namespace, game: Game) -> Auto:
    if options.auto != _DRIVE or _DRIVE in game.autos:
        try:
            return game.auto(options.auto)
        except UnknownNameError as error:
            if not Path("robot.py").is_file():
                raise
            own = "`python -m robotpy sim --simcore` and `simcore sweep --project .` play those of robot.py"
            raise ConfigError(f"{error}; {own}") from error
    if not options.view:
        raise ConfigError("--auto drive is for a person at the page: give --view, too")
    if not _can_be_driven(game):
        raise ConfigError(f"--auto drive: a person can only drive robots with swerve, and that of {game.name} has none")
    return Auto(name=_DRIVE, summary="", controller=_freely, start=game.starts[0])


def _is_free(options: argparse.Namespace, game: Game) -> bool:
    """Return whether a person drives freely, without a match or a clock."""
    return options.auto == _DRIVE and _DRIVE not in game.autos and not options.match


def _freely(match: PlayedMatch, alliance: Alliance) -> Controller:
    """Enable the robots for the whole run, in teleop mode if the match has a teleop phase.

    Return a controller that does nothing.
    """
    match.timer.follow_driver_station()
    if any(phase.mode == "teleop" for phase in match.timer.clock.phases):
        match.timer.start("teleop")
    match.timer.set_enabled(True)
    return lambda robot, time: None


def _can_be_driven(game: Game) -> bool:
    return isinstance(game.robot().drivetrain, SwerveConfig)


def _outputs(options: argparse.Namespace, plan: _Plan) -> RunOutputs:
    return RunOutputs.plan(
        Path("out"),
        plan.name,
        log=options.log,
        page=options.page,
        seconds=plan.seconds,
        say=lambda sentence: print(f"simcore: {sentence}", file=sys.stderr),
    )


def _report(options: argparse.Namespace, played: AutoRun, outputs: RunOutputs) -> None:
    report = played.report
    report.outputs = outputs.write(played)
    if options.json:
        print(report.to_json())
    else:
        print_report(report, Console(), verbose=options.verbose)
        if played.was_interrupted:
            print(f"interrupted after {report.sim_seconds:.2f} s; log and page are of that part")
    sys.stdout.flush()


def _run(
    options: argparse.Namespace,
    plan: _Plan,
    seed: int,
    sinks: Sequence[TelemetrySink],
    watch: Watch,
    interrupted: Callable[[], bool],
) -> AutoRun:
    """Play one run with a progress bar on stderr, because stdout contains only the report."""
    progress = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[period]}, {task.fields[score]} points"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=options.json or not sys.stderr.isatty(),
    )
    with progress:
        ticks = max(1, round(plan.seconds / TICK))
        task = progress.add_task(repr(plan.name), total=ticks, score=0, period=plan.game.clock.phases[0].name)

        def show(match: Match) -> None:
            if match.ticks % 10 == 0:
                progress.update(task, completed=match.ticks, score=match.score.total, period=match.timer.phase.name)
            watch.after_tick(match, interrupted)

        return plan.play(
            seconds=plan.seconds,
            seed=seed,
            scatter=options.scatter,
            options=[option.name for option in plan.game.options if getattr(options, option.name, False)],
            field_mesh=options.field,
            engine=options.engine,
            sinks=sinks,
            on_tick=show,
            should_stop=lambda: interrupted() or watch.wants_restart,
        )


class InterruptFlag:
    """Flag that Ctrl-C sets, so a run can end between two ticks; a second Ctrl-C ends the program at once."""

    def __init__(self) -> None:
        self._is_set = False

    def __call__(self) -> bool:
        """Return whether Ctrl-C was pressed."""
        return self._is_set

    def __enter__(self) -> InterruptFlag:
        self._before = signal.signal(signal.SIGINT, self._on_interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _on_interrupt(self, number: int, frame: object) -> None:
        self._is_set = True
        signal.signal(signal.SIGINT, signal.default_int_handler)

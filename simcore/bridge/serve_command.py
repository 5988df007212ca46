"""Command `simcore serve [GAME] -- COMMAND`, which steps a Java, C++ or Python robot program in another process."""

from __future__ import annotations

import argparse
import logging
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from simcore import season
from simcore.bridge.built_extension import extension_path
from simcore.bridge.robot_process import ProgramError, RobotProcess
from simcore.bridge.served_robot import ServedRobot, require_ports
from simcore.errors import ConfigError, UnknownNameError
from simcore.match.runner import AutoRun, RunReport, auto_seconds, print_report
from simcore.match.scatter import Scatter
from simcore.quantities import Quantity, number_flag, text_flag
from simcore.robot_file.reader import read_settings
from simcore.robot_file.template import FILE_NAME
from simcore.robotcode.sim.attached_physics import choose_game
from simcore.robotcode.sim.built_ports import built_ports
from simcore.robotcode.sim.driver_controls import auto_choices
from simcore.robotcode.sim.robot_test import RobotTest
from simcore.robotcode.sim.run_variation import run_variation, set_run_variation
from simcore.show.play_command import InterruptFlag
from simcore.show.run_outputs import RunOutputs
from simcore.show.watch import Watch, add_options
from simcore.sweep.results import Condition
from simcore.sweep.run_metrics import METRICS, measure
from simcore.units import TICK
from simcore.world.engine_choice import add_engine_option

__all__ = ["add_arguments", "run", "takes_command"]

takes_command = True
"""Whether the command line passes the words after `--` to this command; here the words are the program's command."""
_SEED = number_flag(Quantity("", 0, 2**32 - 1, is_whole=True))
_SECONDS = number_flag(Quantity("s", 0.0, 3600.0, is_open=True))
_TABLES = 5810  # default port of NetworkTables
_MODES = ("auto", "teleop", "match", "test")
_SCORES = ("score.blue", "score.red", "score.total")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore serve`."""
    parser.usage = "%(prog)s [GAME] [options] [-- COMMAND ...]"
    parser.add_argument(
        "game", nargs="?", metavar="GAME", help=f"which game (default: that of {FILE_NAME}, or the newest)"
    )
    parser.add_argument(
        "--robot",
        type=Path,
        default=Path(FILE_NAME),
        metavar="FILE.toml",
        help="the file that says what is on which port",
    )
    parser.add_argument("--auto", metavar="NAME", help="which auto of the program's chooser (default: its own choice)")
    parser.add_argument("--mode", choices=_MODES, help="what to play: an auto (default), teleop, both, or test mode")
    parser.add_argument("--match", metavar="NAME", help="a whole match with scripted players, such as practice-2v2")
    parser.add_argument(
        "--alliance", choices=("blue", "red"), default="blue", help="alliance of the robot (default: blue)"
    )
    parser.add_argument(
        "--seconds", type=_SECONDS, metavar="S", help="simulated time (default: as long as the mode is)"
    )
    parser.add_argument(
        "--expect", metavar="CONDITION", help="exit with status 1 unless this holds: 'score.blue >= 8 and hits > 5'"
    )
    parser.add_argument("--seed", type=_SEED, default=0, metavar="N", help="seed of everything left to chance")
    parser.add_argument("--scatter", type=text_flag(Scatter.parse), metavar="SPREADS", help="as for `simcore play`")
    parser.add_argument(
        "--real-time",
        action="store_true",
        help="let the program's clock run by itself; without --auto and --mode, its own driver station enables it",
    )
    parser.add_argument(
        "--wait", type=_SECONDS, default=120.0, metavar="S", help="time limit for the program's start (default: 120)"
    )
    parser.add_argument(
        "--hang", type=_SECONDS, default=20.0, metavar="S", help="time limit for one of its loops (default: 20)"
    )
    parser.add_argument("--log", type=Path, metavar="FILE.wpilog", help="default: out/NAME.wpilog")
    parser.add_argument("--page", type=Path, metavar="FILE.html", help="default: out/NAME.html")
    parser.add_argument("--check", action="store_true", help="list what the program has opened, and stop")
    parser.add_argument("--extension", action="store_true", help="say where the extension is, and stop")
    add_engine_option(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    parser.add_argument(
        "--verbose", action="store_true", help="also print the engine, tick times and a digest of the run"
    )
    add_options(parser)


def run(options: argparse.Namespace) -> int:
    """Run a robot program with the simulation, print the report, and write the log and the page.

    With `--check`, list the ports of the program instead. With `--extension`, print the path of the extension instead.

    Returns:
        Exit status: 0 for success, 1 if the condition of `--expect` does not hold, 130 after Ctrl-C.

    Raises:
        SimcoreError: If the options are invalid, or the program has failed.
    """
    if options.extension:
        print(extension_path())
        return 0
    condition = None if options.expect is None else _condition(options.expect)
    if options.live and options.nt_port == _TABLES:
        raise ConfigError(
            f"--live: port {_TABLES} is the program's own: give --nt-port {_TABLES + 1}, or --real-time, which "
            "publishes simcore's telemetry next to the program's"
        )
    if options.check:
        return _check(options)
    if not options.robot.is_file():
        raise ConfigError(f"there is no {options.robot}: it must say what is on which port (docs/java.md)")
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    settings = read_settings(options.robot)
    require_ports(settings)  # before the program starts
    game = choose_game(options.game, settings.game)
    plan = _plan(options, auto_seconds(game), game.clock.duration)
    set_run_variation(replace(run_variation(), seed=options.seed, scatter=options.scatter))
    _connect_tables(options.real_time)
    outputs = RunOutputs.plan(
        Path("out"), plan.name, log=options.log, page=options.page, seconds=plan.seconds, say=_say
    )
    watch = Watch(options, game)
    try:
        played = _play(options, plan, outputs, watch)  # until the program drives, Ctrl-C ends the command at once
        with InterruptFlag() as interrupted:
            if not played.was_interrupted and watch.next_seed(outputs.recording, interrupted) is not None:
                _say("for another run, start the command again")
    finally:
        watch.close()
    return _judge(condition, played)


def _check(options: argparse.Namespace) -> int:
    """Start the program, print the program's ports, SimDevices and autos, and return exit status 0.

    The function does not need a simcore.toml.
    """
    _connect_tables(real_time=False)
    process = RobotProcess(options.behind, patience=options.wait, hang=options.hang, say=_say)
    with process, _robot(options, process, follows=False) as robot:
        robot.connect()
        robot.ask_choosers()
        rows = [(port.model, " ".join(map(str, port.channels)), port.made_by) for port in built_ports()]
        rows += [("SimDevice", name, "") for name in season.wpilib_simulation.SimDeviceSim.enumerate_devices("")]
        rows += [("autos", key, ", ".join(autos)) for key, autos in auto_choices().items()]
    for model, place, what in rows:
        what = "" if model == "PWM" else what  # the HAL does not give the class of a PWM device
        print(f"{model:10} {place:12} {what}".rstrip())
    if not rows:
        print("the program has opened no port")
    return 0


@dataclass(frozen=True, slots=True)
class _Plan:
    """Name of a run, modes with their durations [s], and total duration [s].

    The run has no modes if the driver station of the program sets the mode.
    """

    name: str
    modes: tuple[tuple[str, float], ...]
    seconds: float


def _plan(options: argparse.Namespace, auto: float, whole: float) -> _Plan:
    is_match = options.mode == "match" or (options.match and not options.mode)
    if options.real_time and not (options.auto or options.mode or options.match):
        return _Plan("serve", (), options.seconds or 3600.0)
    if is_match:
        length = options.seconds or whole
        modes = (("autonomous", min(auto, length)), ("teleop", max(0.0, length - auto)))
        return _Plan("match", modes, length)
    mode = {"teleop": "teleop", "test": "utility"}.get(options.mode or "", "autonomous")
    length = options.seconds or (auto if mode == "autonomous" else max(whole - auto, auto))
    return _Plan(options.auto or options.mode or "auto", ((mode, length),), length)


@dataclass(slots=True)
class _Times:
    """Records of each tick for the report.

    `path` has the robot pose after the tick (x, y, yaw) [m, m, rad]. `ticks` has the wall time [s], the number of
    substeps and the number of awake pieces.
    """

    path: list[tuple[float, float, float]] = field(default_factory=list)
    ticks: list[tuple[float, int, int]] = field(default_factory=list)


def _play(options: argparse.Namespace, plan: _Plan, outputs: RunOutputs, watch: Watch) -> AutoRun:
    start = time.perf_counter()
    printed = None if outputs.log is None else outputs.log.with_suffix(".txt")
    process = RobotProcess(options.behind, patience=options.wait, hang=options.hang, output=printed, say=_say)
    with process, _robot(options, process, follows=not plan.modes) as robot, ExitStack() as stack:
        for sink in (*outputs.sinks(), *watch.sinks()):
            robot.add_sink(sink)
        robot.alliance(options.alliance)
        robot.start()
        match, times = robot.match, _Times()
        interrupted = stack.enter_context(InterruptFlag())
        watch.wait(interrupted)
        try:
            pieces = match.pieces.state.pos[match.pieces.on_field()].copy()
            began = time.perf_counter()
            failure: ProgramError | None = None
            try:
                for mode, seconds in plan.modes or (("", plan.seconds),):
                    _enter(robot, mode, options.auto)
                    for _ in range(round(seconds / TICK)):
                        if interrupted():
                            break
                        _tick(robot, times)
                        watch.after_tick(match, interrupted)
            except ProgramError as error:
                failure = error
                match.record.failure = str(error)
                for sink in match.sinks:
                    sink.write(match.snapshot())
            wall = time.perf_counter() - began
            report = RunReport(match, plan.name, startup_seconds=began - start, wall_seconds=wall, ticks=times.ticks)
            played = AutoRun(report, match, np.array(times.path).reshape(-1, 3), pieces, interrupted())
        finally:
            match.close()
        report.outputs = outputs.write(played)
        _print(options, report)
        if failure is not None:
            raise failure
        return played


def _robot(options: argparse.Namespace, process: RobotProcess, *, follows: bool) -> ServedRobot:
    return ServedRobot(
        process,
        options.robot.resolve(),
        game=options.game,
        real_time=options.real_time,
        follows=follows,
        engine=options.engine,
        match=options.match,
    )


def _enter(robot: RobotTest, mode: str, auto: str | None) -> None:
    if mode == "autonomous":
        robot.autonomous(auto, seconds=0.0)
    elif mode:
        getattr(robot, mode)(seconds=0.0)


def _tick(robot: RobotTest, times: _Times) -> None:
    match, begin = robot.match, time.perf_counter()
    robot.run(TICK)
    times.path.append(match.robots[0].chassis.pose)
    times.ticks.append((time.perf_counter() - begin, match.substeps, len(match.pieces.awake)))


def _connect_tables(real_time: bool) -> None:
    """Start NetworkTables for this process only, or connect to the program's NetworkTables server in real time."""
    tables: Any = season.ntcore.NetworkTableInstance.get_default()
    if real_time:
        tables.startClient4("simcore")
        tables.setServer("127.0.0.1")
    else:
        tables.start_local()


def _condition(text: str) -> Condition:
    condition = Condition(text)
    for name in condition.names:
        if name not in (*METRICS, *_SCORES) and not name.startswith("breakdown."):
            raise UnknownNameError("metric (of --expect)", name, (*_SCORES, *METRICS))
    return condition


def _judge(condition: Condition | None, played: AutoRun) -> int:
    if played.was_interrupted:
        return 130
    if condition is None:
        return 0
    match = played.match
    scores = dict(zip(_SCORES, (match.score.blue, match.score.red, match.score.total), strict=True))
    row = {**measure(match, ()), **scores, "error": ""}
    got = ", ".join(f"{name} is {row.get(name, 'not there')}" for name in condition.names)
    holds = condition.holds(row)
    print(f"{'as expected' if holds else 'not as expected'}: {condition.text} ({got})")
    return 0 if holds else 1


def _print(options: argparse.Namespace, report: RunReport) -> None:
    if options.json:
        print(report.to_json())
    else:
        print_report(report, Console(), verbose=options.verbose)
    sys.stdout.flush()


def _say(sentence: str) -> None:
    print(f"simcore: {sentence}", file=sys.stderr, flush=True)

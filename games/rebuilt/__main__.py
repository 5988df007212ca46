"""`python -m games.rebuilt`: play a scripted auto and see what comes of it."""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from games.rebuilt.autos import AUTOS, Auto, find_auto
from games.rebuilt.field import load_field
from games.rebuilt.outputs import RunOutputs
from games.rebuilt.publish import build_snapshot
from games.rebuilt.runner import AutoRun, play_auto
from games.rebuilt.sim import DT, RebuiltConfig, RebuiltSim
from games.rebuilt.watch import Watch, add_options
from simcore.errors import SimcoreError
from simcore.match.report import print_report
from simcore.telemetry.snapshot import TelemetrySink

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns the exit status: 0 played, 2 wrong input, 130 interrupted."""
    options = _parser().parse_args(argv)
    try:
        status = _list() if options.list else _play(options)
        sys.stdout.flush()
    except SimcoreError as error:
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 2
    except BrokenPipeError:  # whoever read our output has gone, e.g. `| head -1`: nothing is wrong
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())  # else the interpreter complains at its end
        return 0
    except OSError as error:
        print(f"OutputError: cannot print: {error.strerror or error}", file=sys.stderr)
        return 2
    return status


def _list() -> int:
    for auto in AUTOS.values():
        print(f"{auto.name:10} {auto.summary}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m games.rebuilt", description="Play a scripted auto of REBUILT.")
    parser.add_argument("--auto", default="depot", metavar="NAME", help="which auto (see --list; default: depot)")
    parser.add_argument("--list", action="store_true", help="list the autos and stop")
    parser.add_argument("--alliance", choices=("blue", "red"), default="blue", help="whose robot (default: blue)")
    parser.add_argument("--seed", type=_whole, default=0, metavar="N", help="seed of everything left to chance")
    parser.add_argument("--seconds", type=_positive, default=20.0, metavar="S", help="simulated time (default: 20)")
    parser.add_argument("--field", type=Path, metavar="FILE.obj", help="another field mesh than the one of simcore")
    parser.add_argument("--hub-exits", action="store_true", help="scored fuel comes out of the hub's exits")
    parser.add_argument("--log", type=Path, metavar="FILE.wpilog", help="default: out/NAME.wpilog")
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="default: out/NAME.png")
    parser.add_argument(
        "--page", type=Path, metavar="FILE.html", help="a page that plays the run; default: out/NAME.html"
    )
    parser.add_argument(
        "--animation",
        type=Path,
        nargs="?",
        const=True,
        default=False,
        metavar="FILE.gif",
        help="a moving picture too, GIF or (with ffmpeg) MP4; default: out/NAME.gif",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of tables")
    add_options(parser)
    return parser


def _play(options: argparse.Namespace) -> int:
    auto = find_auto(options.auto)
    outputs = _outputs(options, auto)
    if options.field is not None:
        load_field(options.field)  # a broken mesh must not cost the last run's log
    config = RebuiltConfig(hub_exits=options.hub_exits, field_mesh=options.field)
    sinks = outputs.sinks()  # a log that cannot be written ends it here, before anything is served
    watch = Watch(options)
    seed: int | None = options.seed
    try:
        with InterruptFlag() as interrupted:
            while seed is not None:
                run = _run(options, auto, replace(config, seed=seed), [*sinks, *watch.sinks()], watch, interrupted)
                final = build_snapshot(run.sim)
                run.sim.close()  # the log is whole from here on
                if not watch.wants_restart:
                    _report(options, run, outputs)
                seed = None if interrupted() else watch.next_seed(final, interrupted)
                if seed is not None:
                    outputs = _outputs(options, auto)
                    sinks = outputs.sinks()
    finally:
        watch.close()
    return 130 if run.was_interrupted else 0


def _outputs(options: argparse.Namespace, auto: Auto) -> RunOutputs:
    return RunOutputs.plan(
        Path("out"),
        auto.name,
        log=options.log,
        picture=options.picture,
        page=options.page,
        animation=options.animation,
        seconds=options.seconds,
        say=lambda sentence: print(f"simcore: {sentence}", file=sys.stderr),
    )


def _report(options: argparse.Namespace, run: AutoRun, outputs: RunOutputs) -> None:
    report = replace(run.report, outputs=outputs.write(run))
    if options.json:
        print(report.to_json())
    else:
        print_report(report, Console())
        if run.was_interrupted:
            print(f"interrupted after {report.sim_seconds:.2f} s; log, picture and page are of that part")
    sys.stdout.flush()


def _run(
    options: argparse.Namespace,
    auto: Auto,
    config: RebuiltConfig,
    sinks: Sequence[TelemetrySink],
    watch: Watch,
    interrupted: Callable[[], bool],
) -> AutoRun:
    """Play with a progress bar on stderr, so that stdout stays clean."""
    progress = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[score]} points"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=options.json or not sys.stderr.isatty(),
    )
    ticks = max(1, round(options.seconds / DT))
    with progress:
        task = progress.add_task(f"auto {auto.name!r}", total=ticks, score=0)

        def show(sim: RebuiltSim) -> None:
            if sim.ticks % 10 == 0:
                progress.update(task, completed=sim.ticks, score=sum(sim.tracker.totals.values()))
            watch.after_tick(sim, interrupted)

        return play_auto(
            auto,
            alliance=options.alliance,
            seconds=options.seconds,
            config=config,
            seed=config.seed,
            sinks=sinks,
            on_tick=show,
            should_stop=lambda: interrupted() or watch.wants_restart,
        )


class InterruptFlag:
    """Ctrl-C ends the run between two ticks, so that nothing is half done; a second one ends the program at once."""

    def __init__(self) -> None:
        self._is_set = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self._is_set

    def __enter__(self) -> InterruptFlag:
        self._before = signal.signal(signal.SIGINT, self._on_interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _on_interrupt(self, number: int, frame: object) -> None:
        self._is_set = True
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"must be a finite number > 0, got {text!r}")
    return value


def _whole(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = -1
    if value < 0:
        raise argparse.ArgumentTypeError(f"must be a whole number >= 0, got {text!r}")
    return value


if __name__ == "__main__":
    sys.exit(main())

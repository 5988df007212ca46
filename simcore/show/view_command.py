"""`simcore view FILE.wpilog`: replay a log in the browser."""

from __future__ import annotations

import argparse
import contextlib
import math
from pathlib import Path

from simcore.quantities import PORT, Quantity, number_flag
from simcore.show.log_page import game_of_log
from simcore.show.play_command import InterruptFlag
from simcore.show.replay import Replay, can_draw
from simcore.show.view_models import find_models, load_models
from simcore.show.view_server import open_browser
from simcore.telemetry.wpilog import read_log

__all__ = ["add_arguments", "run"]

_SECONDS = number_flag(Quantity("s", 0.0, 1e6, is_open=True, may_be_infinite=True))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "log", type=Path, metavar="FILE.wpilog", help="a log of simcore, DataLogManager or AdvantageKit"
    )
    parser.add_argument("--models", type=Path, metavar="FOLDER", help="folder with Field3d_... and Robot_... folders")
    parser.add_argument("--robot", default="", metavar="NAME", help="which robot model (default: the first)")
    parser.add_argument("--game", default="", metavar="NAME", help="whose models (default: as the log says)")
    parser.add_argument("--host", default="127.0.0.1", help="where to listen (default: this computer only)")
    parser.add_argument("--port", type=number_flag(PORT), default=0, help="default: a free one")
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")
    parser.add_argument(
        "--seconds", type=_SECONDS, default=math.inf, help="stop serving after so long (default: Ctrl-C)"
    )


def run(options: argparse.Namespace) -> int:
    """Serve the replay until Ctrl-C; returns 0.

    Raises:
        SimcoreError: The log, the models or the port cannot be used.
    """
    with contextlib.suppress(KeyboardInterrupt), InterruptFlag() as interrupted:
        _show(options, interrupted)
    return 0


def _show(options: argparse.Namespace, interrupted: InterruptFlag) -> None:
    log = read_log(options.log)
    first, last = log.span
    print(f"{options.log}: {last - first:.1f} s, {len(log.columns)} keys")
    if log.ends_early:
        print("its end is cut off; what is there is shown")
    if not can_draw(log):
        print(
            "it holds no Sim/Robot/Pose3d and no Sim/GamePieces: only the field is shown. "
            "Publish these keys (docs/telemetry.md), or open it in AdvantageScope"
        )
    models = (
        load_models(options.models)
        if options.models
        else find_models(options.game or game_of_log(log) or "", say=print)
    )
    replay = Replay(log, models, host=options.host, port=options.port, robot=options.robot)
    try:
        print(f"the replay is at {replay.url}" if options.no_browser else open_browser(replay.url))
        print("Ctrl-C ends it", flush=True)
        replay.run(should_stop=interrupted, seconds=options.seconds)
    finally:
        replay.close()

"""`simcore view FILE.wpilog`: the page of a log, opened in the browser."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from simcore.errors import OutputError
from simcore.show.log_page import recorded_game, recording_of, scene_of_log
from simcore.show.page import write_page
from simcore.show.view_models import load_models
from simcore.show.view_server import open_browser
from simcore.telemetry.wpilog import read_log

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "log", type=Path, metavar="FILE.wpilog", help="a log of simcore, DataLogManager or AdvantageKit"
    )
    parser.add_argument("--models", type=Path, metavar="FOLDER", help="folder with Field3d_... and Robot_... folders")
    parser.add_argument("--robot", default="", metavar="NAME", help="which robot model (default: the first)")
    parser.add_argument("--game", default="", metavar="NAME", help="whose field and models (default: as the log says)")
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")


def run(options: argparse.Namespace) -> int:
    """Write the page beside the log, or in a folder for temporary files, and open it; returns 0.

    Raises:
        SimcoreError: The log or the models cannot be used.
    """
    log = read_log(options.log)
    first, last = log.span
    print(f"{options.log}: {last - first:.1f} s, {len(log.columns)} keys")
    if log.ends_early:
        print("its end is cut off; what is there is shown", file=sys.stderr)
    recording = recording_of(log)
    scene = scene_of_log(recording, options.game or None)
    if options.models is not None:
        load_models(options.models).robot(options.robot)  # a wrong name is said, not drawn as boxes
        scene = scene.with_models(options.models, options.robot)
    elif options.robot and scene.models is not None:
        load_models(scene.models).robot(options.robot)
        scene = scene.with_models(scene.models, options.robot)
    name = recorded_game(recording)
    title = f"{name.upper()}, {options.log.stem}" if name else options.log.stem
    page = options.log.with_suffix(".html")
    try:
        write_page(page, recording, scene, title=title)
    except OutputError:
        page = Path(tempfile.mkdtemp(prefix="simcore_")) / page.name
        write_page(page, recording, scene, title=title)
    print(page if options.no_browser else open_browser(page.resolve().as_uri()))
    return 0

"""`simcore view FILE.wpilog`: the page of a log, opened in the browser."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from simcore.errors import OutputError
from simcore.show.log_page import load_run
from simcore.show.page import write_page
from simcore.show.view_models import load_models
from simcore.show.view_server import open_browser

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
    recording, scene, title = load_run(options.log, options.game or None)
    models = options.models or (scene.models if options.robot else None)
    if models is not None:
        load_models(models).robot(options.robot)  # a wrong name is said, not drawn as boxes
        scene = scene.with_models(models, options.robot)
    page = options.log.with_suffix(".html")
    try:
        write_page(page, recording, scene, title=title)
    except OutputError:
        page = Path(tempfile.mkdtemp(prefix="simcore_")) / page.name
        write_page(page, recording, scene, title=title)
    print(page if options.no_browser else open_browser(page.resolve().as_uri()))
    return 0

"""Command `simcore view FILE.wpilog`, which writes the page of a log and opens the page in the browser."""

from __future__ import annotations

import argparse
from pathlib import Path

from simcore.show.log_page import write_log_page
from simcore.show.view_server import open_browser

__all__ = ["add_arguments", "run"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments and options of `simcore view`."""
    parser.add_argument(
        "log", type=Path, metavar="FILE.wpilog", help="a log of simcore, DataLogManager or AdvantageKit"
    )
    parser.add_argument("--page", type=Path, metavar="FILE.html", help="default: next to the log")
    parser.add_argument("--models", type=Path, metavar="FOLDER", help="folder with Field3d_... and Robot_... folders")
    parser.add_argument("--game", metavar="NAME", help="game whose field and models to show (default: as the log says)")
    parser.add_argument("--no-browser", action="store_true", help="do not open a browser")


def run(options: argparse.Namespace) -> int:
    """Write a web page of the log, open it in a browser unless `--no-browser` is given, and return exit status 0.

    Raises:
        SimcoreError: If the log or the models cannot be used, or the page cannot be written.
    """
    page = write_log_page(options.log, page=options.page, game=options.game, models=options.models)
    print(f"{'page':9}  {page}")
    if not options.no_browser:
        print(open_browser(page.resolve().as_uri()))
    return 0

"""Take the picture of a page for the docs: play the start of a match and open its page in a headless Chromium.

    python scripts/take_picture.py [PICTURE.png] [--page PAGE.html] [--at 45] [--size 1200x640]

It needs Chromium or Chrome, which simcore itself does not.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from simcore.match.players.lineup import lineup, play_match
from simcore.match.registry import find_game
from simcore.show.page import write_page
from simcore.show.scene import scene_of
from simcore.telemetry.recording import Recording

ROOT = Path(__file__).resolve().parents[1]
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
_FLAGS = (
    "--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
    "--no-first-run", "--disable-background-networking", "--virtual-time-budget=5000",
)  # fmt: skip


def find_browser() -> str:
    """Return the path of a Chromium or Chrome.

    Raises:
        SystemExit: If there is none on the path.
    """
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        raise SystemExit(
            f"take_picture: no Chromium or Chrome on this computer's path: looked for {', '.join(BROWSERS)}"
        )
    return found


def take_picture(page: Path, picture: Path, *, at: float, size: tuple[int, int]) -> None:
    """Write a picture of a page in a browser.

    Args:
        page: Page of a run.
        picture: PNG file to write, in an existing folder.
        at: Time of the run [s].
        size: Width and height of the window [px].

    Raises:
        SystemExit: If there is no browser or it takes no picture.
    """
    browser = find_browser()
    picture.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser, *_FLAGS, f"--user-data-dir={profile}", f"--window-size={size[0]},{size[1]}"]
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.append("--no-sandbox")  # Chromium's sandbox does not start for the administrator
        command += [f"--screenshot={picture.resolve()}", f"{page.resolve().as_uri()}#t={at:g}"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    if not picture.is_file():
        raise SystemExit(f"take_picture: {browser} took no picture: {done.stderr.strip()[-500:]}")


def main(argv: list[str] | None = None) -> int:
    """Take the picture and return 0."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", type=Path, nargs="?", default=ROOT / "docs" / "images" / "page.png")
    parser.add_argument("--page", type=Path, help="page of a run (default: play the start of a match)")
    parser.add_argument("--at", type=float, default=45.0, help="time of the run [s]")
    parser.add_argument("--size", default="1200x640", help="size of the window [px]")
    options = parser.parse_args(argv)
    find_browser()  # before a run is played in vain
    with tempfile.TemporaryDirectory() as folder:
        page = options.page or Path(folder) / "match.html"
        if options.page is None:
            recording, game = Recording(), find_game("rebuilt")
            seats = lineup(game, blue="collector:3,shuttle,collector:2", red="collector:3,collector:2,defender")
            run = play_match(game, seats, seed=4, seconds=options.at + 15.0, sinks=[recording])
            write_page(page, recording, scene_of(run.match), title="REBUILT, match, seed 4")
            run.match.close()
        width, height = map(int, options.size.split("x"))
        take_picture(page, options.picture, at=options.at, size=(width, height))
    print(options.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())

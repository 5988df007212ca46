"""Writes models/advantagescope/layout*.json: AdvantageScope's tabs for REBUILT with one robot, and with six.

    python scripts/make_layout.py [FOLDER]

As `simcore layout rebuilt` does. Each shows only what a run with so many robots publishes.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from games.rebuilt.game import REBUILT
from simcore.show.scope_layout import game_snapshot, scope_layout
from simcore.show.view_models import load_models

FOLDER = Path(__file__).resolve().parents[1] / "models" / "advantagescope"
LAYOUTS = {"layout.json": 1, "layout_six.json": REBUILT.robots}
"""Files, and for how many robots they are."""


def write_layouts(output: Path) -> None:
    """Write both."""
    models = load_models(FOLDER)
    for name, robots in LAYOUTS.items():
        layout = scope_layout(game_snapshot(REBUILT, robots=robots), models)
        (output / name).write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8", newline="\n")
        print(output / name)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, default=FOLDER, help="default: %(default)s")
    write_layouts(parser.parse_args().folder)

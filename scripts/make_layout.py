"""Write layout.json and layout_six.json to each game's models: AdvantageScope's tabs for one robot, and for six.

    python scripts/make_layout.py

They are those of `simcore layout rebuilt`. Each shows only the channels of a run with that many robots.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from games.rebuilt import REBUILT
from games.reefscape import REEFSCAPE
from simcore.match.game import Game
from simcore.show.scope_layout import game_snapshot, scope_layout
from simcore.show.view_models import load_models

LAYOUTS = {"layout.json": 1, "layout_six.json": 6}
"""Names of the files, with their number of robots."""


def write_layouts(game: Game, output: Path) -> None:
    """Write both layouts of a game."""
    assert game.models is not None
    models = load_models(game.models)
    for name, robots in LAYOUTS.items():
        layout = scope_layout(game_snapshot(game, robots=robots), models)
        (output / name).write_text(json.dumps(layout, indent=1) + "\n", encoding="utf-8", newline="\n")
        print(output / name)


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    for game in (REBUILT, REEFSCAPE):
        assert game.models is not None
        write_layouts(game, game.models)

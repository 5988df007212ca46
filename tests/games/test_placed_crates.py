"""Game with placed pieces: pieces count equally for red and blue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from crates import CRATE, CRATES, FIELD, SYMMETRY

from simcore import play_auto
from simcore.match.game import StagedPieces
from simcore.pieces.resting_places import RestingPlace
from simcore.testing.game_laws import check_placed
from simcore.world.zones import BoxZone

_DOCK = np.array([[0.0, 4.4, 0.5], [0.5, 5.6, 0.8]])
_DOCKS = {"blue": _DOCK, "red": np.sort(SYMMETRY.flip_points(_DOCK), axis=0)}
PLACES = tuple(
    RestingPlace(name=f"{name} dock", level=f"{name.capitalize()}Dock", zone=BoxZone(*map(tuple, dock.tolist())))
    for name, dock in _DOCKS.items()
)


def staging(rng, entries):
    """Stage one crate to fetch, and one that already lies on its side on the dock."""
    lies = np.array([[0.25, 4.6, 0.5 + 0.18]])
    turned = np.array([[0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5)]])
    return [
        StagedPieces(kind=CRATE.name, positions=np.array([(3.6, 5.0, 0.12)])),
        StagedPieces(kind=CRATE.name, positions=lies, attitudes=turned, resting=True),
    ]


GAME = replace(CRATES, zones=(), places=PLACES, staging=staging, field=FIELD)


@pytest.mark.parametrize("alliance", ["blue", "red"])
def test_a_placed_crate_counts_in_addition_to_the_staged_crate(alliance):
    run = play_auto(GAME, "crate", alliance=alliance, seconds=10.0)
    with run.match as match:
        places = match.pieces.places
        assert run.report.pieces.placed == places.count(level=f"{alliance.capitalize()}Dock") == 2
        assert run.report.pieces.is_conserved and not match.pieces.awake.size
        kinds = {float(z) for z in match.pieces.state.pos[places.slots(), 2].round(2)}
        assert kinds == {0.62, 0.68}, "one upright, one on its end"


def test_the_crates_game_passes_the_public_check_of_placed_pieces():
    check_placed(GAME, "crate", seconds=8.0)

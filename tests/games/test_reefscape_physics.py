"""Coral and algae as physics moves them: on branches, dropped over everything, held by the reef, thrown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reef_trials import ALGAE, CORAL, FAR, bumped, faults, let_go, placed_share

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.field import FIELD
from games.reefscape.human_players import station_faces
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus

BATCH = 32


def places(rng: np.random.Generator, count: int) -> np.ndarray:
    """Places over reefs, stations and barge, in which pieces are in nothing [m]."""
    found: list[tuple[float, float, float]] = []
    while len(found) < count:
        what = rng.integers(3)
        if what == 0:
            turn, out = rng.uniform(0.0, math.tau), 1.1 * math.sqrt(rng.uniform())
            x, y, z = dim.REEF_CENTER[0] + out * math.cos(turn), dim.REEF_CENTER[1] + out * math.sin(turn), 2.1
        elif what == 1:
            fx, fy, yaw = station_faces("blue")[("left", "right")[rng.integers(2)]]
            out, aside = rng.uniform(-0.3, 0.6), rng.uniform(-0.9, 0.9)
            x, y = fx + out * math.cos(yaw) - aside * math.sin(yaw), fy + out * math.sin(yaw) + aside * math.cos(yaw)
            z = 2.3
        else:
            x, y, z = dim.FIELD_CENTER[0] + rng.uniform(-0.7, 0.7), rng.uniform(0.3, 7.7), 2.6
        if rng.integers(2):
            x, y = FIELD.symmetry.flip_point(x, y)
        below = [pz for px, py, pz in found if math.hypot(px - x, py - y) < 0.5]
        found.append((x, y, max([z, *(pz + 0.45 for pz in below)])))
    return np.array(found)


def test_pieces_dropped_over_everything_lie_in_nothing_and_sleep_within_ten_seconds(whole):
    """32 at a time with random attitudes and speeds, an eighth of them algae; with --whole 10,000, and `-s` prints."""
    rng = np.random.default_rng(8)
    wrong = []
    with Match(REEFSCAPE, robots=FAR) as match:
        state = match.pieces.state
        coral = np.nonzero((state.kind == CORAL) & (state.status == PieceStatus.STAGED))[0][: BATCH - BATCH // 8]
        slots = np.concatenate((coral, np.nonzero(state.kind == ALGAE)[0][: BATCH // 8]))
        for batch in range(10_000 // BATCH + 1 if whole else 1):
            attitudes = rng.standard_normal((BATCH, 4))
            attitudes /= np.linalg.norm(attitudes, axis=1)[:, None]
            match.pieces.release(slots, places(rng, BATCH), attitudes)
            match.pieces.push(slots, rng.uniform(-1.0, 1.0, (BATCH, 3)))
            for _ in range(20):
                match.play(0.5)
                if not len(match.pieces.awake):
                    break
            wrong += [f"batch {batch}: {text}" for text in faults(match, slots)]
        assert match.count.is_conserved
        awake = [text for text in wrong if "awake" in text]
        print(f"\n{batch + 1} batches of {BATCH}: {len(awake)} awake after 10 s, {len(wrong) - len(awake)} at fault")
        assert [text for text in wrong if text not in awake] == []
        assert len(awake) <= (20 if whole else 0), awake  # what rolls against something at last: one in a thousand


@pytest.mark.engines("bullet", "mujoco")
def test_a_coral_at_a_branch_stays_on_it_or_falls(whole, engine_name):
    """30 mm are free in its bore: with 23 mm aside all stay, with 51 mm none."""
    if engine_name == "mujoco" and not whole:
        pytest.skip("sampled: --whole plays on both engines")
    assert placed_share(4, 0.9 * 0.0254) == 1.0
    assert placed_share(2, 2.0 * 0.0254) == 0.0
    assert placed_share(2, tilt=math.radians(15.0)) == 0.0
    share, inward = let_go(3, 0.0, 0.0, math.radians(5.0) if engine_name == "bullet" else 0.0, 0)
    assert share == 1.0
    assert inward == pytest.approx(0.134, abs=0.003), "in, to the riser"


def test_a_robot_that_bumps_the_reef_leaves_its_coral_where_they_are(whole):
    """All that are on a branch stay, and none gets into a pipe."""
    for speed in (1.0, 2.5, 4.0) if whole else (2.5,):
        before, after, deepest = bumped(speed)
        assert before == [12, 12, 6, 6]
        assert after[:3] == [12, 12, 6] and deepest < 0.010

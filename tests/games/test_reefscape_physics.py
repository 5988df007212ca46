"""Coral and algae as physics moves them: on branches, dropped over everything, held by the reef, thrown."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reef_trials import ALGAE, CORAL, FAR, bumped, faults, laid_across, let_go, placed_share
from scipy.integrate import solve_ivp

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.field import FIELD
from games.reefscape.human_players import station_faces
from games.reefscape.pieces import ALGAE as ALGAE_KIND
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus

BATCH = 32
ANGLES = (5.0, 10.0, 15.0, 20.0, 30.0)
"""Errors of a coral's attitude [deg]."""


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


def test_algae_stay_on_the_reef_and_a_thrown_one_flies_as_the_differential_equation_says():
    gravity = 9.80665

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        air = -ALGAE_KIND.air.drag * np.linalg.norm(y[3:]) * y[3:]
        return np.concatenate((y[3:], air - np.array([0.0, 0.0, gravity])))

    with Match(REEFSCAPE, robots=FAR) as match:
        state = match.pieces.state
        on_reef = np.nonzero((state.kind == ALGAE) & (state.pos[:, 2] > 0.8))[0]
        before = state.pos[on_reef].copy()
        assert len(on_reef) == 12
        thrown = np.nonzero((state.kind == ALGAE) & (state.pos[:, 2] < 0.8))[0][:1]
        start, vel = np.array([7.0, 2.0, 1.0]), np.array([3.0, 2.0, 8.0])
        match.pieces.release(thrown, start[None])
        match.pieces.push(thrown, vel[None], flying=True)
        match.play(1.0)
        wanted = solve_ivp(rates, (0.0, 1.0), np.concatenate((start, vel)), rtol=1e-9).y[:3, -1]
        way = np.linalg.norm(wanted - start)
        assert np.linalg.norm(state.pos[thrown[0]] - wanted) < 0.03 * way
        match.play(5.0)
        assert (state.pos[on_reef] == before).all() and (state.status[on_reef] == PieceStatus.ASLEEP).all()


@pytest.mark.engines("bullet", "mujoco")
def test_a_coral_at_a_branch_stays_on_it_or_falls(whole, engine_name):
    """30 mm are free in its bore: with 23 mm aside all stay, with 51 mm none. With --whole it prints the tables."""
    if engine_name == "mujoco" and not whole:
        pytest.skip("sampled: --whole plays on both engines")
    assert placed_share(4, 0.9 * 0.0254) == 1.0
    assert placed_share(2, 2.0 * 0.0254) == 0.0
    assert placed_share(2, tilt=math.radians(15.0)) == 0.0
    share, inward = let_go(3, 0.0, 0.0, math.radians(5.0) if engine_name == "bullet" else 0.0, 0)
    assert share == 1.0
    assert inward == pytest.approx(0.134, abs=0.003), "in, to the riser"
    if whole:
        for level in (2, 3, 4):
            aside = [placed_share(level, inch * 0.0254) for inch in (0.0, 0.9, 1.1, 1.3, 2.0)]
            tilt = [placed_share(level, tilt=math.radians(angle)) for angle in ANGLES]
            down = [placed_share(level, pitch=math.radians(angle)) for angle in ANGLES]
            up = [placed_share(level, pitch=-math.radians(angle)) for angle in ANGLES]
            print(f"L{level}", *(np.round(row, 2) for row in (aside, tilt, down, up)))
            assert aside[1] == tilt[0] == down[0] == up[0] == 1.0 and aside[-1] == tilt[-1] == 0.0


def test_a_coral_across_the_end_of_a_branch_does_not_count_and_falls(whole):
    """Off balance by 30 mm it falls; in balance on an upright end it may stay, and does not count."""
    for level in (2, 3, 4) if whole else (4,):
        assert laid_across(level, 0.03) == (0, 0)
    if whole:
        assert laid_across(4, 0.0)[0] == 0


def test_a_robot_that_bumps_the_reef_leaves_its_coral_where_they_are(whole):
    """All that are on a branch stay, and none gets into a pipe."""
    for speed in (1.0, 2.5, 4.0) if whole else (2.5,):
        before, after, deepest = bumped(speed)
        assert before == [12, 12, 6, 6]
        assert after[:3] == [12, 12, 6] and deepest < 0.010


def test_algae_stay_on_the_reef_while_a_robot_drives_round_and_bumps_it(whole):
    """With --whole through the 150 s of a match."""
    with Match(REEFSCAPE, robots=FAR) as match:
        state, robot = match.pieces.state, match.robots[0]
        on_reef = np.nonzero((state.kind == ALGAE) & (state.pos[:, 2] > 0.8))[0]
        before = state.pos[on_reef].copy()
        for lap in range(75 if whole else 2):
            yaw = math.radians(dim.REEF_FACE_YAWS_DEG[lap % 6])
            out = dim.REEF_APOTHEM + 0.4 + 0.6
            x, y = dim.REEF_CENTER[0] + out * math.cos(yaw), dim.REEF_CENTER[1] + out * math.sin(yaw)
            robot.carry_to((x, y, yaw + math.pi))
            robot.drive.set_chassis_speeds((1.0, 2.0, 3.0)[lap % 3], 0.0, 0.5)
            match.play(2.0)
        assert np.abs(state.pos[on_reef] - before).max() < 0.02
        assert match.count.is_conserved

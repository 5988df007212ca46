"""Matches with scatter: exact at zero, repeatable, without loss of pieces, and equal for red and blue."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from game_table import GAMES

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.runner import play_auto
from simcore.match.scatter import Scatter

SECONDS = 1.6  # includes the first shots of autos that begin with shooting


def played(game: str, **settings):
    run = play_auto(GAMES[game], seconds=SECONDS, **settings)
    with run.match as match:
        assert match.count.is_conserved
        return run.report.digest, match.robots[0].chassis.pose, [(s.time, s.points[0]) for s in match.record.shots]


def test_zero_scatter_equals_no_scatter_and_a_seed_repeats_the_match():
    plain, none, some, again, other = (
        played("crates", seed=3, scatter=scatter)[0]
        for scatter in (None, Scatter.none(), Scatter(), Scatter(), replace(Scatter.none(), motor_kt=0.03))
    )
    assert plain == none
    assert some == again != plain
    assert other not in (plain, some)


@pytest.mark.parametrize("game", ["rebuilt", "crates"])
def test_a_red_match_is_the_flipped_blue_match_with_the_same_scatter(game):
    """One field is rotated, the other is mirrored, with sideways errors of opposite sign."""
    symmetry = GAMES[game].field.symmetry
    scatter = Scatter() if symmetry.keeps_hands else replace(Scatter.none(), start_position=0.02, start_heading=0.02)
    blue, red = (played(game, seed=4, alliance=alliance, scatter=scatter) for alliance in ("blue", "red"))
    assert symmetry.flip_pose(*blue[1]) == pytest.approx(red[1], abs=1e-3)
    assert len(blue[2]) == len(red[2])
    for (time, point), (red_time, red_point) in zip(blue[2], red[2], strict=True):
        assert red_time == pytest.approx(time)
        assert symmetry.flip_points(np.array([point]))[0] == pytest.approx(red_point, abs=2e-3)


def test_the_timing_of_a_human_player_follows_the_scatter():
    """A robot without an intake waits at a station: one coral falls every 1.1 s times the factor."""
    game = GAMES["reefscape"]
    robot = replace(game.robot(), intakes=(), placers=())
    scatter = replace(Scatter.none(), human_players=0.4)
    with Match(game, robots=(RobotEntry(config=robot, preload=0),), scatter=scatter, seed=1) as match:
        from games.reefscape.human_players import station_faces

        x, y, yaw = station_faces("blue")["right"]
        match.robots[0].carry_to((x + 0.6 * np.cos(yaw), y + 0.6 * np.sin(yaw), yaw))
        before, drops = match.rules.human_players.stock["blue"], []
        while len(drops) < 3 and match.time < 8.0:
            match.tick()
            if match.rules.human_players.stock["blue"] < before:
                before = match.rules.human_players.stock["blue"]
                drops.append(match.time)
        factor = match.draws.factor("human_players", 0)
        assert abs(factor - 1.0) > 0.1
        assert np.diff(drops) == pytest.approx(1.1 * factor, abs=0.021)

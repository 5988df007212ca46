"""CRESCENDO: every shot at a speaker comes to it on its way up, the source feeds, two notes in the amp amplify."""

from __future__ import annotations

import math

import numpy as np
import pytest
from crescendo import ALLIANCES, AMP_BOTTOM, AMP_X, CRESCENDO, HUMAN_PLAYERS, SIZE, SOURCE_CYCLE, SPEAKER, SYMMETRY
from game_table import play

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus


@pytest.mark.parametrize("auto", CRESCENDO.autos)
def test_shots_score_on_their_way_up(auto):
    shots = play("crescendo", auto).run.match.record.shots
    assert len(shots) >= 2
    for shot in shots:
        heights = np.array(shot.points)[:, 2]
        assert shot.scored and (np.diff(heights) > 0.0).all()


@pytest.mark.parametrize("alliance", ALLIANCES)
def test_a_robot_takes_a_note_from_its_source_and_scores_it(alliance):
    entry = RobotEntry(alliance=alliance, start=(14.6, 1.5, math.pi), preload=0)
    with Match(CRESCENDO, robots=[entry], options=(HUMAN_PLAYERS,)) as match:
        match.start_mode("teleop")
        waiting = match.rules.sources[alliance].stock
        match.set_controller(0, SOURCE_CYCLE(match, alliance))
        match.play(12.0)
        assert match.tracker.totals[alliance] == 2
        assert len(match.record.taken_in) == 1 and match.rules.sources[alliance].stock < waiting
        assert match.count.is_conserved


@pytest.mark.parametrize("alliance", ALLIANCES)
def test_two_notes_in_the_amp_make_four_in_the_speaker_worth_five(alliance):
    with Match(CRESCENDO, robots=[RobotEntry(alliance=alliance, preload=0)]) as match:
        match.start_mode("teleop")
        rising, zone = np.array([[0.0, 0.0, 3.0]]), match.game.zones[2 * ALLIANCES.index(alliance)]

        def send(x, y, z):
            place = np.array([[x, y, z]])
            slots = np.nonzero(match.pieces.state.status == PieceStatus.STAGED)[0][:1]
            match.pieces.release(slots, SYMMETRY.flip_points(place) if alliance == "red" else place)
            match.pieces.push(slots, rising, flying=True)
            match.play(0.1)

        assert match.rules.worth(zone) == 2
        for number in range(2):
            assert not match.rules.is_amplified(alliance)
            send(AMP_X, SIZE[1] + 0.15, AMP_BOTTOM - 0.05)
            assert match.tracker.totals[alliance] == number + 1
        assert match.rules.worth(zone) == 5
        for _ in range(4):
            send(SPEAKER[0], SPEAKER[1], SPEAKER[2] - 0.05)
        assert match.tracker.totals[alliance] == 2 + 4 * 5 and match.rules.worth(zone) == 2

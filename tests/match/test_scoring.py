"""Scoring of pieces through zones."""

import numpy as np
import pytest

from simcore.errors import ConfigError
from simcore.match.scoring import ScoringTracker, ScoringZone
from simcore.world.zones import BoxZone

BLUE = ScoringZone(name="BlueHub", alliance="blue", zone=BoxZone((0.0, 0.0, 1.0), (1.0, 1.0, 2.0)))
RED = ScoringZone(name="RedHub", alliance="red", zone=BoxZone((5.0, 0.0, 1.0), (6.0, 1.0, 2.0)), points=3)


def fall(tracker: ScoringTracker, time: float, *xs: float, up: bool = False):
    top = np.array([[x, 0.5, 3.0] for x in xs]).reshape(-1, 3)
    bottom = top - (0.0, 0.0, 2.8)
    start, end = (bottom, top) if up else (top, bottom)
    return tracker.update(time, np.arange(len(xs)) + 10, start, end)


def test_pieces_that_fall_through_a_zone_score_for_the_alliance_of_the_zone():
    tracker = ScoringTracker([BLUE, RED])
    events = fall(tracker, 0.5, 0.5, 3.0, 5.5, 0.2)
    assert [(e.slot, e.zone, e.alliance, e.points, e.time) for e in events] == [
        (10, "BlueHub", "blue", 1, 0.5),
        (13, "BlueHub", "blue", 1, 0.5),
        (12, "RedHub", "red", 3, 0.5),
    ]
    assert tracker.totals == {"blue": 2, "red": 3}
    assert tracker.pieces == {"BlueHub": 2, "RedHub": 1}


def test_a_rising_piece_scores_only_in_a_zone_that_allows_it():
    assert fall(ScoringTracker([BLUE]), 0.0, 0.5, up=True) == []
    both = ScoringZone(name="Both", alliance="blue", zone=BLUE.zone, downward=False)
    assert len(fall(ScoringTracker([both]), 0.0, 0.5, up=True)) == 1


def test_in_overlapping_zones_a_piece_counts_only_in_the_first():
    second = ScoringZone(name="Second", alliance="red", zone=BLUE.zone)
    tracker = ScoringTracker([BLUE, second])
    assert [e.zone for e in fall(tracker, 0.0, 0.5)] == ["BlueHub"]


def test_worth_is_called_per_piece_and_a_piece_without_points_still_counts():
    asked = []

    def worth(zone):
        asked.append(zone.name)
        return 2 if len(asked) < 3 else 0

    tracker = ScoringTracker([BLUE], worth=worth)
    fall(tracker, 0.5, 0.5, 0.6)
    fall(tracker, 1.5, 0.5)
    assert asked == ["BlueHub"] * 3
    assert tracker.totals["blue"] == 4 and tracker.pieces["BlueHub"] == 3
    assert [e.points for e in tracker.events] == [2, 2, 0]


def test_two_zones_with_the_same_name_are_refused():
    with pytest.raises(ConfigError, match="names must differ"):
        ScoringTracker([BLUE, BLUE])


def test_a_zone_counts_only_pieces_of_its_configured_kinds():
    crates = ScoringZone(name="Dock", alliance="blue", zone=BLUE.zone, kinds=("Crate",))
    tracker = ScoringTracker([crates], kinds=["Ball"] * 11 + ["Crate"])
    assert [event.slot for event in fall(tracker, 0.0, 0.5, 0.6)] == [11]
    with pytest.raises(ConfigError, match="no piece of kind"):
        ScoringTracker([crates], kinds=["Ball"])


def test_points_without_a_piece_are_added_and_a_reset_clears_everything():
    tracker = ScoringTracker([BLUE])
    fall(tracker, 0.0, 0.5)
    tracker.add("red", 10)
    assert tracker.totals == {"blue": 1, "red": 10}
    tracker.reset()
    assert tracker.totals == {"blue": 0, "red": 0} and tracker.events == [] and tracker.pieces == {"BlueHub": 0}

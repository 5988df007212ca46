"""Periods in which fuel counts, tower levels and pins: sentences of the 2026 game manual with their sources.

"6.4" and "6.5" are sections of the manual and tables are numbered as there; "TU" are team updates; "FMS" is Cheesy
Arena (`game/hub.go`, `field/arena.go`) where the manual is silent; "API" is FIRST's score API.
"""

import pytest
from each_case import each

from games.rebuilt.dimensions import TOWER_RUNG_HEIGHTS
from games.rebuilt.fouls import is_closed
from games.rebuilt.scoring import ALLIANCES, MATCH, UNCOUNTED, EventSettings, HubCount
from games.rebuilt.tower import tower_level
from simcore.errors import ConfigError
from simcore.match.foul_book import PinCounts

OTHER = {"blue": "red", "red": "blue"}


def hubs(winner: str | None = "blue", coin: str = "blue", **settings: bool) -> HubCount:
    """Return hubs after an auto won by an alliance; without a winner no fuel has been scored."""
    made = HubCount(coin, **settings)  # type: ignore[arg-type]
    if winner:
        made.count(winner, 5.0)  # type: ignore[arg-type]
    return made


# Blue has won auto, so blue's hub is inactive in shifts 1 and 3.
FUEL_TIMES = [
    # sentence, source, alliance, time at the sensors [s], period
    ("fuel of the last tenth of auto is auto fuel", "table 6-2", "blue", 19.9, "auto"),
    ("fuel that is processed up to 3 s after auto is auto fuel", "6.5.1", "blue", 20.1, "auto"),
    ("... just before teleop too", "6.5.1, FMS", "blue", 22.9, "auto"),
    ("... with the start of teleop it is fuel of the transition shift", "FMS", "blue", 23.1, "transition"),
    ("both hubs are active in the transition shift", "6.4", "red", 30.0, "transition"),
    (
        "grace: for 3 s after a hub went inactive its fuel counts, in the shift that ended",
        "FMS",
        "blue",
        33.1,
        "transition",
    ),
    ("... for a hub that stays active, too", "FMS", "red", 35.9, "transition"),
    ("... and no longer", "FMS", "blue", 36.0, UNCOUNTED),
    ("the alliance with more auto fuel is inactive in shift 1", "6.4", "blue", 45.0, UNCOUNTED),
    ("... and the other one active", "6.4", "red", 45.0, "shift1"),
    ("no grace after an inactive shift: the first fuel of the new one counts at once", "FMS", "blue", 58.0, "shift2"),
    ("... a tenth before it does not", "6.4", "blue", 57.9, UNCOUNTED),
    ("grace out of shift 1, of the hub that was active", "FMS", "red", 60.9, "shift1"),
    ("... and no longer", "FMS", "red", 61.0, UNCOUNTED),
    ("the other alliance is inactive in shift 2", "6.4", "red", 70.0, UNCOUNTED),
    ("hubs take turns: shift 3 is as shift 1", "6.4", "blue", 95.0, UNCOUNTED),
    ("shift 4 is as shift 2", "6.4", "blue", 120.0, "shift4"),
    ("grace into the end game is of shift 4", "FMS", "blue", 135.9, "shift4"),
    ("... a hub that was inactive counts in the end game at once", "FMS", "red", 133.0, "endgame"),
    ("both hubs are active in the end game", "6.4", "blue", 140.0, "endgame"),
    ("fuel that is in the hub as the match ends counts, for 3 s", "6.5.1", "red", 165.9, "endgame"),
    ("... and no longer", "6.5.1", "red", 166.0, UNCOUNTED),
]


@each("winner", ["blue", "red"])
@each(("sentence", "source", "alliance", "time", "period"), FUEL_TIMES)
def test_fuel_counts_in_the_periods_stated_in_the_manual(winner, sentence, source, alliance, time, period):
    made = hubs(winner)
    alliance = alliance if winner == "blue" else OTHER[alliance]
    assert made.count(alliance, time) == period, f"{sentence} ({source})"
    sheet = made.hub_score(alliance)
    assert sheet[UNCOUNTED] == (period == UNCOUNTED), "API: kept apart"
    own = int(alliance == winner)  # the fuel that won auto
    assert sheet["totalCount"] == sheet["totalPoints"] == own + (period != UNCOUNTED)
    assert sheet["teleopCount"] == (period not in ("auto", UNCOUNTED))
    if period != UNCOUNTED:
        assert sheet[f"{period}Points"] == 1 + own * (period == "auto")


def test_a_random_draw_decides_a_tie_in_auto_even_without_fuel():
    """6.4: with equal fuel FMS draws the alliance, and the draw is final."""
    for coin in ALLIANCES:
        made = hubs(None, coin)
        assert made.first_inactive == coin
        made.count("red", 5.0)
        assert made.first_inactive == "red"
        made.count("blue", 22.0)
        assert made.first_inactive == coin, "one to one is a tie again"


def test_teleop_fuel_never_changes_the_auto_leader():
    made = hubs("red")
    for _ in range(10):
        made.count("blue", 25.0)
    assert made.first_inactive == "red"


def test_the_match_lasts_two_minutes_forty_plus_a_three_second_pause():
    """Table 6-2."""
    assert MATCH.duration == 20.0 + 3.0 + 140.0
    assert [MATCH.start(f"shift {n}") for n in range(1, 5)] == [33.0, 58.0, 83.0, 108.0]
    assert MATCH.start("end game") == MATCH.duration - 30.0


@each(
    ("alliance", "time", "light"),
    [
        ("blue", 10.0, "on"), ("blue", 29.9, "on"), ("blue", 30.1, "pulsing"), ("red", 30.1, "on"),
        ("blue", 33.0, "off"), ("red", 55.1, "pulsing"), ("red", 58.0, "off"), ("blue", 105.1, "off"),
        ("red", 106.0, "pulsing"),
        ("blue", 131.0, "on"), ("blue", 159.9, "on"), ("blue", 160.1, "pulsing"), ("red", 163.0, "off"),
        ("red", 165.9, "off"), ("red", 166.0, "purple"),
    ],
)  # fmt: skip
def test_the_lights_of_a_hub_pulse_for_three_seconds_before_the_hub_goes_inactive(alliance, time, light):
    """Table 5-3."""
    assert hubs("blue").light(alliance, time) == light


def test_both_hubs_always_count_in_practice_mode():
    made = hubs("blue", practice=True)
    assert all(made.period(a, t) != UNCOUNTED for a in ALLIANCES for t in (10.0, 50.0, 75.0, 200.0))


def test_the_default_ranking_point_thresholds_are_100_360_and_50():
    assert (EventSettings().energized, EventSettings().supercharged, EventSettings().traversal) == (100, 360, 50)
    with pytest.raises(ConfigError, match="energized"):
        EventSettings(energized=-1)


RUNG, UPRIGHT = "blue_tower_rung_low", "blue_tower_upright_left"
LOW, MID, _ = TOWER_RUNG_HEIGHTS
TOWER = [
    # sentence, touched, airborne, lowest bumper [m], level
    ("level 1: off the carpet and the tower base, on a rung", [RUNG], True, 0.10, 1),
    ("... or an upright", [UPRIGHT], True, 0.10, 1),
    ("a wheel on the carpet is no level", [RUNG], False, 0.10, 0),
    ("level 2: bumpers completely above the low rung", [RUNG], True, LOW + 0.001, 2),
    ("... a millimeter under it is level 1", [RUNG], True, LOW - 0.001, 1),
    ("level 3: bumpers completely above the mid rung", [RUNG], True, MID + 0.001, 3),
    ("... a millimeter under it is level 2", [RUNG], True, MID - 0.001, 2),
    ("wall and supports of the tower may be touched as well", [RUNG, "blue_alliance_wall", "blue_tower_brace_left"],
     True, 0.3, 1),
    ("... but do not do alone", ["blue_alliance_wall"], True, 0.3, 0),
    ("nothing else may be touched", [RUNG, "blue_depot_barrier_front"], True, 0.3, 0),
    ("the tower has to be one's own", ["red_tower_rung_low"], True, 0.3, 0),
]  # fmt: skip


@each(("sentence", "touched", "airborne", "lowest", "level"), TOWER)
def test_tower_levels_follow_contacts_and_bumper_height(sentence, touched, airborne, lowest, level):
    assert tower_level("blue", touched, airborne=airborne, lowest=lowest) == level, f"{sentence} (6.5.2)"


def test_g419_a_passage_counts_as_closed_if_no_robot_fits_through():
    assert not is_closed((0.0, 1.28), []) and is_closed((0.0, 1.28), [(0.24, 1.04)])
    assert not is_closed((0.0, 1.85), [(0.0, 0.8)]) and is_closed((0.0, 1.85), [(0.0, 0.8), (1.0, 1.8)])


def pin(seconds: float, *, away: float = 0.0, gap: float = 0.0, counts: PinCounts | None = None) -> list[int]:
    """Pin robot 1 by robot 0 for a time [s], then separate them by `away` [m] for `gap` [s]; return fouls by number."""
    made, found = counts or PinCounts(), []
    for tick in range(round((seconds + gap) / 0.02)):
        here = tick < round(seconds / 0.02)
        places = {0: (2.0, 2.0), 1: (2.8 if here else 2.8 + away, 2.0)}
        found += [before for _, before in made.update(0.02, {(0, 1)} if here else set(), places)]
    return found


@each(
    ("seconds", "fouls"),
    [(2.98, []), (3.1, [0]), (9.1, [0, 1, 2])],
)
def test_g418_every_three_seconds_of_a_pin_count_as_a_foul(seconds, fouls):
    assert pin(seconds) == fouls


def test_g418_a_pin_count_ends_once_robots_are_six_feet_apart_for_three_seconds():
    counts = PinCounts()
    assert pin(2.0, away=1.9, gap=2.0, counts=counts) == [] and pin(1.2, counts=counts) == [0]
    counts = PinCounts()
    assert pin(2.0, away=1.9, gap=3.2, counts=counts) == [] and pin(1.2, counts=counts) == []
    counts = PinCounts()
    assert pin(2.0, away=0.9, gap=3.2, counts=counts) == [] and pin(1.2, counts=counts) == [0]


def test_g418_a_pin_count_ends_when_the_pinned_robot_pins_the_other():
    counts, places = PinCounts(), {0: (2.0, 2.0), 1: (2.8, 2.0)}
    for pins in [{(0, 1)}] * 100 + [{(1, 0)}] * 10:
        counts.update(0.02, pins, places)
    assert counts.seconds((0, 1)) == 0.0 and counts.seconds((1, 0)) == pytest.approx(0.2)


@pytest.mark.parametrize(
    "places", [{0: (4.0, 2.0), 1: (4.8, 2.0)}, {0: (3.0, 2.0), 1: (4.7, 2.0)}], ids=["both", "one"]
)
def test_g418_a_pin_count_ends_three_seconds_after_either_robot_leaves(places):
    """The robots stay close together, but six feet away from where the pin began."""
    for time, left in ((2.9, True), (3.1, False)):
        counts = PinCounts()
        pin(2.0, counts=counts)
        for _ in range(round(time / 0.02)):
            counts.update(0.02, set(), places)
        assert (counts.seconds((0, 1)) > 0.0) is left


def test_g418_the_three_seconds_of_separation_must_be_continuous():
    counts = PinCounts()
    pin(2.0, away=1.9, gap=2.0, counts=counts)
    counts.update(0.02, set(), {0: (2.0, 2.0), 1: (2.8, 2.0)})  # together for one tick
    pin(0.0, away=1.9, gap=2.0, counts=counts)
    assert counts.seconds((0, 1)) == pytest.approx(2.0)

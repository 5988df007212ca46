"""Shots put together from a recording: flights by ids, results, and the side of a miss."""

from dataclasses import replace

import numpy as np
import pytest
from each_case import each
from made_up_run import SCENE, flight, recorded

from simcore.show.run_events import ChangeRecord, board_now, events_of
from simcore.show.scene import Goal
from simcore.show.shots import shots_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot


def test_flights_and_results_are_found_by_their_ids() -> None:
    hit, miss = shots_of(recorded(), SCENE)
    assert (hit.scored, miss.scored, hit.robot) == (True, False, 0)
    assert (hit.time, hit.seconds) == pytest.approx((0.4, 0.2)) and (miss.time, miss.seconds) == pytest.approx(
        (0.6, 0.1)
    )
    assert hit.points == pytest.approx(np.array([flight(time, 0.4)[:3] for time in hit.times]))
    assert hit.speed == pytest.approx(np.hypot(5.0, 3.0), abs=1e-9), "the parabola's own start"
    assert (hit.distance, hit.side) == (pytest.approx(1.0), None), "to the goal in its direction"


@each(
    ("goal", "side"),
    [
        ((4.0, 3.0, 0.0), "long"),  # the flight comes down at x = 6.7
        ((9.0, 3.0, 0.0), "short"),
        ((6.7, 2.2, 0.0), "left"),
        ((6.7, 3.8, 0.0), "right"),
        ((9.0, 3.0, 5.0), "short"),  # the flight is never so high
    ],
)
def test_a_miss_has_the_side_of_the_goal_where_it_lands(goal: tuple[float, float, float], side: str) -> None:
    recording = Recording()
    results = {"Sim/NewestShots": np.array([1, 5, 0, 0])}
    for tick in range(60):
        row = flight(0.02 * tick, 0.0)
        flies = int(row[2] > -0.2)  # its last point is below the carpet, so it crosses a goal on the carpet
        poses = {"Sim/InFlight/Fuel": row[None][:flies]}
        ids = results | {"Sim/InFlightIds/Fuel": np.array([5])[:flies]}
        recording.write(Snapshot(time=0.02 * tick, tick=tick, pose_arrays=poses, integer_arrays=ids))
    (shot,) = shots_of(recording, replace(SCENE, goals=(Goal(alliance="", center=goal),)))
    assert shot.side == side


def test_an_empty_recording_has_no_shots() -> None:
    assert shots_of(Recording(), SCENE) == []


def test_shots_between_two_rows_of_a_recording_are_found_too() -> None:
    """With three rows a second, at most one row of the flights of 0.2 s and 0.1 s is kept."""
    full, thin = (shots_of(recorded(50, period=period), SCENE) for period in (0.02, 0.3))
    assert [shot.scored for shot in thin] == [shot.scored for shot in full] == [True, False]
    assert [shot.time for shot in thin] == pytest.approx([shot.time for shot in full])
    assert len(thin[1].points) == 1 < len(full[1].points)
    assert thin[0].distance == pytest.approx(full[0].distance, abs=2.0), "from where its robot was"


def test_a_shot_from_beyond_the_own_goal_that_does_not_score_is_a_pass() -> None:
    """Red's wall is at the right: a robot at x = 3 that shoots to the right is beyond a goal at x = 4."""
    hit, miss = shots_of(recorded(), replace(SCENE, goals=(Goal(alliance="red", center=(4.0, 3.0, 0.9)),)))
    assert (hit.result, miss.result, miss.side) == ("hit", "pass", None)
    _, near = shots_of(recorded(), replace(SCENE, goals=(Goal(alliance="red", center=(2.9, 3.0, 0.9)),)))
    assert near.result == "miss", "on the near side of its goal"


def test_shots_in_a_log_with_another_clock_have_the_times_of_that_clock() -> None:
    recording = Recording()
    for snapshot in recorded(50).snapshots():
        recording.write(replace(snapshot, time=snapshot.time + 100.0))
    assert [shot.time for shot in shots_of(recording, SCENE)] == pytest.approx([100.4, 100.6])


def test_events_and_board_show_modes_scores_shots_fouls_and_faults() -> None:
    """Robot 0 stops within a tick at 0.2 s, slides from 0.3 s on, and browns out at 0.5 s."""
    recording = recorded(30)
    late = Recording()
    for snapshot in recording.snapshots():
        time, pose = snapshot.time, np.array((2.0 * min(snapshot.time, 0.2), 1.0, 0.0, 1.0, 0.0, 0.0, 0.0))
        late.write(
            replace(
                snapshot,
                poses={"Sim/Robot/Pose3d": pose},
                doubles={"Sim/Robot/WheelSlip": 0.9 if 0.3 < time < 0.4 else 0.1, "Sim/Match/TimeLeft": 100.0 - time},
                booleans={
                    "Sim/Debug/BrownedOut": time > 0.5,
                    "Sim/Match/Enabled": time < 0.55,
                    "Sim/Match/GoalOpen": True,
                },
                integers={"Sim/Score/Red": int(time > 0.1)},
                strings=snapshot.strings
                | ({"Sim/Match/LastFoul": "1. G7, blue robot 0: red +6"} if time > 0.3 else {}),
            )
        )
    events = events_of(late, SCENE, shots_of(late, SCENE))
    assert [(round(event.time, 2), event.kind, event.text.split(",")[0]) for event in events] == [
        (0.02, "mode", "auto"),
        (0.1, "mode", "teleop"),
        (0.12, "score", "red +1"),
        (0.2, "bump", "bump: 2.0 m/s within a tick"),
        (0.32, "foul", "G7"),
        (0.32, "slip", "tires slide for 0.08 s"),
        (0.4, "flying", "shot"),  # not yet a hit
        (0.52, "brownout", "brownout"),
        (0.56, "mode", "teleop"),
        (0.6, "flying", "shot"),
    ]
    record = ChangeRecord()
    for snapshot in late.snapshots():
        record.take(snapshot.time, board_now(snapshot, SCENE))
    assert list(record.found) == ["period", "time left", "red", "goal open"]

    def told(label: str, time: float) -> str:
        changes = record.found[label]
        return changes["values"][max(0, np.searchsorted(changes["times"], time, side="right") - 1)]

    assert told("period", 0.58) == "teleop, disabled" and told("time left", 0.3) == "1:40"
    assert (told("red", 0.1), told("red", 0.5), told("goal open", 0.0)) == ("0", "1", "yes")


def test_a_line_of_the_board_exists_only_while_it_has_a_value() -> None:
    """A robot hangs from 0.2 s to 0.4 s; before and after, its line has no value."""
    record = ChangeRecord()
    for tick in range(30):
        time = 0.02 * tick
        level = {"Sim/Match/TowerRobot1": "Level1" if 0.19 < time < 0.39 else "None"}
        record.take(time, board_now(Snapshot(time=time, tick=tick, strings=level), SCENE))
    assert record.found == {"tower robot 1": {"times": [0.2, 0.4], "values": ["Level1", None]}}

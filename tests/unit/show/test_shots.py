"""Shots put together from what was recorded: flights by ids, results, and the side of a miss."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up_run import SCENE, flight, held, recorded

from simcore.show.run_events import board_of, events_of
from simcore.show.scene import Goal
from simcore.show.shots import intake_places, shots_of
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot


def test_flights_and_results_come_back_by_their_ids() -> None:
    hit, miss = shots_of(recorded(), SCENE)
    assert (hit.scored, miss.scored, hit.robot) == (True, False, 0)
    assert (hit.time, hit.seconds) == pytest.approx((0.4, 0.2)) and (miss.time, miss.seconds) == pytest.approx(
        (0.6, 0.1)
    )
    assert hit.points == pytest.approx(np.array([flight(time, 0.4)[:3] for time in hit.times]))
    assert hit.speed == pytest.approx(np.hypot(5.0, 3.0), abs=1e-9), "the parabola's own start"
    assert (hit.distance, hit.side) == (pytest.approx(1.0), None), "to the goal of the red robot's alliance"


@pytest.mark.parametrize(
    ("goal", "side"),
    [
        ((4.0, 3.0, 0.0), "long"),  # the flight comes down at x = 6.7
        ((9.0, 3.0, 0.0), "short"),
        ((6.7, 2.2, 0.0), "left"),
        ((6.7, 3.8, 0.0), "right"),
        ((9.0, 3.0, 5.0), "short"),  # never so high
    ],
)
def test_on_which_side_a_miss_came_down(goal: tuple[float, float, float], side: str) -> None:
    recording = Recording()
    results = {"Sim/ShotIds": np.array([5]), "Sim/ShotRobots": np.array([0]), "Sim/ShotHits": np.array([0])}
    for tick in range(60):
        row = flight(0.02 * tick, 0.0)
        flies = int(row[2] > -0.2)  # its last point is below the carpet, so that it crosses a goal on it
        poses = {"Sim/InFlight/Fuel": row[None][:flies]}
        ids = results | {"Sim/InFlightIds/Fuel": np.array([5])[:flies]}
        recording.write(Snapshot(time=0.02 * tick, tick=tick, pose_arrays=poses, integer_arrays=ids))
    (shot,) = shots_of(recording, replace(SCENE, goals=(Goal(alliance="red", center=goal),)))
    assert shot.side == side


def test_a_log_without_ids_has_no_shots_and_one_with_them_has_intakes() -> None:
    assert shots_of(Recording(), SCENE) == [] and intake_places(Recording()).shape == (0, 3)
    recording = Recording()
    lying = np.array([[2.0, 1.0, 0.1, 1.0, 0.0, 0.0, 0.0], [3.0, 1.0, 0.1, 1.0, 0.0, 0.0, 0.0]])
    for tick in range(10):
        taken = tick >= 5
        arrays = {"Sim/PieceIds/Fuel": np.array([4] if taken else [3, 4]), "Sim/HeldIds/Fuel": np.array([3] * taken)}
        poses = {"Sim/GamePieces/Fuel": lying[int(taken) :], "Sim/Held/Fuel": held(0.1)[None][: int(taken)]}
        snapshot = Snapshot(time=0.02 * tick, tick=tick, pose_arrays=poses, integer_arrays=arrays)
        recording.write(snapshot)
    assert intake_places(recording).tolist() == [[2.0, 1.0, 0.1]]


def test_events_and_board_tell_modes_scores_shots_and_troubles() -> None:
    """Robot 0 stops within a tick at 0.2 s, slides from 0.3 s on and browns out at 0.5 s."""
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
        (0.52, "brown-out", "brown-out"),
        (0.56, "mode", "teleop"),
        (0.6, "flying", "shot"),
    ]
    board = {item.label: item for item in board_of(late)}
    assert list(board) == ["period", "time left", "red", "goal open"]
    assert board["period"].at(0.58) == "teleop, disabled" and board["time left"].at(0.3) == "1:40"
    assert (board["red"].at(0.1), board["red"].at(0.5), board["goal open"].at(0.0)) == ("0", "1", "yes")

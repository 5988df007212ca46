"""Tables of a match on a page: score sheet, cycles, and seconds that add up."""

from dataclasses import replace

import numpy as np
import pytest

from simcore.show.match_tables import USES, robot_rows, tables_of, verdict
from simcore.show.run_track import RunTrack
from simcore.show.scene import RobotLook, Scene
from simcore.show.shots import ShotTrace
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

SCENE = Scene(
    field_size=(8.0, 4.0),
    robots=(
        RobotLook(alliance="blue", bumpers=(0.8, 0.8)),
        RobotLook(alliance="red", bumpers=(0.8, 0.8), prefix="Sim/Robots/1"),
    ),
)
TICKS = 500


def snapshot(tick):
    """Return a tick of 10 s: 4 s of auto, then teleop.

    Blue drives at 1 m/s from second 1 to 3; its intake is out from second 2 to 4.
    """
    time = 0.02 * (tick + 1)
    x = 1.0 + min(max(time - 1.0, 0.0), 2.0)
    return Snapshot(
        time=time,
        tick=tick,
        poses={
            "Sim/Robot/Pose3d": np.array([x, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            "Sim/Robots/1/Robot/Pose3d": np.array([6.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        },
        pose_arrays={},
        doubles={},
        integers={"Sim/Score/Blue": (time > 3.5) + 2 * (time > 7.0), "Sim/Score/Red": 5 * (time > 9.99)},
        booleans={
            "Sim/Robot/IsRed": False,
            "Sim/Robots/1/Robot/IsRed": True,
            "Sim/Match/Enabled": time < 9.0,
            "Sim/Debug/IntakeZoneActive": 2.0 < time < 4.0,
        },
        strings={"Sim/Match/Period": "auto" if time < 4.0 else "teleop <1>"},
    )


@pytest.fixture(scope="module")
def recording():
    kept = Recording()
    for tick in range(TICKS):
        kept.write(snapshot(tick))
    return kept


def shot(time, scored, robot=0):
    return ShotTrace(time=time, times=np.array([time]), points=np.zeros((1, 3)), scored=scored, robot=robot)


SHOTS = [shot(5.0, True), shot(5.4, False), shot(8.6, True), shot(3.0, False, robot=1)]


def test_shots_after_a_pause_begin_a_new_cycle(recording):
    blue, red = robot_rows(RunTrack(recording, SCENE), SHOTS)
    assert blue.cycles == ((5.0, 1, 2), (8.6, 1, 1)) and red.cycles == ((3.0, 0, 1),)
    assert (blue.hits, blue.shots, blue.alliance, red.alliance) == (2, 3, "blue", "red")


def test_each_second_counts_toward_exactly_one_activity(recording):
    blue, red = robot_rows(RunTrack(recording, SCENE), SHOTS)
    for row in (blue, red):
        assert set(row.seconds) == set(USES) and sum(row.seconds.values()) == pytest.approx(10.0)
    want = {"shooting": 1.4 + 0.9, "collecting": 2.0, "driving": 1.0, "standing": 3.7, "disabled": 1.0}
    assert blue.seconds == pytest.approx(want, abs=0.05)
    assert red.seconds["shooting"] == pytest.approx(1.0, abs=0.03) and red.seconds["driving"] == 0.0


def test_the_score_sheet_has_the_rows_of_the_game(recording):
    kept = Recording()
    for snapshot in recording.snapshots():
        rows = {"Sim/Score/Blue/hub/autoPoints": 2, "Sim/Score/Blue/foulPoints": 0}
        kept.write(replace(snapshot, integers={**snapshot.integers, **rows}))
    sheet, *_ = tables_of(RunTrack(kept, SCENE), SHOTS)
    assert sheet.rows == [["hub: auto points", "2", "0"], ["score", "3", "5"]]


def test_the_tables_of_several_robots_differ_from_those_of_a_single_robot(recording):
    scene = replace(SCENE, robots=[replace(SCENE.robots[0], role="collector:3"), SCENE.robots[1]])
    track = RunTrack(recording, scene)
    tables = {table.title.partition(" ")[0]: table for table in tables_of(track, SHOTS)}
    assert list(tables) == ["Robots,", "Cycles"] and verdict(track) == "red wins, 5 to 3"
    rows = {row[0]: row[1:] for row in tables["Robots,"].rows}
    assert rows["plays"] == ["collector:3", ""] and rows["cycles"] == ["2", "1"] and rows["alliance"] == ["blue", "red"]
    assert tables["Cycles"].rows[0] == ["robot 0", [5.0, "5 s: 1 of 2"], [8.6, "9 s: 1 of 1"]]
    alone = replace(SCENE, robots=SCENE.robots[:1])
    assert [table.title for table in tables_of(RunTrack(recording, alone), SHOTS)] == ["Shots (4)"]
    assert verdict(RunTrack(recording, alone)) == "3 points"

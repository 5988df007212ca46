"""Boards of a recorded run, computed only at ticks with changes."""

import numpy as np
import pytest

from simcore.show.run_events import (
    ChangeRecord,
    board_now,
    changing_rows,
    counts_now,
    ending_of,
    failure_of,
    lamps_now,
)
from simcore.show.scene import LevelLook, RobotLook, Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

LEVEL = LevelLook(name="L1", alliance="blue", label="level 1", places=("A", "B"))


def recorded(ticks: int) -> tuple[Recording, list[Snapshot]]:
    """Return a run and its snapshots; values on boards change every seventh tick, other values in each tick."""
    rng, run, shown = np.random.default_rng(7), Recording(bulk_period=0.02), []
    strips = [np.array([0xFF0000, 0x00FF00]), np.array([0x0000FF, -1])]
    places = [np.array([0, 0]), np.array([1, 0]), np.array([1, 2])]
    draws = rng.integers(0, 3, (ticks, 12)).tolist()
    for tick in range(ticks):
        some, time = draws[tick - tick % 7], 0.02 * (tick + 1)
        shown.append(
            Snapshot(
                time=time,
                tick=tick,
                doubles={
                    "Sim/Match/Time": time,
                    "Sim/Match/TimeLeft": 160.0 - time,
                    "Sim/Debug/BatteryVoltage": 12.0 - 0.3 * some[0],
                    "Sim/Debug/Unshown": time,
                },
                integers={
                    "Sim/Score/Blue": some[1],
                    "Sim/Score/Red": some[2],
                    "Sim/Shots": some[3],
                    "Sim/Hits": some[4],
                }
                | {"Sim/Intake/HeldCount": some[5], "Sim/Match/Count": some[6], "Sim/Performance/AwakePieces": tick},
                booleans={"Sim/Match/Enabled": some[7] > 0, "Sim/Match/BlueGoalActive": some[8] > 0},
                strings={"Sim/Match/Period": ("auto", "pause", "teleop")[some[9]], "Sim/Robot/Player": str(tick)},
                integer_arrays={"Sim/Lights/Strip/Colors": strips[some[10] // 2], LEVEL.key: places[some[11]]},
            )
        )
        run.write(shown[-1])
    return run, shown


@pytest.mark.parametrize("robots", [1, 2])
def test_the_changing_rows_alone_give_the_same_boards_as_all_snapshots(robots):
    """These rows alone give the same boards as all snapshots."""
    looks = [RobotLook(prefix=prefix, bumpers=(0.8, 0.8)) for prefix in ("Sim", "Sim/Robots/1")[:robots]]
    scene = Scene(field_size=(16.0, 8.0), robots=looks, levels=[LEVEL])
    run, shown = recorded(200)
    rows = changing_rows(run, scene)
    found = []
    for snapshots in (shown, [*run.snapshots(rows)]):
        board, lamps, cells = ChangeRecord(), ChangeRecord(), ChangeRecord()
        for one in snapshots:
            board.take(one.time, board_now(one, scene))
            lamps.take(one.time, lamps_now(one).items())
            cells.take(one.time, counts_now(one, scene).items())
        found.append((board.found, lamps.found, cells.found))
    assert found[0] == found[1]
    assert {"time left", "period", "count", "Strip", "held"} <= found[0][0].keys()
    assert len(rows) < 40  # every seventh tick, and each second


@pytest.mark.parametrize(
    ("said", "sentence"),
    [
        ("AssertionError: assert 8 >= 12\n +  where 8 = x", "got 8, wanted at least 12, at 0.04 s"),
        ("assert 2.5 == 3", "got 2.5, wanted exactly 3, at 0.04 s"),
        ("TimeoutError: not within 5 s", "TimeoutError: not within 5 s, at 0.04 s"),
        ("AssertionError: assert f(1 < 2) >= 3", "assert f(1 < 2) >= 3, at 0.04 s"),
    ],
)
def test_a_failure_is_reported_in_a_single_sentence(said, sentence):
    run = Recording()
    for tick in range(2):
        run.write(Snapshot(time=0.02 * (tick + 1), tick=tick, strings={"Sim/Failure": said} if tick else {}))
    assert failure_of(run) == sentence


def test_the_address_of_an_object_is_not_shown():
    run = Recording()
    run.write(Snapshot(time=0.02, tick=0, strings={"Sim/Failure": "where <simcore.sim.RobotTest object at 0x7f5e>.x"}))
    assert ending_of(run) == ["where RobotTest.x"]

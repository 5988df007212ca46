"""What a replay shows between two logged ticks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from simcore.show.replay import smooth_snapshot

from simcore.telemetry.log_reader import TelemetryLog, read_log
from simcore.telemetry.snapshot import Snapshot
from simcore.telemetry.wpilog import WpilogSink

KEY, IDS = "Sim/GamePieces/Ball", "Sim/PieceIds/Ball"


def logged(path: Path, *ticks: tuple[float, list[float], list[int] | None]) -> TelemetryLog:
    """A log of pieces along x: times, places, and ids if there are any."""
    with WpilogSink(path) as sink:
        for number, (time, places, ids) in enumerate(ticks):
            rows = np.zeros((len(places), 7))
            rows[:, 0], rows[:, 3] = places, 1.0
            arrays = {} if ids is None else {IDS: np.array(ids, dtype=np.int64)}
            sink.write(Snapshot(time=time, tick=number, pose_arrays={KEY: rows}, integer_arrays=arrays))
    return read_log(path)


def shown(log: TelemetryLog, time: float) -> list[float]:
    return smooth_snapshot(log, time).pose_arrays[KEY][:, 0].tolist()


def test_pieces_without_ids_go_on_in_their_rows(tmp_path: Path) -> None:
    log = logged(tmp_path / "a.wpilog", (0.0, [1.0, 2.0], None), (0.08, [1.4, 2.0], None), (0.16, [1.8], None))
    assert shown(log, 0.06) == pytest.approx([1.3, 2.0])
    assert shown(log, 0.12) == pytest.approx([1.4, 2.0]), "another number of rows: which is which is not known"


def test_pieces_with_ids_are_followed_when_others_go_and_come(tmp_path: Path) -> None:
    log = logged(
        tmp_path / "a.wpilog",
        (0.0, [1.0, 2.0, 3.0], [4, 5, 6]),
        (0.08, [3.4, 2.4, 9.0], [6, 5, 7]),
        (0.16, [3.8], [6]),
    )
    assert shown(log, 0.04) == pytest.approx([1.0, 2.2, 3.2]), "4 is gone, 5 and 6 changed their rows"
    assert shown(log, 0.12) == pytest.approx([3.6, 2.4, 9.0])


def test_a_jump_and_a_long_gap_are_not_drawn_as_a_way(tmp_path: Path) -> None:
    log = logged(tmp_path / "a.wpilog", (0.0, [1.0], [1]), (0.08, [3.0], [1]), (1.0, [3.5], [1]))
    assert shown(log, 0.04) == [1.0]
    assert shown(log, 0.5) == [3.0]

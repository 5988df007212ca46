"""The clip of the last ten seconds: so long, so fast as it was, and of one run."""

from __future__ import annotations

import io

import numpy as np
import pytest
from simcore.show.view_clip import CLIP_SECONDS, RecentSnapshots, clip

from simcore.errors import OutputError
from simcore.telemetry.snapshot import Snapshot

Image = pytest.importorskip("PIL.Image")


def snapshot(time: float) -> Snapshot:
    """Of a robot that drives along the field at 1 m/s."""
    pose = np.array((2.0 + time, 4.0, 0.0, 1.0, 0.0, 0.0, 0.0))
    return Snapshot(time=time, tick=round(time / 0.02), poses={"Sim/Robot/Pose3d": pose})


def test_the_last_ten_seconds_of_one_run_are_kept() -> None:
    recent = RecentSnapshots()
    for tick in range(1, 1000):
        if recent.due(0.02 * tick):
            recent.note(snapshot(0.02 * tick))
    kept = [one.time for one in recent()]
    assert kept[-1] > 19.9 and kept[-1] - kept[0] == pytest.approx(CLIP_SECONDS, abs=0.05)
    assert np.diff(kept) == pytest.approx(0.04), "as often as a GIF shows them"
    recent.note(snapshot(0.02))
    assert [one.time for one in recent()] == [0.02], "another run has begun"


def test_a_clip_lasts_as_long_as_what_it_shows_and_moves() -> None:
    with Image.open(io.BytesIO(clip([snapshot(0.04 * i) for i in range(51)], "a run"))) as picture:
        frames, total = [], 0.0
        for number in range(picture.n_frames):
            picture.seek(number)
            frames.append(np.asarray(picture.convert("RGB"), dtype=int))
            total += picture.info["duration"]
    assert picture.format == "GIF" and total == pytest.approx(2040.0)  # 2 s and the time of the last frame [ms]
    assert len(frames) == 51 and (np.abs(frames[-1] - frames[0]).max(axis=2) > 60).sum() > 500


def test_a_clip_of_nothing_says_so() -> None:
    with pytest.raises(OutputError, match="no tick was recorded"):
        clip([])

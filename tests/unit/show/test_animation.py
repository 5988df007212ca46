"""Frames are read back from their pixels."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_up_run import SCENE, held, places, pose, recorded
from PIL import Image
from scipy import ndimage

from simcore.errors import ConfigError, OutputError
from simcore.show import animation
from simcore.show.animation import FramePainter, animate, frame_times
from simcore.show.frames import filled
from simcore.show.palette import COLORS, rgb
from simcore.show.scene import PieceLook, Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot

LOOK = SCENE.pieces["Fuel"]
Pixels = np.ndarray[Any, np.dtype[Any]]
RED, BLUE, HIT, MISS = (COLORS[name][0] for name in ("red", "blue", "hit", "miss"))


def to_pixels(scene: Scene) -> tuple[float, float, float]:
    """Pixels per meter, and the origin's place from the left and the top."""
    below = 100.0 * scene.field_size[1]
    corners = FramePainter(Recording(), scene).points(np.array([(0.0, below), (100.0, below)]))
    (left, top), (right, _) = np.array(corners) / 2.0
    return right - left, left, top


def drawn(painter: FramePainter, recording: Recording, time: float) -> Image.Image:
    (moment,) = (one for one in filled(recording) if abs(one.time - time) < 0.001)
    return painter.draw(moment)


def is_color(frame: Image.Image, color: str, tolerance: int = 12) -> Pixels:
    return np.abs(np.asarray(frame.convert("RGB"), dtype=int) - rgb(color)).max(axis=2) <= tolerance


def blobs(mask: Pixels) -> Pixels:
    """Middles of connected pixels on the field [m], shape (n, 2)."""
    scale, left, top = to_pixels(SCENE)
    labels, count = ndimage.label(mask)
    middles = np.array(ndimage.center_of_mass(mask, labels, range(1, count + 1))).reshape(-1, 2)
    return np.column_stack(((middles[:, 1] + 0.5 - left) / scale, (top - middles[:, 0] - 0.5) / scale))


def assert_same_places(seen: Pixels, truth: Pixels, within: float) -> None:
    assert len(seen) == len(truth)
    distance = np.linalg.norm(seen[:, None, :] - truth[None, :, :], axis=2)
    assert distance.min(axis=0).max() < within and distance.min(axis=1).max() < within


@pytest.mark.parametrize("time", [0.08, 0.56, 0.96])
def test_pieces_are_where_the_state_says(time: float) -> None:
    frame = drawn(FramePainter(recorded(), SCENE), recorded(), time)
    pixel = 1.0 / to_pixels(SCENE)[0]
    truth = places(time)
    on_floor = truth[:, 2] < 0.3
    seen = np.vstack((truth[on_floor, :2], held(time)[:2]))
    assert_same_places(blobs(is_color(frame, LOOK.color)), seen, 2.0 * pixel)
    flying = blobs(ndimage.binary_opening(is_color(frame, LOOK.air_color)))
    assert_same_places(flying, truth[~on_floor, :2], 1.5 * pixel)


def test_boxes_are_drawn_turned_and_in_their_own_color() -> None:
    """Two kinds in one frame: balls as before, and crates of 0.6 x 0.2 m, one turned by 30 degrees, one on its side."""
    crate = PieceLook(size=(0.6, 0.2, 0.2), color="#11aaee")
    rows = np.zeros((2, 7))
    rows[:, :3] = (2.0, 1.0, 0.1), (6.0, 3.5, 0.3)
    rows[0, 3], rows[0, 6] = np.cos(np.pi / 12), np.sin(np.pi / 12)
    rows[1, 3], rows[1, 5] = np.cos(np.pi / 4), np.sin(np.pi / 4)  # its long edge is up
    recording = Recording()
    balls = np.array([[4.0, 1.0, 0.075, 1.0, 0.0, 0.0, 0.0]])
    arrays = {"Sim/GamePieces/Fuel": balls, "Sim/GamePieces/Crate": rows}
    recording.write(Snapshot(time=0.02, tick=0, pose_arrays=arrays))
    scene = replace(SCENE, pieces={**SCENE.pieces, "Crate": crate}, field_outlines=())
    frame = drawn(FramePainter(recording, scene), recording, 0.02)
    scale, left, top = to_pixels(scene)
    assert_same_places(blobs(is_color(frame, LOOK.color)), balls[:, :2], 1.0 / scale)
    seen = is_color(frame, crate.color)
    assert_same_places(blobs(seen), rows[:, :2], 1.5 / scale)
    y, x = np.nonzero(seen)
    points = np.column_stack(((x + 0.5 - left) / scale, (top - y - 0.5) / scale))
    flat = points[points[:, 0] < 4.0] - rows[0, :2]
    spread = np.linalg.eigh(np.cov(flat.T))
    assert np.sqrt(12.0 * spread.eigenvalues) == pytest.approx([0.2, 0.6], abs=2.5 / scale), "of a uniform rectangle"
    long = spread.eigenvectors[:, 1]
    assert abs(long @ (np.cos(np.pi / 6), np.sin(np.pi / 6))) == pytest.approx(1.0, abs=0.003)
    upright = points[points[:, 0] > 4.0]
    assert np.ptp(upright, axis=0) == pytest.approx([0.2, 0.2], abs=4.0 / scale)


def test_the_robot_is_where_the_state_says_and_looks_ahead() -> None:
    frame = drawn(FramePainter(recorded(), SCENE), recorded(), 1.0)
    mask = is_color(frame, RED)
    scale, left, top = to_pixels(SCENE)
    mask[:44] = False  # the header shows the same red, and so does the wall at the right
    mask[:, int(left + 7.8 * scale) :] = False
    middle = blobs(ndimage.binary_fill_holes(mask))
    x, y = pose(1.0)[:2]
    assert_same_places(middle, np.array([[x, y]]), 0.02)
    rows, columns = np.nonzero(mask)
    offsets = np.column_stack(((columns + 0.5 - left) / scale - x, (top - rows - 0.5) / scale - y))
    arrow = offsets[np.linalg.norm(offsets, axis=1) < 0.3]
    ahead = arrow[np.linalg.norm(arrow, axis=1).argmax()]  # its tip reaches farther than its shaft
    assert np.arctan2(ahead[1], ahead[0]) == pytest.approx(0.8, abs=0.1)


def test_score_clock_and_flights_are_drawn() -> None:
    painter = FramePainter(recorded(), SCENE, title="a title that is far too long for the place that it has " * 3)
    before, during, after = (drawn(painter, recorded(), time) for time in (0.3, 0.5, 0.7))
    assert np.any(np.asarray(before)[:44, 800:] != np.asarray(after)[:44, 800:]), "the clock"
    assert is_color(before, BLUE)[:44].sum() > 40 and not is_color(before, HIT).any()
    assert is_color(during, HIT, 40).sum() > 20
    assert is_color(after, MISS, 40).sum() > 20


def test_a_gif_has_the_same_pieces_in_every_frame(tmp_path: Path) -> None:
    path = tmp_path / "new" / "run.gif"
    animate(path, recorded(), SCENE, title="run")
    times = frame_times(0.02, 1.0)
    pixel = 1.0 / to_pixels(SCENE)[0]
    with Image.open(path) as gif:
        assert gif.n_frames == len(times) and gif.info["duration"] == 40
        for number in (0, 7, 16, gif.n_frames - 1):
            gif.seek(number)
            truth = places(times[number])
            seen = np.vstack((truth[1:, :2], held(times[number])[:2]))
            assert_same_places(blobs(is_color(gif, LOOK.color)), seen, 2.0 * pixel)


def test_a_long_run_is_shown_faster_and_says_so() -> None:
    assert len(frame_times(0.0, 160.0, 4.0)) * 0.04 == pytest.approx(40.0, abs=0.2)
    times = frame_times(0.02, 1.0)
    assert times[:4] == [0.02, 0.04, 0.08, 0.12] and times[-1] == 1.0
    assert all(b > a for a, b in pairwise(times))
    assert frame_times(0.02, 0.02) == [0.02]


def test_what_cannot_be_animated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OutputError, match=r"end in \.gif"):
        animate(tmp_path / "x.avi", recorded(2), SCENE)
    with pytest.raises(OutputError, match="no tick"):
        animate(tmp_path / "x.gif", Recording(), SCENE)
    with pytest.raises(ConfigError, match="at least 320, got 321"):
        animate(tmp_path / "x.gif", recorded(2), SCENE, width=321)
    with pytest.raises(ConfigError, match="speed"):
        animate(tmp_path / "x.gif", recorded(2), SCENE, speed=0.0)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot write the animation"):
        animate(tmp_path / "file" / "x.gif", recorded(2), SCENE)
    monkeypatch.setattr("shutil.which", lambda name: None)
    with pytest.raises(OutputError, match="ffmpeg is not installed"):
        animate(tmp_path / "x.mp4", recorded(2), SCENE)
    monkeypatch.setitem(__import__("sys").modules, "PIL", None)
    with pytest.raises(OutputError, match="pip install pillow"):
        animate(tmp_path / "x.gif", recorded(2), SCENE)


def test_an_mp4_goes_to_ffmpeg_frame_by_frame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A double in place of ffmpeg, which few machines have: it counts what it gets."""
    started: list[list[str]] = []
    start = subprocess.Popen

    def popen(command: list[str], **options: Any) -> Any:
        started.append(command)
        count = "import sys; open(sys.argv[1], 'w').write(str(len(sys.stdin.buffer.read())))"
        return start([__import__("sys").executable, "-c", count, command[-1]], **options)

    monkeypatch.setattr("shutil.which", lambda name: "/usr/bin/ffmpeg")
    monkeypatch.setattr(animation.subprocess, "Popen", popen)
    animate(tmp_path / "x.mp4", recorded(10), SCENE)
    size = started[0][started[0].index("-s") + 1]
    across, up = map(int, size.split("x"))
    assert (across, up % 2) == (960, 0)
    assert int((tmp_path / "x.mp4").read_text()) == 3 * across * up * len(frame_times(0.02, 0.2))

    def failing(command: list[str], **options: Any) -> Any:
        return start([__import__("sys").executable, "-c", "raise SystemExit('no encoder')"], **options)

    monkeypatch.setattr(animation.subprocess, "Popen", failing)
    with pytest.raises(OutputError, match=r"ffmpeg could not write .*no encoder"):
        animate(tmp_path / "y.mp4", recorded(10), SCENE)

"""Preview of a shot compared with the shot: equal flight and result."""

from __future__ import annotations

import math

import numpy as np
import pytest

from games.rebuilt import RebuiltSim
from simcore import RobotEntry
from simcore.match.match import Match
from simcore.show.shot_preview import ShotPreview


def aim(speed: float, hood: float, gate: float):
    """Return a controller that holds an exit speed [m/s], a hood angle [rad] and a feeder speed [rad/s]."""

    def controller(robot, time: float) -> None:
        shooter = robot.shooters[0].config
        for name in shooter.wheels:
            robot.mechanisms[name].velocity = shooter.wheel_speed_for(speed)
        robot.mechanisms[shooter.hood].position = hood
        for name in shooter.gate:
            robot.mechanisms[name].velocity = gate

    return controller


def distance(point, line) -> float:
    """Return the distance from a point to a polyline [m]."""
    way = np.diff(line, axis=0)
    share = np.einsum("ij,ij->i", point - line[:-1], way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-12)
    return float(np.linalg.norm(line[:-1] + np.clip(share, 0.0, 1.0)[:, None] * way - point, axis=1).min())


@pytest.mark.parametrize(
    ("start", "speed", "scores"),
    [((2.5, 4.03, 0.0), 7.2, True), ((2.5, 4.03, 0.0), 5.0, False), ((2.5, 4.03, math.pi), 7.2, False)],
)
def test_a_shot_follows_its_previewed_path(start, speed, scores) -> None:
    """Paths agree within 6 cm, as the wheels slow down in the tick of the shot; the preview includes funnel hits."""
    with RebuiltSim(robots=(RobotEntry(start=start),)) as match:
        match.set_controller(0, aim(speed, 0.75, 0.0))
        match.play(0.1)
        preview = ShotPreview(match)
        before = match.digest.hexdigest()
        aim(speed, 0.75, 0.0)(match.robots[0], 0.0)  # friction has slowed the wheels within a tick
        (path,) = preview.complete()
        assert match.digest.hexdigest() == before and match.count.is_conserved, "the match is only looked at"
        match.set_controller(0, aim(speed, 0.75, 20.0))
        while not match.record.shots:
            match.tick()
        match.set_controller(0, aim(speed, 0.75, 0.0))
        match.play(3.0)
        shot = match.record.shots[0]
    assert (path.zone == "BlueHub") == shot.scored == scores, str(path)
    assert str(path) == "scores in BlueHub, 1 point" if scores else str(path).startswith("misses, touches at x")
    flown = np.array(shot.points)
    gaps = [distance(point, flown) for point in path.points[1:-1]]
    assert max(gaps) < 0.06, gaps


def test_there_is_no_preview_without_a_shooter_or_with_slow_wheels() -> None:
    with Match.bare() as match:
        assert ShotPreview(match).complete() == []
    with RebuiltSim() as match:
        preview = ShotPreview(match)
        assert preview.complete() == []
        match.set_controller(0, aim(7.0, 0.75, 0.0))
        match.play(0.1)
        for _ in range(400):
            preview.work(0.0)
        assert len(preview.paths) == 1, "beside a run it comes bit by bit"
        match.set_controller(0, aim(0.0, 0.75, 0.0))
        match.play(0.1)
        for _ in range(400):
            preview.work(0.0)
        assert preview.paths == []

"""The watch reports odometry faults, but no errors after camera corrections, resets or moves by people."""

import logging
import math
from collections.abc import Callable, Iterator
from types import SimpleNamespace

import pytest

from simcore.robotcode.sim.belief_watch import BeliefWatch

Pose = tuple[float, float, float]
_TICK = 0.02


def _path(begin: Pose, *, speed: float = 2.0, rate: float = 0.8, ticks: int = 150) -> Iterator[Pose]:
    """Yield the pose of each tick on an arc, in the field frame [m, m, rad]."""
    x, y, yaw = begin
    for _ in range(ticks):
        yield x, y, yaw
        x, y = x + speed * _TICK * math.cos(yaw), y + speed * _TICK * math.sin(yaw)
        yaw += rate * _TICK


def _watched(
    rows: list[tuple[Pose, Pose]],
    caplog: pytest.LogCaptureFixture,
    *,
    sees: bool = False,
    why: str = "",
    disabled: int = 0,
    reset: int = -1,
) -> list[str]:
    """Return the messages about a run with these believed and true poses, without wheel slip.

    The robot is disabled for the first ticks, and in one tick the program sets its pose.
    """
    robot = SimpleNamespace(number=0, chassis=SimpleNamespace(), odometry=SimpleNamespace())
    watch = BeliefWatch(robot, sees=lambda: sees, why_still=lambda: why)  # type: ignore[arg-type]
    for tick, (believed, true) in enumerate(rows):
        robot.estimated_pose = robot.believed_pose = believed
        robot.chassis.pose = robot.odometry.pose = true
        if tick == reset:
            watch.note_reset()
        watch.after_tick(is_driving=tick >= disabled)
    return [record.getMessage() for record in caplog.records if record.name.startswith("simcore")]


def _seen_in_steps(believed: Pose, true: Pose, share: float) -> Pose:
    return tuple(b + share * (t - b) for b, t in zip(believed, true, strict=True))  # type: ignore[return-value]


BEGIN = (2.0, 4.0, 0.0)
RED = (14.0, 4.0, math.pi)
TRUTH = list(_path(BEGIN))
PLACED = [*list(_path(BEGIN, ticks=50)), *_path((4.0, 4.0, -1.2), ticks=100)]
STANDS = [BEGIN] * 30

GOOD: dict[str, tuple[list[tuple[Pose, Pose]], bool]] = {
    "it holds": ([(p, p) for p in TRUTH], False),
    "its meters are a tenth long": ([((1.1 * p[0], 1.1 * p[1], p[2]), p) for p in TRUTH], False),
    "it begins elsewhere": (list(zip(_path((0.0, 0.0, 1.0)), TRUTH, strict=True)), False),
    "cameras bring it in steps": (
        [(_seen_in_steps((7.0, 1.0, 1.0), p, 1 - 0.97**k), p) for k, p in enumerate(TRUTH)], True),
    "cameras bring it while it stands": (
        [(_seen_in_steps((7.0, 1.0, 3.0), BEGIN, 1 - 0.9**k), BEGIN) for k in range(90)], True),
    "it is placed with another heading": ([*[(p, p) for p in PLACED[:50]], *zip(
        _path(PLACED[49], ticks=100), _path((*PLACED[49][:2], -1.2), ticks=100), strict=True)], False),
    "its gyro is zeroed while it stands": (
        [*[((*p[:2], 1.0), p) for p in STANDS], *zip(_path((*BEGIN[:2], -0.6)), TRUTH, strict=True)], False),
}  # fmt: skip

FAULTS: dict[str, tuple[Callable[[int, Pose], Pose], str]] = {
    "it stays": (lambda k, p: BEGIN, "Its pose hardly moves"),
    "its meters are long": (
        lambda k, p: (2.0 + 1.5 * (p[0] - 2.0), 4.0 + 1.5 * (p[1] - 4.0), p[2]), "It counts 1.5 m for each meter"),
    "its meters are long, and it is set beside once": (
        lambda k, p: (2.0 + 1.5 * (p[0] - 2.0), 4.0 + 1.5 * (p[1] - 4.0) + 0.35 * (k > 10), p[2]),
        "It counts 1.5 m for each meter"),
    "its heading turns too far": (lambda k, p: (*p[:2], 1.5 * p[2]), "Its heading turns 1.5 times as far"),
    "its heading turns against the truth": (
        lambda k, p: (p[0], 8.0 - p[1], -p[2]), "gyro_upside_down = true under [drivetrain]"),
}  # fmt: skip


@pytest.mark.parametrize("name", GOOD)
def test_nothing_is_reported_while_the_odometry_is_right(name, caplog):
    rows, sees = GOOD[name]
    assert _watched(rows, caplog, sees=sees) == []


@pytest.mark.parametrize("sees", [False, True], ids=["blind", "with cameras"])
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_reported_once_with_its_cause(name, sees, caplog):
    believed, cause = FAULTS[name]
    said = _watched([(believed(k, p), p) for k, p in enumerate(TRUTH)], caplog, sees=sees)
    assert len(said) == 1 and cause in said[0]


SIDEWAYS: dict[str, tuple[float, Callable[[int, Pose], Pose], str]] = {
    "left is right": (8.0, lambda k, p: (p[0], 8.0 - p[1], 0.0), "It has left and right swapped"),
    "it zigzags": (
        0.0,
        lambda k, p: (1.0 + 0.5 * p[0], p[1] + 0.1 * (-1) ** k, 0.0),
        "Its pose moves in other directions",
    ),
    "aside": (0.0, lambda k, p: (p[0], p[1] + 0.7 * (p[0] - 2.0), 0.0), "Its pose moves 35 deg away from"),
}


@pytest.mark.parametrize("name", SIDEWAYS)
def test_a_fault_at_constant_heading_is_reported_with_its_cause(name, caplog):
    rate, believed, cause = SIDEWAYS[name]
    there = [(x, y, 0.0) for x, y, _ in _path(BEGIN, rate=rate)]
    said = _watched([(believed(k, p), p) for k, p in enumerate(there)], caplog)
    assert len(said) == 1 and cause in said[0]


def test_errors_while_disabled_or_after_a_reset_or_camera_correction_are_not_faults(caplog):
    assert _watched([(BEGIN, p) for p in TRUTH], caplog, disabled=len(TRUTH)) == []
    elsewhere = [*TRUTH[:78], *list(_path((10.0, 1.0, 2.0)))[78:]]  # three ticks after the request
    assert _watched(list(zip(elsewhere, TRUTH, strict=True)), caplog, reset=75) == []
    seen = [_seen_in_steps((7.0, 1.0, 2.5), p, 1 - 0.9**k) for k, p in enumerate(TRUTH)]
    (said,) = _watched([(seen[min(k, 75)], p) for k, p in enumerate(TRUTH)], caplog, sees=True)
    assert "it says that robot 0 moved" in said


def test_a_pose_without_updates_is_reported(caplog):
    caplog.set_level(logging.WARNING)
    said = _watched([((0.0, 0.0, 0.0), p) for p in _path(RED)], caplog, why="Nothing updates it in simulation")
    assert len(said) == 1 and "Nothing updates it in simulation" in said[0] and "encoders" not in said[0]

"""Shots of a run: flights, results, and the side of the goal on which a shot missed."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from simcore.show.scene import Goal, Scene
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import robot_prefix
from simcore.typing import FloatArray
from simcore.units import GRAVITY, TICK

__all__ = ["MISS_SIDES", "MissSide", "ShotResult", "ShotTrace", "shot_rows", "shots_of"]

MissSide = Literal["short", "long", "left", "right"]
ShotResult = Literal["hit", "miss", "pass", "flying"]
MISS_SIDES: tuple[MissSide, ...] = ("short", "long", "left", "right")
_BEYOND = 0.3  # [m]; a shot from this far beyond the goal that does not score is a pass


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotTrace:
    """Shot of one piece, with the recorded part of the flight up to the first contact."""

    time: float
    """Time at which the piece left the robot [s]."""
    times: FloatArray
    """Times of the recorded part of the flight [s], shape (n,), not empty."""
    points: FloatArray
    """Center of the piece at `times`, field frame [m], shape (n, 3)."""
    scored: bool
    is_over: bool = True
    """Whether the piece scored or touched something before the end of the run."""
    robot: int = 0
    """Number of the robot that shot the piece."""
    piece: int = 0
    """Id of the piece."""
    is_pass: bool = False
    """Whether the shot was a pass: launched from beyond the goal of the robot's alliance, and without a score."""
    side: MissSide | None = None
    """Side of the goal on which the shot missed, as seen from the robot; None for other shots or without a goal."""
    distance: float = math.nan
    """Horizontal distance from the launch to the goal, or to the first contact if the goal is unknown [m].

    NaN while the piece is in flight.
    """

    @property
    def result(self) -> ShotResult:
        """Result of the shot: `hit`, `miss`, `pass`, or `flying` if the run ended first."""
        return "hit" if self.scored else "flying" if not self.is_over else "pass" if self.is_pass else "miss"

    @property
    def seconds(self) -> float:
        """Time of flight until the first contact [s]."""
        return float(self.times[-1] - self.time)

    @property
    def speed(self) -> float:
        """Launch speed relative to the ground, averaged over the first tick and corrected for gravity [m/s].

        NaN if the recorded flight has only one point.
        """
        if len(self.times) < 2:
            return math.nan
        dt = float(self.times[1] - self.times[0])
        x, y, z = ((self.points[1] - self.points[0]) / dt).tolist()
        return math.hypot(x, y, z + 0.5 * GRAVITY * dt)


@dataclass(slots=True)
class _Flight:
    times: list[float] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)


def shots_of(recording: Recording, scene: Scene) -> list[ShotTrace]:
    """Return all shots of a recording in order of time."""
    hits = {shot for _, (_, shot) in recording.events("Sim/NewestHits")}
    flights = _flights(recording)
    shots: list[ShotTrace] = []
    times = recording.times
    left = sorted(recording.events("Sim/NewestShots"), key=lambda event: event[1][-1])
    for at, (number, piece, robot, tick) in reversed(left):
        hit, row = number in hits, int(np.searchsorted(times, at))
        before = times[row - 1] if row else -math.inf
        # With a log by another clock than the match's, only the rows before and after the shot are known
        time = tick * TICK if before < tick * TICK <= at + 1e-6 else at
        mine = flights[piece]
        flight = mine.pop() if mine and mine[-1].times[0] > time - 1e-6 else _Flight()
        while mine and mine[-1].times[0] > time - 1e-6:
            flight = mine.pop()
        if not flight.times:  # the whole flight was between two rows, near the robot
            flight.times.append(time)
            flight.points.append(_place_of(recording, robot, time))
        is_over = hit or flight.times[-1] < times[-1] - 1e-6
        shots.append(_trace(scene, time, flight, hit, is_over, robot, piece))
    return shots[::-1]


def _place_of(recording: Recording, robot: int, time: float) -> FloatArray:
    """Return the last position of a robot that was recorded at or before a time [s], field frame [m], shape (3,)."""
    times, rows = recording.poses(f"{robot_prefix(robot)}/Robot/Pose3d")
    place: FloatArray = rows[max(int(np.searchsorted(times, time + 1e-9)) - 1, 0), :3]
    return place


def _flights(recording: Recording) -> dict[int, list[_Flight]]:
    """Return the flights of each piece in order of time, by id of the piece."""
    found: dict[int, list[_Flight]] = defaultdict(list)
    for key in recording.keys:
        if not key.startswith("Sim/InFlightIds/"):
            continue
        poses = key.replace("InFlightIds", "InFlight")
        flying: dict[int, _Flight] = {}
        for time, ids in recording.integers(key):
            rows = recording.array_at(poses, time)
            before, flying = flying, {}
            for piece, row in zip(ids.tolist(), rows, strict=False):
                flight = before.get(piece)
                if flight is None:
                    flight = _Flight()
                    found[piece].append(flight)
                flight.times.append(time)
                flight.points.append(row[:3])
                flying[piece] = flight
    return found


def _trace(
    scene: Scene, time: float, flight: _Flight, scored: bool, is_over: bool, robot: int, piece: int
) -> ShotTrace:
    points = np.array(flight.points)
    goal = _goal_of(scene, points, robot) if is_over else None
    target = points[-1] if goal is None else np.array(goal.center)
    is_pass = goal is not None and not scored and _is_beyond(scene, goal, robot, float(points[0, 0]))
    return ShotTrace(
        time=time,
        times=np.array(flight.times),
        points=points,
        scored=scored,
        is_over=is_over,
        robot=robot,
        piece=piece,
        is_pass=is_pass,
        side=None if scored or goal is None or is_pass else _side(points, target),
        distance=float(np.linalg.norm(target[:2] - points[0, :2])) if is_over else math.nan,
    )


def _goal_of(scene: Scene, points: FloatArray, robot: int) -> Goal | None:
    """Return the goal of the robot's alliance that is nearest to the direction of a shot.

    If the alliance has no goal, consider all goals. For a shot without a direction, return the goal nearest to the
    start of the shot. Without goals, return None.
    """
    alliance = scene.robots[robot].alliance if robot < len(scene.robots) else ""
    goals = [goal for goal in scene.goals if goal.alliance == alliance] or list(scene.goals)
    ahead = points[-1, :2] - points[0, :2]

    def aside(goal: Goal) -> tuple[float, float]:
        to_goal = np.array(goal.center[:2]) - points[0, :2]
        distance = float(np.linalg.norm(to_goal))
        return -float(to_goal @ ahead) / max(distance, 1e-9), distance

    return min(goals, key=aside, default=None)


def _is_beyond(scene: Scene, goal: Goal, robot: int, x: float) -> bool:
    """Return whether x [m] is more than 0.3 m farther from the alliance wall than the goal of the robot's alliance."""
    alliance = scene.robots[robot].alliance if robot < len(scene.robots) else ""
    way = {"blue": x - goal.center[0], "red": goal.center[0] - x}.get(alliance, -1.0)
    return goal.alliance == alliance and way > _BEYOND


def _side(points: FloatArray, goal: FloatArray) -> MissSide:
    """Return the side of the goal on which a miss passed the goal center, as seen from the robot.

    The side is that of the point where the piece last fell below the goal's height, or of the last point of the path.
    """
    ahead = goal[:2] - points[0, :2]
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    place = points[-1, :2]
    falls = np.nonzero((points[:-1, 2] >= goal[2]) & (points[1:, 2] < goal[2]))[0]
    if len(falls):
        a, b = points[falls[-1]], points[falls[-1] + 1]
        place = a[:2] + (a[2] - goal[2]) / (a[2] - b[2]) * (b[:2] - a[:2])
    off = place - goal[:2]
    along, left = float(off @ ahead), float(ahead[0] * off[1] - ahead[1] * off[0])
    if abs(along) >= abs(left):
        return "long" if along > 0.0 else "short"
    return "left" if left > 0.0 else "right"


def shot_rows(shots: Sequence[ShotTrace], robots: int) -> list[tuple[str, list[str]]]:
    """Return table rows about the shots of a run: a label, and one value for each robot."""
    of_each = [[shot for shot in shots if shot.robot == number] for number in range(robots)]

    def span(values: list[float], unit: str, digits: int) -> str:
        real = [value for value in values if math.isfinite(value)]
        if not real:
            return "-"
        low, high = f"{min(real):.{digits}f}", f"{max(real):.{digits}f}"
        return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"

    rows = [
        ("shots", [str(len(mine)) for mine in of_each]),
        ("hits", [_share([shot for shot in mine if shot.scored], _tried(mine)) for mine in of_each]),
        ("distance to the goal", [span([shot.distance for shot in mine], "m", 2) for mine in of_each]),
        ("exit speed", [span([shot.speed for shot in mine], "m/s", 1) for mine in of_each]),
        ("time of flight", [span([shot.seconds for shot in mine if shot.is_over], "s", 2) for mine in of_each]),
    ]
    endings: list[tuple[str, ShotResult, MissSide | None]] = [(f"missed {side}", "miss", side) for side in MISS_SIDES]
    endings += [
        ("missed, no goal known", "miss", None),
        ("passed on", "pass", None),
        ("flying at the end", "flying", None),
    ]
    for name, result, side in endings:
        counts = [len([shot for shot in mine if (shot.result, shot.side) == (result, side)]) for mine in of_each]
        if side is not None or any(counts):
            rows.append((name, [str(count) for count in counts]))
    return rows


def _tried(shots: Sequence[ShotTrace]) -> list[ShotTrace]:
    """Return the shots that are not passes."""
    return [shot for shot in shots if shot.result != "pass"]


def _share(part: Sequence[object], whole: Sequence[object]) -> str:
    return f"{len(part)} ({100.0 * len(part) / len(whole):.0f} %)" if whole else "0"

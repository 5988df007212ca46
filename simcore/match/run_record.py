"""Record of a run: shots, pieces taken in, placements, driven distances, a digest of all states, and tick times.

A match writes the record. Reports, sweep rows and telemetry (for logs, pages and layouts) read the same record, so that
all counts agree.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from simcore.match.scoring import ScoreEvent
from simcore.match.shortfalls import Shortfalls
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.pool import ON_FIELD, PieceStatus
from simcore.robot.battery import Battery
from simcore.robot.robot import Robot
from simcore.typing import Alliance, IntArray
from simcore.world.symmetry import Pose

__all__ = [
    "PieceCount",
    "Placement",
    "RobotRecord",
    "RunRecord",
    "ShotRecord",
    "TakenIn",
    "TickTimes",
    "TrajectoryDigest",
]


class TrajectoryDigest:
    """SHA-256 digest of the states of a run; two runs with equal digests have the same states to the last bit.

    >>> one, two = TrajectoryDigest(), TrajectoryDigest()
    >>> one.update(np.array([0.0, 1.0]))
    >>> two.update(np.array([-0.0, 1.0]))
    >>> one.hexdigest() == two.hexdigest()
    True
    """

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def update(self, *arrays: npt.NDArray[Any]) -> None:
        """Add arrays to the digest, e.g. the state of a tick; the order of the arrays changes the digest.

        Arrays may have any number type. The digest includes the shape of each array. The method hashes values as
        little-endian float64, so that the digest is the same on all computers, and hashes -0.0 as 0.0, because the sign
        of a zero sum is accidental.
        """
        for array in arrays:
            # Adding +0.0 turns -0.0 into 0.0, changes nothing else and makes the copy that is hashed.
            values = np.asarray(array, dtype="<f8") + 0.0
            self._hash.update(f"{values.shape}".encode())
            self._hash.update(values.astype("<f8", copy=False).tobytes())

    def hexdigest(self) -> str:
        """Return the current digest as 64 hexadecimal digits; further updates are possible."""
        return self._hash.hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class TickTimes:
    """Median, percentiles and maximum of the wall time per tick [ms]; all values are 0 without ticks."""

    median: float
    p95: float
    p99: float
    max: float

    @classmethod
    def of(cls, seconds: Sequence[float]) -> TickTimes:
        """Compute the statistics from the wall time of each tick [s]."""
        median, p95, p99, worst = np.percentile(1e3 * np.array(seconds or [0.0]), [50.0, 95.0, 99.0, 100.0]).tolist()
        return cls(median=median, p95=p95, p99=p99, max=worst)


_ASLEEP, _ON_FIELD = int(PieceStatus.ASLEEP), frozenset(map(int, ON_FIELD))
_DRAWN = 100  # least number of ticks of a shot's path that are kept
_PERSON = -1  # robot number of a human player's throw
_LIES = 0.01  # [m]; a piece whose lowest point is this close to the carpet lies on the carpet
_SHOWN = 1.0  # [s] for which an event counts as new; sinks with longer periods miss some events


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceCount:
    """Number of pieces by status; the sum of all other fields is `staged`."""

    staged: int
    """Number of all pieces staged so far, on or off the field, including preloads."""
    on_field: int
    in_flight: int
    held: int
    scored: int
    placed: int = 0
    """Number of pieces at rest in the game's resting places, not included in `on_field`."""
    off_field: int
    """Number of staged pieces off the field that have not scored, e.g. with a human player."""

    @classmethod
    def of(cls, pieces: GamePieceManager) -> PieceCount:
        """Count the pieces of a match by status."""
        count = pieces.count
        return cls(
            staged=pieces.total,
            on_field=count(PieceStatus.ASLEEP) + count(PieceStatus.AWAKE),
            in_flight=count(PieceStatus.IN_FLIGHT),
            held=count(PieceStatus.HELD),
            scored=count(PieceStatus.SCORED),
            placed=count(PieceStatus.PLACED),
            off_field=count(PieceStatus.STAGED),
        )

    @property
    def is_conserved(self) -> bool:
        """Whether the numbers of pieces by status add up to `staged`."""
        somewhere = self.on_field + self.in_flight + self.held + self.scored + self.placed + self.off_field
        return somewhere == self.staged


@dataclass(slots=True)
class ShotRecord:
    """Record of one shot, from the release until the piece scores, is taken in or comes to rest on the carpet."""

    time: float
    """Simulated time at the end of the tick in which the piece left the muzzle [s]."""
    number: int
    """Number of the shot, from 1; 0 for a throw by a human player."""
    slot: int
    robot: int
    points: list[tuple[float, float, float]]
    """Path of the piece, field frame [m].

    The path has a point per tick for at least 2 s and until the first contact, and then the point where the piece
    scored, if it scored.
    """
    scored: bool = False


class Hit(NamedTuple):
    """Score of a shot: time, and number of the shot."""

    time: float
    """Simulated time at which the shot scored [s]."""
    shot: int
    """Number of the shot."""


@dataclass(frozen=True, slots=True)
class TakenIn:
    """Piece that an intake or a placer of a robot has taken in, with time and position."""

    time: float
    """Simulated time at which the robot took in the piece [s]."""
    slot: int
    robot: int
    place: tuple[float, float, float]
    """Position of the piece, field frame [m]."""


@dataclass(frozen=True, slots=True)
class Placement:
    """Placement of a robot: at the start of the run, by the drive team, or by a reset of the robot."""

    time: float
    """Simulated time of the placement [s]."""
    pose: Pose
    """Pose of the robot after the placement, field frame [m, m, rad]."""
    reason: str
    """`start`, `carried` by the drive team with an unchanged gyro reading, or `reset` of the whole robot."""


_Event = TypeVar("_Event", bound="ShotRecord | Hit | TakenIn")


class RobotRecord:
    """Record of one robot since the start of the run: placements, driven distance and shortfalls."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._place = robot.chassis.pose[:2]
        self.player = ""
        """Role and level of the robot's scripted player, e.g. `collector:3`; empty without a role."""
        self.distance = 0.0
        """Distance driven since the start of the run, without moves by the drive team [m]."""
        self.placements = [Placement(0.0, robot.chassis.pose, "start")]
        """Placements of the robot in order of time, with the start pose as the first."""
        self.forget_pieces()

    def forget_pieces(self) -> None:
        """Replace the monitor of the robot's intakes and shooters with a new monitor, which discards all shortfalls."""
        self.shortfalls = Shortfalls(self._robot)
        """Monitor that finds the reasons why the robot took in or shot no pieces."""

    @property
    def battery(self) -> Battery:
        """Battery of the robot, with the lowest voltage and the numbers of brownouts and resets in this run."""
        return self._robot.battery

    def put(self, time: float, reason: str) -> None:
        """Record a placement of the robot at the current pose, with time [s] and reason as in `Placement`."""
        pose = self._robot.chassis.pose
        self._place = pose[:2]
        self.placements.append(Placement(time, pose, reason))

    def after_tick(self, time: float) -> None:
        """Add the distance driven in the tick that ends at `time` [s], and check the intakes and shooters."""
        self.shortfalls.after_tick(time)
        x, y, _ = self._robot.chassis.pos
        self.distance += math.hypot(x - self._place[0], y - self._place[1])
        self._place = x, y


@dataclass(frozen=True, slots=True)
class RecordColumns:
    """Newest events for telemetry, in flat, read-only arrays.

    Each array has a row for the newest event and for each event in the last second before the newest event.
    """

    shots: IntArray
    """Number, slot, robot number, and number of the tick after which the piece has left, per shot, shape (4 n,)."""
    hits: IntArray
    """Hit number and shot number for each shot that has scored, shape (2 n,)."""
    taken_in: IntArray
    """Number of the event, and x and y of the piece, field frame [mm], for each piece taken in, shape (3 n,)."""


class RunRecord:
    """Record of one run of a match, available as `Match.record`.

    Args:
        pieces: Pieces of the match.
        robots: Robots of the match, at their start poses.
        tick: Length of a tick [s].
    """

    def __init__(self, pieces: GamePieceManager, robots: Sequence[Robot], tick: float) -> None:
        self._pieces = pieces
        self._tick = tick
        self.time = 0.0
        """Simulated time at the end of the last tick [s]."""
        self.robots = [RobotRecord(robot) for robot in robots]
        """Records of the robots, by number."""
        self.failure = ""
        """Reason why a test of this run failed; empty without a failure or a test."""
        self.warnings: list[str] = []
        """Warnings during a test of this run, followed by the shortfalls at the end of the run."""
        self.forget_pieces()

    def forget_pieces(self) -> None:
        """Clear the records of shots, pieces taken in and placed, and human players' points."""
        self.shots: list[ShotRecord] = []
        """Shots of all robots, oldest first."""
        self.taken_in: list[TakenIn] = []
        """Pieces that robots have taken in, oldest first."""
        self.put_down = 0
        """Number of pieces that placers have released."""
        self.human_points: dict[Alliance, int] = {"blue": 0, "red": 0}
        """Points for human players' throws, by alliance that receives the points."""
        for robot in self.robots:
            robot.forget_pieces()
        self._followed: dict[int, ShotRecord] = {}
        self._hits: list[Hit] = []
        self._columns: RecordColumns | None = None

    # --- events -----------------------------------------------------------------------------------------------------

    def after_tick(self, time: float) -> None:
        """Add driven distances, check intakes and shooters, and extend the paths of shots at the end of a tick.

        Args:
            time: Simulated time at the end of the tick [s].
        """
        self.time = time
        for robot in self.robots:
            robot.after_tick(time)
        if not self._followed:
            return
        slots, state, types = list(self._followed), self._pieces.state, self._pieces.types
        rows = zip(
            *(slots, state.pos[slots].tolist(), state.status[slots].tolist(), state.kind[slots].tolist()),
            self._pieces.is_untouched[slots].tolist(),
            strict=True,
        )
        for slot, (x, y, z), status, kind, is_untouched in rows:
            shot = self._followed[slot]
            if is_untouched or len(shot.points) <= _DRAWN:
                shot.points.append((x, y, z))
            lies = status == _ASLEEP and z < types[kind].rest_height + _LIES
            if status not in _ON_FIELD or (lies and not is_untouched):
                del self._followed[slot]

    def note_shot(self, slot: int, robot: int, pos: tuple[float, float, float]) -> None:
        """Record a shot, and follow the path of the piece.

        Args:
            slot: Slot of the piece.
            robot: Number of the robot.
            pos: Position of the piece at the end of the tick, field frame [m].
        """
        shot = ShotRecord(self.time, len(self.shots) + 1, slot, robot, [pos])
        self.shots.append(shot)
        self.robots[robot].shortfalls.note_shot()
        self._followed[slot] = shot
        self._columns = None

    def note_thrown(self, slot: int) -> None:
        """Follow a piece that a human player has thrown; the throw does not count as a shot."""
        self._followed[slot] = ShotRecord(self.time, 0, slot, _PERSON, [])

    def note_scored(self, event: ScoreEvent) -> None:
        """Record that a piece has scored.

        If a robot has shot the piece, the shot counts as a hit. If a human player has thrown the piece, the points
        count as points of human players.
        """
        shot = self._followed.pop(event.slot, None)
        if shot is not None and shot.robot == _PERSON:
            self.human_points[event.alliance] += event.points
        elif shot is not None:
            shot.scored = True
            self._hits.append(Hit(self.time, shot.number))
            if (place := tuple(self._pieces.state.pos[event.slot].tolist())) != tuple(shot.points[-1]):
                shot.points.append(place)  # the piece flew on after the recorded points
            self._columns = None

    def note_taken_in(self, slots: IntArray, robot: int) -> None:
        """Record time and position of each piece that a robot has taken in."""
        for slot, (x, y, z) in zip(slots.tolist(), self._pieces.state.pos[slots].tolist(), strict=True):
            self.taken_in.append(TakenIn(self.time, slot, robot, (x, y, z)))
        self._columns = None

    # --- results ----------------------------------------------------------------------------------------------------

    @property
    def shortfalls(self) -> list[str]:
        """Sentences about robots that took in or shot no pieces, and about pose estimates that are over 0.5 m wrong."""
        found = []
        for number, robot in enumerate(self.robots):
            taken_in = len([taken for taken in self.taken_in if taken.robot == number])
            whose = f"robot {number}, " if len(self.robots) > 1 else ""
            found += [f"{whose}{line}" for line in robot.shortfalls.lines(taken_in=taken_in)]
        return found

    def conclude(self) -> bool:
        """Append new shortfalls to `warnings`; return whether there are new shortfalls."""
        new = [line for line in self.shortfalls if line not in self.warnings]
        self.warnings.extend(new)
        return bool(new)

    @property
    def hits(self) -> int:
        """Number of shots that scored."""
        return len(self._hits)

    @property
    def flying(self) -> IntArray:
        """Slots of the pieces that robots have shot and that have not touched anything since, oldest shot first."""
        untouched = self._pieces.is_untouched
        flying = [slot for slot, shot in self._followed.items() if untouched[slot] and shot.robot != _PERSON]
        return np.array(flying, dtype=np.int64)

    @property
    def columns(self) -> RecordColumns:
        """Newest events for telemetry; the property returns the same object until the next event."""
        if self._columns is None:
            self._columns = RecordColumns(
                shots=_newest(self.shots, lambda shot: (shot.slot, shot.robot, round(shot.time / self._tick))),
                hits=_newest(self._hits, lambda hit: (hit.shot,)),
                taken_in=_newest(self.taken_in, lambda one: (round(1e3 * one.place[0]), round(1e3 * one.place[1]))),
            )
        return self._columns


def _newest(events: Sequence[_Event], row: Callable[[_Event], tuple[int, ...]]) -> IntArray:
    """Return number and row of each event in the last second before the newest event, in one flat read-only array."""
    first = len(events)
    while first and events[first - 1].time > events[-1].time - _SHOWN - 1e-6:
        first -= 1
    rows = [(number, *row(event)) for number, event in enumerate(events[first:], first + 1)]
    column = np.array(rows, np.int64).ravel()
    column.setflags(write=False)
    return column

"""Frames: rows of 16-bit numbers that the player draws.

The page of a recording contains all frames. A live run sends single frames. A frame has four groups of columns, and
each group has separate times:

- `robots`: for each robot, position `x, y, z` [mm] and quaternion `w, x, y, z` [1/32767], estimated position `x, y`
  [mm] and yaw [0.1 mrad], and 1 while the intake is active. An unknown position is `AWAY`.
- `parts`: for each moving part of each robot, a pose in the robot frame; the quaternion of a missing part is zero.
- `pieces`: for each piece, position `x, y, z` [mm] and state: 0 absent, 1 on the field, 2 in flight, 3 + k in robot k.
  Positions of pieces in a robot are in the robot frame. Kinds that are not balls also have a quaternion.
- `lines`: corners of camera lines, `x, y, z` [mm].

`simcore/show/player/data.js` reads the frames.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from simcore.show.scene import PLAIN_PIECE, PieceLook, Scene
from simcore.show.solids import RobotSolids
from simcore.telemetry.columns import Table
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import multiply, rotate_back

__all__ = [
    "AWAY",
    "HELD",
    "IN_FLIGHT",
    "FrameLayout",
    "PieceKind",
    "Rows",
    "hanging_kinds",
    "kind_look",
    "pack",
    "piece_kinds",
]

Rows = npt.NDArray[np.int16]

AWAY = -32768
IN_FLIGHT, HELD = 2, 3
"""States of pieces: `IN_FLIGHT` for a piece in flight, `HELD + k` for a piece that robot k holds."""
_UNIT = 32767.0
_ROBOT, _PART = 11, 7
_LINE = re.compile(r"^Sim/Limelights/.+/(DirectionLine|SeenTags)$")
_MOST_CORNERS = 12  # of a camera line
_FIELD, _HELD, _HANGING = "Sim/GamePieces/", "Sim/Held/", "Sim/Hanging"
_MOST_ROBOTS, _MOST_PIECES = 4000, 1400  # frames
_OTHERS = ("parts", "pieces", "lines")  # groups
_PERIODS = (0.02, 0.04)  # [s]; least time between frames of robots, and between frames of the other groups


@dataclass(frozen=True, slots=True, eq=False)
class PieceKind:
    """Kind of piece, with the ids of all pieces of this kind."""

    name: str
    ids: IntArray
    """Ids of the pieces in ascending order, shape (n,)."""
    is_round: bool
    key: str = ""
    """Telemetry key of an array of poses, with `ids` as indices; empty for `Sim/GamePieces/<name>`."""


def piece_kinds(recording: Recording, scene: Scene) -> list[PieceKind]:
    """Return the kinds of pieces in a recording, each with all pieces that appear during the run."""
    kinds = []
    for key in recording.keys:
        if key.startswith(_FIELD):
            name = key.removeprefix(_FIELD)
            lists = (recording.integers(f"Sim/{where}/{name}") for where in ("PieceIds", "HeldIds"))
            ids = {id(found): found for entries in lists for _, found in entries}  # most ticks share one array
            # logs of old versions have no ids, only the number of pieces
            known = np.unique(np.concatenate([*ids.values()])) if ids else np.arange(recording.most_poses(key))
            kinds.append(PieceKind(name, known, scene.look(name).size is None))
    return kinds + hanging_kinds(scene, recording.most_poses(_HANGING))


def hanging_kinds(scene: Scene, count: int) -> list[PieceKind]:
    """Return one kind of piece, with a single piece, for each of `count` hanging bodies."""
    is_round = [look.size is None for look in [*scene.hanging, *[PLAIN_PIECE] * count][:count]]
    return [PieceKind(f"Hanging {k}", np.array([k]), flag, _HANGING) for k, flag in enumerate(is_round)]


def kind_look(scene: Scene, kind: PieceKind) -> PieceLook:
    """Return the look of a kind of piece or of a hanging body."""
    if not kind.key:
        return scene.look(kind.name)
    return scene.hanging[kind.ids[0]] if kind.ids[0] < len(scene.hanging) else PLAIN_PIECE


class FrameLayout:
    """Layout of the columns of frames, for recordings and for single snapshots.

    Args:
        scene: Scene with the robots.
        solids: Solids of each robot.
        kinds: Kinds of pieces.
        lines: Telemetry keys. Keys of camera lines get columns, in this order; other keys are ignored.
    """

    def __init__(
        self, scene: Scene, solids: Sequence[RobotSolids], kinds: Sequence[PieceKind], lines: Iterable[str] = ()
    ) -> None:
        self._count, prefixes = len(scene.robots), [robot.prefix for robot in scene.robots]
        keys = [f"{prefix}/Robot/{name}" for name in ("Pose3d", "EstimatedPose") for prefix in prefixes]
        self._keys = {"poses": keys, "booleans": [f"{prefix}/Debug/IntakeZoneActive" for prefix in prefixes]}
        self._tables = {field: Table(field, keys) for field, keys in self._keys.items()}
        self._parts = [pose for one in solids for _, pose in one.parts]
        self.kinds, self._lines = list(kinds), [key for key in lines if _LINE.match(key)]
        self.widths = {
            "robots": _ROBOT * self._count,
            "parts": _PART * len(self._parts),
            "pieces": int(np.sum([len(kind.ids) * (4 if kind.is_round else 8) for kind in kinds])),
            "lines": 3 * _MOST_CORNERS * len(self._lines),
        }
        """Number of columns of each group."""
        self._before = np.zeros(self.widths["pieces"], dtype=np.int16)

    def frame(self, snapshot: Snapshot) -> dict[str, Rows]:
        """Return the frame of a snapshot: one row of shape (width,) for each group.

        Absent pieces keep the positions of the previous frame.
        """
        poses, intakes = (
            self._tables[field].row(getattr(snapshot, field))[: len(keys)] for field, keys in self._keys.items()
        )
        return {
            "robots": _robot_rows(poses[None], intakes[None])[0],
            "parts": self._part_row(snapshot),
            "pieces": self._piece_row(snapshot, poses[: self._count]),
            "lines": self._line_row(snapshot),
        }

    def frames(self, recording: Recording) -> dict[str, tuple[FloatArray, Rows]]:
        """Return the frames of a recording for a page; a long recording has fewer frames per second.

        Returns:
            Times [s], shape (n,), and rows, shape (n, width), of each group that has columns.
        """
        times = recording.times
        at = _picked(times, _PERIODS[0], _MOST_ROBOTS)
        poses, intakes = (recording.columns(field, keys) for field, keys in self._keys.items())
        found = {"robots": (times[at], _robot_rows(poses[at], intakes[at]))}
        at = _picked(times, _PERIODS[1], _MOST_PIECES)
        rows = [
            (self._part_row(one), self._piece_row(one, stands), self._line_row(one))
            for one, stands in zip(recording.snapshots(at), poses[at, : self._count], strict=True)
        ]
        found |= {
            name: (times[at], np.array(some)) for name, some in zip(_OTHERS, zip(*rows, strict=True), strict=False)
        }
        return {group: frames for group, frames in found.items() if self.widths[group] and len(times)}

    # --- inside -------------------------------------------------------------------------------------------------

    def _part_row(self, snapshot: Snapshot) -> Rows:
        found = [_NOWHERE if (row := pose(snapshot)) is None else row for pose in self._parts]
        rows = np.array(found).reshape(-1, _PART) * _SCALES
        rows[~np.isfinite(rows).all(axis=1)] = 0.0
        return _short(rows).ravel()

    def _piece_row(self, snapshot: Snapshot, stands: FloatArray) -> Rows:
        """Return the row of the group `pieces`; an absent piece keeps the position in the previous row.

        Args:
            snapshot: Snapshot with the poses of the pieces.
            stands: Poses of the robots, NaN where unknown, shape (robots, 7).
        """
        row, first = self._before.copy(), 0
        for kind in self.kinds:
            width = 4 if kind.is_round else 8
            mine = row[first : first + width * len(kind.ids)].reshape(-1, width)
            first += width * len(kind.ids)
            mine[:, 3] = 0
            if kind.key:
                _put(mine, np.arange(len(kind.ids)), snapshot.pose_arrays.get(kind.key, _NONE)[kind.ids[0] :], 1)
                continue
            for key, id_key, state in (
                (
                    _FIELD,
                    "Sim/PieceIds/",
                    1 if f"Sim/InFlightIds/{kind.name}" in snapshot.integer_arrays else IN_FLIGHT,
                ),
                ("Sim/InFlight/", "Sim/InFlightIds/", IN_FLIGHT),
            ):
                poses = snapshot.pose_arrays.get(key + kind.name, _NONE)
                ids = snapshot.integer_arrays.get(id_key + kind.name)
                rows = np.arange(len(poses)) if ids is None else np.searchsorted(kind.ids, ids)
                if ids is not None or key == _FIELD:
                    _put(mine, rows, poses, state)
            _put_held(mine, kind, snapshot, stands)
        self._before = row
        return row

    def _line_row(self, snapshot: Snapshot) -> Rows:
        row = np.full((len(self._lines), _MOST_CORNERS, 3), float(AWAY))
        for number, key in enumerate(self._lines):
            corners = snapshot.pose_arrays.get(key, _NONE)[:_MOST_CORNERS, :3]
            row[number, : len(corners)] = 1000.0 * corners
        return _short(row).ravel()


def _picked(times: FloatArray, period: float, most: int) -> list[int]:
    """Return the indices of the times [s] to use for frames, including the last time.

    The times are at least a period [s] apart. The number of times is at most about `most`.
    """
    rows: list[int] = []
    for row, time in enumerate(times.tolist()):
        due = times[0] + max(period, (times[-1] - times[0]) / most) * len(rows) - 1e-6
        if not rows or time >= min(due, times[-1]):
            rows.append(row)
    return rows


def _robot_rows(poses: FloatArray, intakes: npt.NDArray[np.uint8]) -> Rows:
    """Return the rows of the group `robots`, shape (n, width).

    Args:
        poses: True poses of all robots, then estimated poses of all robots, NaN if unknown, shape (n, 2 * robots, 7).
        intakes: 1 for each robot with an active intake, otherwise 0, shape (n, robots).
    """
    count = intakes.shape[1]
    true, believed = poses[:, :count], poses[:, count:]
    w, z = believed[..., 3], believed[..., 6]
    yaw = np.arctan2(2.0 * w * z, 1.0 - 2.0 * z * z)
    rows = np.concatenate((true * _SCALES, 1000.0 * believed[..., :2], np.stack((1e4 * yaw, intakes == 1), -1)), -1)
    is_gap = np.isnan(rows)
    rows[is_gap] = 0.0
    rows[..., (0, 7)] = np.where(is_gap[..., (0, 7)], AWAY, rows[..., (0, 7)])
    return _short(rows).reshape(len(rows), count * _ROBOT)


_NOWHERE, _SCALES = np.zeros(7), np.array([1000.0] * 3 + [_UNIT] * 4)
_NONE, _NONE_HELD = np.empty((0, 7)), np.empty(0, dtype=np.int64)


def _put(mine: Rows, rows: IntArray, poses: FloatArray, state: int | IntArray) -> None:
    """Write poses and states to rows of pieces, except poses that are not finite or have no row."""
    rows, poses = rows[: len(poses)], poses[: len(rows)]
    is_there = (rows < len(mine)) & np.isfinite(poses).all(axis=1)
    rows, poses = rows[is_there], poses[is_there]
    mine[rows, :3] = _short(1000.0 * poses[:, :3])
    mine[rows, 3] = np.broadcast_to(state, is_there.shape)[is_there]
    if mine.shape[1] > 4:
        mine[rows, 4:] = _short(_UNIT * poses[:, 3:])


def _put_held(mine: Rows, kind: PieceKind, snapshot: Snapshot, stands: FloatArray) -> None:
    """Write the poses of held pieces, each in the frame of the nearest robot; write nothing if no robot has a pose.

    Args:
        mine: Columns of the pieces of this kind.
        kind: Kind of the pieces.
        snapshot: Snapshot with the poses of the pieces.
        stands: Poses of the robots, NaN where unknown, shape (robots, 7).
    """
    poses = snapshot.pose_arrays.get(_HELD + kind.name, _NONE)
    ids = snapshot.integer_arrays.get(f"Sim/HeldIds/{kind.name}", _NONE_HELD)
    ids, poses = ids[: len(poses)], poses[: len(ids)]
    if not len(ids) or np.isnan(stands[:, 0]).all():
        return
    away = np.linalg.norm(poses[:, None, :2] - stands[None, :, :2], axis=2)
    nearest = np.where(np.isnan(away), np.inf, away).argmin(axis=1)
    w, a, b, c = stands[nearest, 3:].T
    inside = rotate_back((a, b, c, w), tuple((poses[:, :3] - stands[nearest, :3]).T))
    d, e, f, g = poses[:, 3:].T
    e, f, g, d = multiply((-a, -b, -c, w), (e, f, g, d))
    _put(mine, np.searchsorted(kind.ids, ids), np.array((*inside, d, e, f, g)).T, HELD + nearest)


def _short(values: FloatArray) -> Rows:
    found: Rows = np.rint(np.clip(values, AWAY, 32767.0)).astype(np.int16)
    return found


def pack(rows: Rows) -> bytes:
    """Encode 16-bit numbers as bytes that compress well: differences along each column, all low bytes, all high bytes.

    >>> pack(np.array([[1, 256], [2, 256]], dtype=np.int16)).hex(" ")
    '01 01 00 00 00 00 01 00'
    """
    steps = np.diff(rows, axis=0, prepend=np.zeros((1, rows.shape[1]), dtype=rows.dtype))
    return steps.T.astype("<i2").tobytes()[::2] + steps.T.astype("<i2").tobytes()[1::2]

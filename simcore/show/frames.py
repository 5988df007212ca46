"""A run as rows of 16-bit numbers: what the player draws, offline by the hundred and live one by one.

A frame has four groups of columns, and each group times of its own:

- `robots`: of each robot `x, y, z` [mm] and a quaternion `w, x, y, z` [1/32767]; where it believes to be, `x, y` [mm]
  and yaw [0.1 mrad]; and 1 while its intake takes pieces. A place that nobody knows is `AWAY`.
- `parts`: of each part of each robot a pose in the robot's frame; the quaternion of one that is not there is zero.
- `pieces`: of each piece `x, y, z` [mm] and where it is: 0 nowhere, 1 on the field, 2 in flight, 3 + k in robot k, in
  whose frame it is then; of kinds that are no balls also a quaternion.
- `lines`: corners of what cameras see, `x, y, z` [mm].

`simcore/show/player/data.js` is the reader.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from simcore.geometry.rotation import multiply, rotate_back
from simcore.show.scene import PLAIN_PIECE, PieceLook, Scene
from simcore.show.solids import RobotSolids
from simcore.telemetry.recording import Recording
from simcore.telemetry.snapshot import Snapshot
from simcore.typing import FloatArray, IntArray

__all__ = [
    "AWAY",
    "HELD",
    "IN_FLIGHT",
    "FrameLayout",
    "FrameRecorder",
    "PieceKind",
    "Rows",
    "filled",
    "hanging_kinds",
    "kind_look",
    "pack",
    "piece_kinds",
]

Rows = npt.NDArray[np.int16]

AWAY = -32768
IN_FLIGHT, HELD = 2, 3
"""Where pieces are: in flight, and this plus its number in a robot."""
_UNIT = 32767.0
_ROBOT, _PART = 11, 7
_LINE = re.compile(r"^Sim/Limelights/.+/(DirectionLine|SeenTags)$")
_MOST_CORNERS = 12  # of a line
_FIELD, _HELD, _HANGING = "Sim/GamePieces/", "Sim/Held/", "Sim/Hanging"
_MOST_ROBOTS, _MOST_PIECES = 4000, 1400  # frames
_PERIODS = (0.02, 0.04)  # [s] between frames of robots, and of all else, at least


@dataclass(frozen=True, slots=True, eq=False)
class PieceKind:
    """Pieces of one type."""

    name: str
    ids: IntArray
    """Of its pieces, rising, shape (n,)."""
    is_round: bool
    key: str = ""
    """Of the poses on the field, of which `ids` are rows; empty: `Sim/GamePieces/<name>`."""


def piece_kinds(recording: Recording, scene: Scene) -> list[PieceKind]:
    """The kinds of a recorded run with all pieces that were seen in it."""
    kinds = []
    for key in recording.keys:
        if key.startswith(_FIELD):
            name = key.removeprefix(_FIELD)
            lists = (recording.integers(f"Sim/{where}/{name}") for where in ("PieceIds", "HeldIds"))
            ids = [found for entries in lists for _, found in entries]
            # an old log says how many there are, not which
            known = np.unique(np.concatenate(ids)) if ids else np.arange(recording.most_poses(key))
            kinds.append(PieceKind(name, known, scene.look(name).size is None))
    return kinds + hanging_kinds(scene, recording.most_poses(_HANGING))


def hanging_kinds(scene: Scene, count: int) -> list[PieceKind]:
    """Return each hanging body of a run as a kind of its own."""
    is_round = [look.size is None for look in [*scene.hanging, *[PLAIN_PIECE] * count][:count]]
    return [PieceKind(f"Hanging {k}", np.array([k]), flag, _HANGING) for k, flag in enumerate(is_round)]


def kind_look(scene: Scene, kind: PieceKind) -> PieceLook:
    """Return the look of a kind of pieces, or of a hanging body."""
    if not kind.key:
        return scene.look(kind.name)
    return scene.hanging[kind.ids[0]] if kind.ids[0] < len(scene.hanging) else PLAIN_PIECE


class FrameLayout:
    """Makes frames of snapshots.

    Args:
        scene: With the robots.
        solids: Of each of them.
        kinds: Of the pieces.
        lines: Keys of what cameras see, in the order of their columns.
    """

    def __init__(
        self, scene: Scene, solids: Sequence[RobotSolids], kinds: Sequence[PieceKind], lines: Iterable[str] = ()
    ) -> None:
        self._robots = [(robot.pose_key, f"{robot.prefix}/Robot/EstimatedPose", robot.prefix) for robot in scene.robots]
        self._poses = [pose for one in solids for _, pose in one.parts]
        self.kinds, self._lines = list(kinds), [key for key in lines if _LINE.match(key)]
        self.widths = {
            "robots": _ROBOT * len(self._robots),
            "parts": _PART * len(self._poses),
            "pieces": int(np.sum([len(kind.ids) * (4 if kind.is_round else 8) for kind in kinds])),
            "lines": 3 * _MOST_CORNERS * len(self._lines),
        }
        """Columns of each group."""
        self._before = np.zeros(self.widths["pieces"], dtype=np.int16)

    def row(self, group: str, snapshot: Snapshot) -> Rows:
        """One group of the frame of a snapshot, shape (width,)."""
        make = {"robots": self._robot_row, "parts": self._part_row, "pieces": self._piece_row, "lines": self._line_row}
        return make[group](snapshot)

    # --- inside -------------------------------------------------------------------------------------------------

    def _robot_row(self, snapshot: Snapshot) -> Rows:
        row = np.zeros((len(self._robots), _ROBOT))
        for number, (key, estimate, prefix) in enumerate(self._robots):
            pose, believed = snapshot.poses.get(key), snapshot.poses.get(estimate)
            row[number, 0] = row[number, 7] = AWAY
            if pose is not None:
                row[number, :3], row[number, 3:7] = 1000.0 * pose[:3], _UNIT * pose[3:]
            if believed is not None:
                w, z = believed[3], believed[6]
                row[number, 7:9] = 1000.0 * believed[:2]
                row[number, 9] = 1e4 * np.arctan2(2.0 * w * z, 1.0 - 2.0 * z * z)
            row[number, 10] = snapshot.booleans.get(f"{prefix}/Debug/IntakeZoneActive", False)
        return _short(row).ravel()

    def _part_row(self, snapshot: Snapshot) -> Rows:
        found = [_NOWHERE if (row := pose(snapshot)) is None else row for pose in self._poses]
        rows = np.array(found).reshape(-1, _PART) * _SCALES
        rows[~np.isfinite(rows).all(axis=1)] = 0.0
        return _short(rows).ravel()

    def _piece_row(self, snapshot: Snapshot) -> Rows:
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
            self._put_held(mine, kind, snapshot)
        self._before = row
        return row

    def _put_held(self, mine: Rows, kind: PieceKind, snapshot: Snapshot) -> None:
        """Pieces in robots, each in the frame of the nearest one: two of them cannot be at one place."""
        poses = snapshot.pose_arrays.get(_HELD + kind.name, _NONE)
        ids = snapshot.integer_arrays.get(f"Sim/HeldIds/{kind.name}", _NONE_HELD)
        robots = {number: snapshot.poses[key] for number, (key, *_) in enumerate(self._robots) if key in snapshot.poses}
        ids, poses = ids[: len(poses)], poses[: len(ids)]
        if not robots or not len(ids):
            return
        numbers, stands = np.array(list(robots)), np.array(list(robots.values()))
        away = poses[:, None, :2] - stands[None, :, :2]
        nearest = np.nan_to_num(np.hypot(away[..., 0], away[..., 1]), nan=np.inf).argmin(axis=1)
        w, a, b, c = stands[nearest, 3:].T
        inside = rotate_back((a, b, c, w), tuple((poses[:, :3] - stands[nearest, :3]).T))
        d, e, f, g = poses[:, 3:].T
        e, f, g, d = multiply((-a, -b, -c, w), (e, f, g, d))
        _put(mine, np.searchsorted(kind.ids, ids), np.array((*inside, d, e, f, g)).T, HELD + numbers[nearest])

    def _line_row(self, snapshot: Snapshot) -> Rows:
        row = np.full((len(self._lines), _MOST_CORNERS, 3), float(AWAY))
        for number, key in enumerate(self._lines):
            corners = snapshot.pose_arrays.get(key, _NONE)[:_MOST_CORNERS, :3]
            row[number, : len(corners)] = 1000.0 * corners
        return _short(row).ravel()


class FrameRecorder:
    """Makes frames of a run, as many as a page needs.

    Args:
        layout: Of the frames.
        times: Of the snapshots [s], shape (n,).
    """

    def __init__(self, layout: FrameLayout, times: FloatArray) -> None:
        self._layout, self._end = layout, float(times[-1]) if len(times) else 0.0
        span = self._end - float(times[0]) if len(times) else 0.0
        pieces = max(_PERIODS[1], span / _MOST_PIECES)
        self._periods = dict.fromkeys(layout.widths, pieces) | {"robots": max(_PERIODS[0], span / _MOST_ROBOTS)}
        self._rows: dict[str, list[Rows]] = {group: [] for group in layout.widths}
        self._times: dict[str, list[float]] = {group: [] for group in layout.widths}

    def take(self, snapshot: Snapshot) -> None:
        """The next snapshot, with the newest of all arrays; the last one is always taken."""
        for group, times in self._times.items():
            due = times[0] + self._periods[group] * len(times) - 1e-6 if times else snapshot.time
            if self._layout.widths[group] and (snapshot.time >= min(due, self._end)):
                self._rows[group].append(self._layout.row(group, snapshot))
                times.append(snapshot.time)

    def groups(self) -> dict[str, tuple[FloatArray, Rows]]:
        """Times [s], shape (n,), and frames, shape (n, width), of each group."""
        widths = self._layout.widths
        return {
            group: (np.array(self._times[group]), np.array(rows, dtype=np.int16).reshape(len(rows), widths[group]))
            for group, rows in self._rows.items()
        }


_NOWHERE, _SCALES = np.zeros(7), np.array([1000.0] * 3 + [_UNIT] * 4)
_NONE, _NONE_HELD = np.empty((0, 7)), np.empty(0, dtype=np.int64)


def _put(mine: Rows, rows: IntArray, poses: FloatArray, state: int | IntArray) -> None:
    """Write poses into the columns of some pieces; what is not finite, or has no row, is left out."""
    rows, poses = rows[: len(poses)], poses[: len(rows)]
    is_there = (rows < len(mine)) & np.isfinite(poses).all(axis=1)
    rows, poses = rows[is_there], poses[is_there]
    mine[rows, :3] = _short(1000.0 * poses[:, :3])
    mine[rows, 3] = np.broadcast_to(state, is_there.shape)[is_there]
    if mine.shape[1] > 4:
        mine[rows, 4:] = _short(_UNIT * poses[:, 3:])


def _short(values: FloatArray) -> Rows:
    found: Rows = np.rint(np.clip(values, AWAY, 32767.0)).astype(np.int16)
    return found


def filled(recording: Recording) -> Iterator[Snapshot]:
    """The snapshots of a recording, each with the newest of all arrays."""
    poses: dict[str, FloatArray] = {}
    integers: dict[str, IntArray] = {}
    for snapshot in recording.snapshots():
        poses, integers = poses | dict(snapshot.pose_arrays), integers | dict(snapshot.integer_arrays)
        yield replace(snapshot, pose_arrays=poses, integer_arrays=integers)


def pack(rows: Rows) -> bytes:
    """16-bit numbers as bytes that compress well: differences down each column, all low bytes before all high ones.

    >>> pack(np.array([[1, 256], [2, 256]], dtype=np.int16)).hex(" ")
    '01 01 00 00 00 00 01 00'
    """
    steps = np.diff(rows, axis=0, prepend=np.zeros((1, rows.shape[1]), dtype=rows.dtype))
    return steps.T.astype("<i2").tobytes()[::2] + steps.T.astype("<i2").tobytes()[1::2]

"""Poses of the moving parts of all robots, computed in one compiled call from the mechanism positions in the loop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from simcore.loop.body import rotate
from simcore.loop.compiled import compiled
from simcore.loop.robot_state import Records
from simcore.robot.robot import Robot
from simcore.typing import FloatArray, IntArray
from simcore.world.rotation import Vector

__all__ = ["Components", "carried"]

_f = np.float64
_JOINT = np.dtype(
    [
        ("shaft", np.int64),  # index of the mechanism's shaft in the arrays of the loop
        ("axis", _f, (3,)),
        ("origin", _f, (3,)),  # [m]
        ("slides", np.uint8),
        ("ratio", _f),
    ],
    align=True,
)
"""Record type of a joint; see `simcore.world.linkage.Joint`."""


class Components:
    """Poses of the moving parts of all robots, in the order of `RobotConfig.components`.

    Args:
        robots: All robots.
        shaft_of: Index of each mechanism's shaft in the arrays of the loop, by the `id` of the mechanism object.
    """

    def __init__(self, robots: Sequence[Robot], shaft_of: Mapping[int, int]) -> None:
        joints: list[tuple[Any, ...]] = []
        chains = [(0, 0)]
        parts: list[tuple[int, Vector]] = []
        self._spans = []
        for robot in robots:
            first = len(parts)
            for component in robot.config.components:
                begin = len(joints)
                for j in component.joints:
                    shaft = shaft_of[id(robot.mechanisms[j.mechanism])]
                    joints.append((shaft, j.axis, j.origin, j.slides, j.ratio))
                if joints[begin:] != joints[slice(*chains[-1])]:
                    chains.append((begin, len(joints)))
                else:
                    del joints[begin:]
                parts.append((len(chains) - 1, component.offset))
            self._spans.append(slice(first, len(parts)))
        self._joints, self._chains = np.array(joints, _JOINT), np.array(chains)
        self._parts = np.array([chain for chain, _ in parts], np.int64)
        self._offsets = np.array([offset for _, offset in parts], _f).reshape(-1, 3)
        self._rows = np.full((len(parts), 7), np.nan)
        self._moved = np.zeros(len(parts), np.uint8)
        self._views: list[FloatArray] = [self._rows[span] for span in self._spans]

    def poses(self, shafts: Records) -> list[FloatArray]:
        """Return the poses of the moving parts in the robot frame: a read-only array of shape (n, 7) per robot.

        A row is `x, y, z, qw, qx, qy, qz` [m, -]. The method returns the same array object for a robot until a part of
        the robot moves.

        Args:
            shafts: Records of all robots' shafts.
        """
        rows, before = np.empty_like(self._rows), self._rows
        _place(shafts, self._joints, self._chains, self._parts, self._offsets, before, rows, self._moved)
        rows.setflags(write=False)
        self._rows, moved = rows, self._moved.tolist()
        for number, span in enumerate(self._spans):
            if any(moved[span]):
                self._views[number] = rows[span]
        return self._views


def carried(rows: FloatArray, owners: IntArray, places: FloatArray) -> FloatArray:
    """Transform the poses of held pieces from robot frames to the field frame, shape (n, 7).

    Args:
        rows: Pose of each piece in the frame of the robot that holds it, shape (n, 7).
        owners: Index of the robot that holds each piece, shape (n,).
        places: Poses of the robots, field frame, shape (m, 7).
    """
    found = np.empty_like(rows)
    _carry(rows, owners, places, found)
    return found


@compiled
def _multiply(
    aw: float, ax: float, ay: float, az: float, bw: float, bx: float, by: float, bz: float
) -> tuple[float, float, float, float]:
    """Compute the product a b of two quaternions w, x, y, z: rotation b first, then a."""
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@compiled
def _place(
    shafts: Records, joints: Records, chains: IntArray, parts: IntArray, offsets: FloatArray,
    before: FloatArray, rows: FloatArray, moved: npt.NDArray[np.uint8],
) -> None:  # fmt: skip
    """Write the pose of each part to `rows`, and write to `moved` whether the pose differs from that in `before`.

    The pose results from the chain of joints, as in `simcore.world.linkage.part_pose`.
    """
    last = -1
    x = y = z = 0.0
    w, a, b, c = 1.0, 0.0, 0.0, 0.0
    for part in range(len(parts)):
        if parts[part] != last:
            last = parts[part]
            x, y, z = 0.0, 0.0, 0.0
            w, a, b, c = 1.0, 0.0, 0.0, 0.0
            is_turned = False
            for k in range(chains[last, 0], chains[last, 1]):
                joint = joints[k]
                axis, origin = joint["axis"], joint["origin"]
                travel = joint["ratio"] * shafts[joint["shaft"]]["position"]
                ox, oy, oz = origin[0], origin[1], origin[2]
                if joint["slides"]:
                    ox, oy, oz = ox + travel * axis[0], oy + travel * axis[1], oz + travel * axis[2]
                ox, oy, oz = rotate((a, b, c, w), ox, oy, oz)
                x, y, z = x + ox, y + oy, z + oz
                if not joint["slides"]:
                    half = 0.5 * np.fmod(travel, 4.0 * math.pi)
                    s = math.sin(half)
                    d, e, f, g = math.cos(half), axis[0] * s, axis[1] * s, axis[2] * s
                    w, a, b, c = _multiply(w, a, b, c, d, e, f, g) if is_turned else (d, e, f, g)
                    is_turned = True
        ox, oy, oz = rotate((a, b, c, w), offsets[part, 0], offsets[part, 1], offsets[part, 2])
        row = rows[part]
        row[0], row[1], row[2] = x + ox, y + oy, z + oz
        row[3], row[4], row[5], row[6] = w, a, b, c
        moved[part] = False
        for k in range(7):
            if row[k] != before[part, k]:
                moved[part] = True


@compiled
def _carry(rows: FloatArray, owners: IntArray, places: FloatArray, found: FloatArray) -> None:
    """Write the field-frame poses of held pieces to `found`; see `carried`."""
    for i in range(len(rows)):
        p, q, row = rows[i], places[owners[i]], found[i]
        x, y, z = rotate((q[4], q[5], q[6], q[3]), p[0], p[1], p[2])
        row[0], row[1], row[2] = q[0] + x, q[1] + y, q[2] + z
        row[3], row[4], row[5], row[6] = _multiply(q[3], q[4], q[5], q[6], p[3], p[4], p[5], p[6])

"""Where the world goes under a camera that follows a robot: from a free side, with all of the robot in the picture.

Moving the world under a camera that stands lets the user orbit while he follows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from simcore.geometry.rotation import matrix, yaw_of
from simcore.show.glb import corners, opaque_triangles
from simcore.show.view_cameras import BEHIND, CHASE, FOV
from simcore.show.view_models import Model, RobotModels
from simcore.typing import FloatArray

__all__ = ["FollowCamera", "hidden_share", "pull_back", "robot_top"]

_MARGIN = 0.8  # share of the picture, from its middle up or down, that a robot may fill
_SIDES = tuple(math.radians(45.0 * k) for k in (0, 1, -1, 2, -2, 3, -3, 4))  # turns of the world, the nearest first
_MOST_HIDDEN = 0.15  # [-]; of a robot, before the camera looks for another side
_WAY = 0.3  # [m]; after which it looks anew
_TURN = 0.12  # [rad] a frame, to another side
_PLAIN_TOP = 0.3  # [m]; of a robot without a model
_ABOVE = 0.15  # [m]; held pieces reach beyond the part that holds them
_ON_ROBOT = np.array([(x, y, z) for x in (-0.3, 0.0, 0.3) for y in (-0.3, 0.0, 0.3) for z in (0.1, 0.35)])  # [m]
_LOW = 0.05  # [m]; what ends below hides nothing
_MOST_TRIANGLES = 50_000  # of a field; finer ones are taken as free all around


def robot_top(models: RobotModels | None, rows: FloatArray) -> float:
    """How high a robot reaches [m].

    Args:
        models: What is drawn of it.
        rows: Poses of its parts, robot frame, shape (n, 7).
    """
    if models is None:
        return _PLAIN_TOP
    top = float(corners(models.body)[:, 2].max())
    for model, (_, _, z, w, qx, qy, qz) in zip(models.parts, rows.tolist(), strict=False):
        top = max(top, z + float((corners(model) @ matrix((qx, qy, qz, w)).T)[:, 2].max()))
    return top + _ABOVE


def pull_back(eye: FloatArray, look: float, top: float) -> FloatArray:
    """How far the world moves away and down so that a robot is in the picture up to its top [m], shape (3,).

    Args:
        eye: Of the camera, from the robot's center on the carpet [m], shape (3,).
        look: Height over that center at which it looks [m].
        top: Of the robot [m].
    """
    ahead = np.array([0.0, 0.0, look]) - eye
    distance = float(np.linalg.norm(ahead))
    ahead /= distance
    down, level = -float(ahead[2]), math.hypot(ahead[0], ahead[1])
    steep = level / (_MARGIN * math.tan(0.5 * FOV))
    above, below = steep + down, steep - down  # distance from the eye for each meter over and under the middle
    middle = max(look, min(top - distance / above, top * above / (above + below)))
    shift: FloatArray = max(0.0, (top - middle) * above - distance) * ahead + np.array((0.0, 0.0, look - middle))
    return shift


def hidden_share(triangles: FloatArray, eye: FloatArray, places: FloatArray) -> float:
    """Share of places that something solid hides from an eye.

    Args:
        triangles: Of what is solid [m], shape (n, 3, 3).
        eye: Where one looks from [m], shape (3,).
        places: What one looks at [m], shape (m, 3).
    """
    if not len(triangles):
        return 0.0
    # Möller and Trumbore 1997, all triangles at once
    corner, one, other = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    from_corner = eye - corner
    turned = np.cross(from_corner, one)
    hidden = 0
    for way in places - eye:
        across = np.cross(way, other)
        size = np.einsum("ij,ij->i", one, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = np.einsum("ij,ij->i", from_corner, across) / size
            v = turned @ way / size
            t = np.einsum("ij,ij->i", other, turned) / size
            hidden += bool(((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < 0.98)).any())
    return hidden / len(places)


class FollowCamera:
    """Keeps a robot in the middle.

    Args:
        field: Its model; None: nothing hides a robot.
        center: Where the robot is brought, field frame [m].
    """

    def __init__(self, field: Model | None, center: Sequence[float]) -> None:
        self._field = field
        self._center = np.array(center, dtype=np.float64)
        self._solid: FloatArray | None = None
        self._mode = ""
        self._side = self._yaw = 0.0
        self._checked: FloatArray | None = None

    def world_pose(self, mode: str, pose: FloatArray, top: float) -> tuple[FloatArray, float]:
        """Position [m], shape (3,), and yaw [rad] of the world.

        Args:
            mode: `FOLLOW` or `BEHIND`.
            pose: Of the robot, field frame: x, y, z, qw, qx, qy, qz.
            top: How high it reaches [m].
        """
        eye, look = CHASE[mode]
        shift = pull_back(np.array(eye), look, top)
        x, y, _, w, qx, qy, qz = pose.tolist()
        if mode == BEHIND:
            yaw = -yaw_of((qx, qy, qz, w))
        else:
            self._find_side(pose[:3], np.array(eye) - shift, top)
            rest = math.remainder(self._side - self._yaw, math.tau)
            yaw = self._yaw + (max(-_TURN, min(_TURN, rest)) if mode == self._mode else rest)
        self._mode, self._yaw = mode, yaw
        c, s = math.cos(yaw), math.sin(yaw)
        return self._center - np.array((c * x - s * y, s * x + c * y, 0.0)) + shift, yaw

    def _find_side(self, pos: FloatArray, eye: FloatArray, top: float) -> None:
        """Turn to the nearest side from which most of the robot is seen, once it is hidden where one looks from."""
        if self._checked is not None and float(np.abs(pos - self._checked).max()) < _WAY:
            return
        self._checked = pos.copy()
        if self._solid is None:
            solid = opaque_triangles(self._field, _MOST_TRIANGLES) if self._field is not None else np.zeros((0, 3, 3))
            self._solid = solid[solid[:, :, 2].max(axis=1) > _LOW]
        places = pos + np.vstack((_ON_ROBOT, (0.0, 0.0, max(0.3, top - _ABOVE))))
        reach = math.hypot(*eye[:2]) + 1.0
        low, high = self._solid.min(axis=1), self._solid.max(axis=1)
        solid = self._solid[((low < pos + reach) & (high > pos - reach))[:, :2].all(axis=1)]
        hidden = {}
        for turn in _SIDES:
            side = self._side + turn
            c, s = math.cos(side), math.sin(side)
            seen_from = pos + np.array((c * eye[0] + s * eye[1], c * eye[1] - s * eye[0], eye[2]))
            hidden[side] = hidden_share(solid, seen_from, places)
            if hidden[side] < _MOST_HIDDEN:
                break
        self._side = math.remainder(min(hidden, key=lambda side: hidden[side]), math.tau)

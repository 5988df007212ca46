"""Which coral are on which branch or in the trough of a reef, and which algae lie in a net."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES, FIELD, flipped_box
from simcore.geometry.rotation import rotate
from simcore.geometry.zones import BoxZone
from simcore.match.game import MatchState
from simcore.match.scoring import Alliance
from simcore.typing import BoolArray, FloatArray, IntArray

__all__ = ["LEVELS", "Placed", "branch_pipes", "net_box", "on_branches", "placed_pieces"]

LEVELS = (2, 3, 4)
_AT_REST = 0.1  # [m/s]; a coral that slides down a pipe is faster
_SAMPLES = 10  # places along the last stretch of a pipe
_L4_STRETCH = (
    dim.BRANCH_TIP_HEIGHTS[2] - dim.RISER_TOP - (dim.BRANCH_TIP_RADIUS - dim.RISER_RADIUS) * math.tan(dim.BRANCH_SLOPE)
)
_SLOPING_STRETCH = (dim.BRANCH_TIP_RADIUS - dim.RISER_RADIUS) / math.cos(dim.BRANCH_SLOPE)
_TROUGH_SPARE = 0.05  # [m]; how far the middle of a coral in the trough may be from it: one lies across a corner
_TROUGH_TOP = dim.TROUGH_EDGE_HEIGHT + 0.5 * dim.CORAL_LENGTH  # of the middle of a coral that stands in the trough


@dataclass(slots=True)
class Placed:
    """What is in the places of one alliance."""

    branches: dict[int, set[int]] = field(default_factory=lambda: {level: set() for level in LEVELS})
    """Numbers of the branches that hold a coral, by level: 0 to 11, A to L of the manual from the face to the wall."""
    trough: int = 0
    """Coral in the trough."""
    net: int = 0
    """Algae in the net."""
    coral: frozenset[int] = frozenset()
    """Slots of the coral on branches and in the trough."""


def branch_pipes(alliance: Alliance) -> FloatArray:
    """Points along the last stretch of each branch's axis [m], shape (3 levels, 12 branches, samples, 3)."""
    (cx, cy), share = dim.REEF_CENTER, np.linspace(0.0, 1.0, _SAMPLES)
    points = np.empty((len(LEVELS), 12, _SAMPLES, 3))
    for number in range(12):
        # counter-clockwise from the face to the wall, so against the order of the faces
        yaw = math.radians(dim.REEF_FACE_YAWS_DEG[-(number // 2) % 6])
        aside = dim.BRANCH_OFFSET if number % 2 else -dim.BRANCH_OFFSET
        for row, level in enumerate(LEVELS):
            stretch, slope = (_L4_STRETCH, math.pi / 2) if level == 4 else (_SLOPING_STRETCH, dim.BRANCH_SLOPE)
            out = dim.BRANCH_TIP_RADIUS - share * stretch * math.cos(slope)
            points[row, number, :, 0] = cx + out * math.cos(yaw) - aside * math.sin(yaw)
            points[row, number, :, 1] = cy + out * math.sin(yaw) + aside * math.cos(yaw)
            points[row, number, :, 2] = dim.BRANCH_TIP_HEIGHTS[row] - share * stretch * math.sin(slope)
    if alliance == "blue":
        return points
    flipped: FloatArray = FIELD.symmetry.flip_points(points.reshape(-1, 3)).reshape(points.shape)
    return flipped


def net_box(alliance: Alliance) -> BoxZone:
    """The inside of an alliance's net, up to its rim."""
    half, t = dim.NET_WIDTH / 2.0, dim.NET_FRAME_THICKNESS
    low = (dim.FIELD_CENTER[0] - half + t, dim.NET_Y - dim.NET_LENGTH / 2.0 + t, dim.NET_FLOOR_HEIGHT)
    high = (dim.FIELD_CENTER[0] + half - t, dim.NET_Y + dim.NET_LENGTH / 2.0 - t, dim.NET_RIM_HEIGHT)
    return BoxZone(*flipped_box(low, high, alliance))


_PIPES = {alliance: branch_pipes(alliance) for alliance in ALLIANCES}
_NETS = {alliance: net_box(alliance) for alliance in ALLIANCES}
_CENTERS: dict[Alliance, tuple[float, float]] = {
    "blue": dim.REEF_CENTER,
    "red": FIELD.symmetry.flip_point(*dim.REEF_CENTER),
}


def on_branches(alliance: Alliance, centers: FloatArray, axes: FloatArray) -> tuple[IntArray, IntArray]:
    """The branch that goes through the bore of each coral.

    Args:
        alliance: Whose reef.
        centers: Of the coral [m], shape (n, 3).
        axes: Unit vectors along them, shape (n, 3).

    Returns:
        Level and number of the branch, 0 and -1 where none does, shape (n,) each.
    """
    pipes = _PIPES[alliance]
    away = pipes.reshape(1, -1, 3) - centers[:, None]
    along = np.einsum("ijk,ik->ij", away, axes)
    across2 = np.einsum("ijk,ijk->ij", away, away) - along * along
    inside = (np.abs(along) < 0.5 * dim.CORAL_LENGTH) & (across2 < (0.5 * dim.CORAL_INNER_DIAMETER) ** 2)
    held = inside.reshape(len(centers), len(LEVELS) * 12, _SAMPLES).sum(axis=2)
    best = held.argmax(axis=1) if len(centers) else np.zeros(0, dtype=np.int64)
    is_on: BoolArray = held.max(axis=1, initial=0) > 0
    return np.where(is_on, np.array(LEVELS)[best // 12], 0), np.where(is_on, best % 12, -1)


def placed_pieces(match: MatchState, alliance: Alliance, before: Placed) -> Placed:
    """What is in an alliance's places now: coral that has come to rest there and that no robot holds, algae in the net.

    Args:
        match: Which is played.
        alliance: Whose reef and net.
        before: What was there at the last look: a coral of it may move, e.g. rock, as long as it stays there.
    """
    placed, pieces = Placed(), match.pieces
    algae = pieces.on_field("Algae")
    placed.net = int(_NETS[alliance].contains(pieces.state.pos[algae]).sum())
    coral = pieces.on_field("Coral")
    (cx, cy), pos = _CENTERS[alliance], pieces.state.pos[coral]
    near = np.hypot(pos[:, 0] - cx, pos[:, 1] - cy) < dim.REEF_APOTHEM + 0.5 * dim.CORAL_LENGTH
    speed = np.linalg.norm(pieces.state.vel[coral], axis=1)
    is_known = np.isin(coral, list(before.coral))
    coral = coral[near & (pos[:, 2] > 0.3) & (is_known | (speed < _AT_REST))]
    if not len(coral):
        return placed
    pos = pieces.state.pos[coral]
    axes = np.array([rotate((x, y, z, w), (0.0, 0.0, 1.0)) for w, x, y, z in pieces.attitudes(coral).tolist()])
    levels, numbers = on_branches(alliance, pos, axes)
    for level, number in zip(levels.tolist(), numbers.tolist(), strict=True):
        if level:
            placed.branches[level].add(number)
    in_trough = _in_trough(pos - (cx, cy, 0.0)) & (levels == 0)
    placed.trough = int(in_trough.sum())
    placed.coral = frozenset(coral[in_trough | (levels > 0)].tolist())
    return placed


def _in_trough(pos: FloatArray) -> BoolArray:
    """Which places, from the middle of a reef's floor [m], are in its trough."""
    yaw = np.radians(60.0 * np.arange(6))
    out = (pos[:, :2] @ np.array([np.cos(yaw), np.sin(yaw)])).max(axis=1)  # a hexagon's distance from its center
    inside: BoolArray = (out > dim.REEF_APOTHEM - dim.TROUGH_DEPTH - _TROUGH_SPARE) & (
        out < dim.REEF_APOTHEM + _TROUGH_SPARE
    )
    return inside & (pos[:, 2] < _TROUGH_TOP)

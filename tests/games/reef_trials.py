"""Trials of the reef's physics: coral let go at a branch with errors, and what pieces are in after a drop."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import ConvexHull

from games.reefscape import REEFSCAPE
from games.reefscape import dimensions as dim
from games.reefscape.places import branch_ends
from simcore.geometry.rotation import from_rpy, matrix, multiply
from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus

FAR = (RobotEntry(start=(7.0, 6.9, 0.0), preload=0), RobotEntry(alliance="red", start=(7.0, 6.9, 0.0), preload=0))
CORAL, ALGAE = 0, 1
_BEFORE = 0.01  # [m], from a branch's end to the near end of the coral
_SPEED = {4: 0.0, 3: 1.0, 2: 1.0}  # [m/s], along the branch; on level 4 it falls
_JITTER = 0.002  # [m], standard deviation
_MIDDLE = 0.25 * (dim.CORAL_OUTER_DIAMETER + dim.CORAL_INNER_DIAMETER)  # [m], of a coral's wall
_WALL = np.array(
    [
        (_MIDDLE * math.cos(turn), _MIDDLE * math.sin(turn), z)
        for turn in np.arange(36) * math.tau / 36
        for z in np.linspace(-0.5, 0.5, 22) * (dim.CORAL_LENGTH - 0.006)
    ]
)


def placed_share(level: int, aside: float = 0.0, tilt: float = 0.0, pitch: float = 0.0, *, seed: int = 0) -> float:
    """Share of twelve coral, one let go at each of blue's branches of a level, that stay on their branch.

    Args:
        level: 2 to 4.
        aside: Error along the reef's face [m].
        tilt: Error of the coral's axis to that side [rad].
        pitch: Error of the axis in the upright plane of the branch, the outer or upper end outward and down [rad].
        seed: Of a jitter of 2 mm.
    """
    return let_go(level, aside, tilt, pitch, seed)[0]


def let_go(level: int, aside: float, tilt: float, pitch: float, seed: int) -> tuple[float, float]:
    """The same, and how far the middle of the outermost coral of all is from the end of its branch inward [m]."""
    rng = np.random.default_rng(seed)
    with Match(REEFSCAPE, robots=FAR, seed=seed) as match:
        state = match.pieces.state
        match.pieces.score(np.nonzero(state.kind == ALGAE)[0])
        coral = np.nonzero((state.kind == CORAL) & (state.status == PieceStatus.STAGED))[0][:12]
        centers, attitudes, speeds = [], [], []
        for number in range(12):
            yaw, tip, way = branch(number, level)
            lean = from_rpy(0.0, math.acos(min(1.0, way[2])), 0.0)
            error = aside * np.array([-math.sin(yaw), math.cos(yaw), 0.0]) + rng.normal(0.0, _JITTER, 3)
            centers.append(tip + (_BEFORE + 0.5 * dim.CORAL_LENGTH) * way + error)
            attitudes.append(multiply(multiply(from_rpy(0.0, 0.0, yaw), lean), from_rpy(-tilt, pitch, 0.0)))
            speeds.append(-_SPEED[level] * way)
        match.pieces.release(coral, np.array(centers), np.array(attitudes))
        match.pieces.push(coral, np.array(speeds))
        match.play(2.5)
        ends = [branch(number, level) for number in range(12)]
        inward = min([float((tip - state.pos[slot]) @ way) for slot, (_, tip, way) in zip(coral, ends, strict=True)])
        return match.pieces.places.count(level=f"BlueL{level}") / 12, inward


def branch(number: int, level: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Outward yaw of one of blue's branches [rad], its end [m], and the way along it to there."""
    start, tip = (np.array(end) for end in branch_ends(number, level))
    return math.radians(dim.REEF_FACE_YAWS_DEG[-(number // 2) % 6]), tip, (tip - start) / np.linalg.norm(tip - start)


def laid_across(level: int, off: float) -> tuple[int, int]:
    """Of twelve coral laid across the ends of blue's branches: how many count there, and how many still lie there.

    Args:
        level: 2 to 4.
        off: From the end of the branch to the middle of the coral, along the coral [m].
    """
    with Match(REEFSCAPE, robots=FAR) as match:
        state = match.pieces.state
        match.pieces.score(np.nonzero(state.kind == ALGAE)[0])
        coral = np.nonzero((state.kind == CORAL) & (state.status == PieceStatus.STAGED))[0][:12]
        up = 0.5 * (dim.CORAL_OUTER_DIAMETER + dim.BRANCH_DIAMETER) + 0.01
        ends = [branch(number, level) for number in range(12)]
        along = [np.array([-math.sin(yaw), math.cos(yaw), 0.0]) for yaw, _, _ in ends]
        centers = np.array(
            [tip + off * way + np.array([0.0, 0.0, up]) for (_, tip, _), way in zip(ends, along, strict=True)]
        )
        match.pieces.release(coral, centers, np.array([from_rpy(0.5 * math.pi, 0.0, yaw) for yaw, _, _ in ends]))
        match.play(4.0)
        stay = np.linalg.norm(state.pos[coral] - centers, axis=1) < 0.1
        return match.pieces.places.count(level=f"BlueL{level}"), int(stay.sum())


def bumped(speed: float) -> tuple[list[int], list[int], float]:
    """What a robot knocks off blue's reef that drives against a face of it at a speed [m/s].

    Every branch has a coral on it, but for every second upright end, which has one across.

    Returns:
        Coral on levels 2, 3 and 4 and across ends before the bump, the same after it, and the deepest that one of them
        was in a pipe or anything else at the end of a tick [m].
    """
    spots = [(number, level, False) for level in (2, 3, 4) for number in range(level == 4, 12, 1 + (level == 4))]
    spots += [(number, 4, True) for number in range(0, 12, 2)]
    with Match(REEFSCAPE, robots=FAR) as match:
        state, robot = match.pieces.state, match.robots[0]
        match.pieces.score(np.nonzero(state.kind == ALGAE)[0])
        coral = np.nonzero((state.kind == CORAL) & (state.status == PieceStatus.STAGED))[0][: len(spots)]
        centers, attitudes = [], []
        for number, level, is_across in spots:
            yaw, tip, way = branch(number, level)
            lean = from_rpy(0.5 * math.pi, 0.0, 0.0) if is_across else from_rpy(0.0, math.acos(min(1.0, way[2])), 0.0)
            centers.append(tip + (np.array([0.0, 0.0, 0.058]) if is_across else -0.3 * dim.CORAL_LENGTH * way))
            attitudes.append(multiply(from_rpy(0.0, 0.0, yaw), lean))
        match.pieces.release(coral, np.array(centers), np.array(attitudes))
        match.play(2.5)

        def counts() -> list[int]:
            on = [match.pieces.places.count(level=f"BlueL{level}") for level in (2, 3, 4)]
            return [*on, int((state.pos[coral[-6:], 2] > dim.BRANCH_TIP_HEIGHTS[2]).sum())]

        before, deepest = counts(), 0.0
        face = dim.REEF_CENTER[0] + dim.REEF_APOTHEM + 0.4
        robot.carry_to((face + 0.1 + 0.15 * speed * speed, dim.REEF_CENTER[1], math.pi))
        robot.drive.set_chassis_speeds(speed, 0.0, 0.0)
        for _ in range(100):
            match.tick()
            if robot.chassis.pos[0] < face + 0.01:
                robot.drive.set_chassis_speeds(0.0, 0.0, 0.0)
            awake = np.intersect1d(match.pieces.awake, coral)
            deepest = max([deepest, *(match.world.engine.depth(match.pieces.row(slot)) for slot in awake.tolist())])
        match.play(1.0)
        return before, counts(), deepest


def faults(match: Match, slots: np.ndarray) -> list[str]:
    """What is wrong with pieces that should lie still: awake, in the field, in each other."""
    state, engine = match.pieces.state, match.world.engine
    pos, found = state.pos[slots], []
    axes = [matrix((x, y, z, w)) for w, x, y, z in match.pieces.attitudes(slots)]
    walls = [_WALL @ turn.T + at for turn, at in zip(axes, pos, strict=True)]
    for name, low, high, planes in _statics(match):
        for i in np.nonzero(((low < pos + 0.17) & (high > pos - 0.17)).all(axis=1))[0].tolist():
            if state.kind[slots[i]] == CORAL:
                depth = -(walls[i] @ planes[:, :3].T + planes[:, 3]).max(axis=1).min()
                if depth > 0.001:
                    found.append(f"coral {slots[i]} is {1e3 * depth:.1f} mm in {name}")
    for i, slot in enumerate(slots.tolist()):
        if state.status[slot] not in (PieceStatus.ASLEEP, PieceStatus.PLACED):
            found.append(f"{slot} is awake at {pos[i].round(2).tolist()}")
        if state.kind[slot] == ALGAE:
            if (depth := engine.overlap(match.pieces._pool.rows[slot])) > 0.012:
                found.append(f"algae {slot} is {1e3 * depth:.1f} mm in something")
            continue
        if walls[i][:, 2].min() < 0.0:
            found.append(f"coral {slot} is in the floor")
        for j in np.nonzero(np.linalg.norm(pos - pos[i], axis=1) < 0.36)[0].tolist():
            if j != i and state.kind[slots[j]] == CORAL:
                local = (walls[j] - pos[i]) @ axes[i]
                away = np.hypot(local[:, 0], local[:, 1])
                gaps = (away - 0.5 * dim.CORAL_INNER_DIAMETER, 0.5 * dim.CORAL_OUTER_DIAMETER - away)
                depth = np.minimum(np.minimum(*gaps), 0.5 * dim.CORAL_LENGTH - np.abs(local[:, 2])).max()
                if depth > 0.0025:
                    found.append(f"coral {slot} and {slots[j]} are in each other")
    return found


def _statics(match: Match) -> list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Name, corners of the bounding box and planes of each convex element of the field."""
    found = []
    for row, body in enumerate(match.world.engine._definitions):
        if body.mass == 0.0 and hasattr(body.shape, "points"):
            points = body.shape.points @ matrix(body.quat).T + np.array(body.pos)
            planes = ConvexHull(points).equations
            found.append((match.world.body_name(row), points.min(axis=0), points.max(axis=0), planes))
    return found

"""The poses of all parts and carried pieces equal those of each robot's joint chains to the last bit."""

from __future__ import annotations

from itertools import count

import numpy as np

from games.rebuilt.robot import rebuilt_robot
from games.reefscape.robot import reefscape_robot
from simcore.loop.robot_state import SHAFT, records
from simcore.match.game import Game, RobotEntry
from simcore.match.match import Match
from simcore.robot.components import Components, carried
from simcore.typing import FloatArray
from simcore.world.linkage import part_pose
from simcore.world.rotation import multiply, rotate


def row_of(pos: tuple[float, ...], quat: tuple[float, ...]) -> list[float]:
    x, y, z, w = quat
    return [*pos, w, x, y, z]


def poses(rng: np.random.Generator, n: int) -> FloatArray:
    rows = rng.normal(size=(n, 7))
    rows[:, 3:] /= np.linalg.norm(rows[:, 3:], axis=1)[:, None]
    return rows


def test_part_poses_follow_the_joints_and_stay_in_the_same_array_at_rest() -> None:
    rng = np.random.default_rng(1)
    robots = [RobotEntry(start=(2.0, y, 0.0), config=c) for y, c in ((2.0, reefscape_robot()), (5.0, rebuilt_robot()))]
    with Match(Game.bare(size=(16.0, 8.0)), robots=robots) as match:
        numbers = count()
        shaft_of = {id(one): next(numbers) for robot in match.robots for one in robot.mechanisms.values()}
        components, shafts = Components(match.robots, shaft_of), records(SHAFT, len(shaft_of))
        for _ in range(20):
            shafts["position"] = rng.normal(scale=3.0, size=len(shafts))
            for robot in match.robots:
                for mechanism in robot.mechanisms.values():
                    mechanism.position = shafts["position"][shaft_of[id(mechanism)]]
            for robot, rows in zip(match.robots, components.poses(shafts), strict=True):
                parts = robot.config.components
                assert len(rows) == len(parts) > 0
                for part, row in zip(parts, rows, strict=True):
                    expected = row_of(*part_pose(part.joints, robot.mechanisms, part.offset))
                    assert row.tolist() == expected and np.signbit(row).tolist() == np.signbit(expected).tolist()
        before = [*components.poses(shafts)]
        shafts["position"][shaft_of[id(match.robots[1].mechanisms["hood"])]] += 0.1
        after = components.poses(shafts)
        assert after[0] is before[0] and after[1] is not before[1]


def test_carried_pieces_follow_the_pose_of_their_robot() -> None:
    rng = np.random.default_rng(2)
    rows, places, owners = poses(rng, 12), poses(rng, 3), rng.integers(0, 3, 12)
    for found, row, own in zip(carried(rows, owners, places), rows, places[owners], strict=True):
        quat, turn = (*own[4:], own[3]), (*row[4:], row[3])
        pos = own[:3] + rotate(quat, row[:3])
        assert found.tolist() == row_of(tuple(pos.tolist()), multiply(quat, turn))

"""Nothing passes or lodges in a wall of 0.05 m at up to 40 m/s."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from simcore.physics.contact_law import WALL, TerrainSurface
from simcore.physics.shapes import Box, Hull, Mesh, Shape, Sphere
from simcore.physics.world import PhysicsWorld

THICKNESS = 0.05


def wall(kind: str) -> Shape:
    corners = np.array([[x, y, z] for x in (-0.025, 0.025) for y in (-2.0, 2.0) for z in (-2.0, 2.0)])
    if kind == "box":
        return Box((THICKNESS, 4.0, 4.0))
    if kind == "hull":
        return Hull(corners)
    mesh = trimesh.convex.convex_hull(corners)
    return Mesh(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64))


@pytest.mark.parametrize("kind", ["box", "hull", "mesh"])
@pytest.mark.parametrize("degrees", [0, 45])
@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0, 40.0])
def test_two_hundred_shots_all_come_back(kind, degrees, speed):
    """Start distances are spread over a whole step, so every phase of the hit occurs."""
    angle = math.radians(degrees)
    rng = np.random.default_rng(1)
    with PhysicsWorld(floor=None, gravity=1e-9) as world:
        world.add_static("wall", wall(kind), (0.0, 0.0, 0.0), surface=WALL)
        row = world.add_piece_body(
            "ball",
            Sphere(0.075),
            mass=0.215,
            surface=TerrainSurface(name="ball", friction=0.8, restitution=0.5),
            pos=(-5.0, 0.0, 0.0),
        )
        passed = lodged = 0
        for _ in range(200):
            ahead = 0.15 + rng.random() * speed * 0.02
            world.set_pose(row, (-0.1 - ahead * math.cos(angle), -ahead * math.sin(angle), 0.0))
            world.set_velocity(row, (speed * math.cos(angle), speed * math.sin(angle), 0.0))
            for _ in range(math.ceil((ahead + 0.5) / (0.02 * speed)) + 2):
                world.step(0.02)
            x = world.engine.pose(row)[0][0]
            passed += x > 0.0
            lodged += -0.09 < x <= 0.0
        assert (passed, lodged) == (0, 0)

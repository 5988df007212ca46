"""Sub-steps against continuous collision detection (CCD): `python scripts/compare_ccd.py [--json] [--shots N]`.

Both are cures for fast balls that pass thin walls. Our engine settings stay as they are; only the cure changes:

- `sub-steps`: a tick of 20 ms is cut so that no ball moves more than `Substepping` allows, the rule of simcore.
- `CCD`: one step of 20 ms, with Bullet's swept sphere of 0.06 m on the ball.
- `neither`: one step of 20 ms and nothing else, to see what there is to cure.

Measured are: the bounce that is left of a configured 0.5, how many of the shots pass a wall of 0.05 m or lodge in it,
and the engine's time for a tick with 100 balls rolling and 4 flying. The first two are the same on every machine.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from time import perf_counter

import numpy as np
from rich.console import Console
from rich.table import Table

from simcore.physics.bullet import BulletEngine
from simcore.physics.contact_law import CARPET, WALL, TerrainSurface
from simcore.physics.engine import BodyDefinition
from simcore.physics.field import FieldBoundary
from simcore.physics.shapes import Box, HalfSpace, Mesh, Shape, Sphere
from simcore.physics.substeps import Substepping
from simcore.units import GRAVITY

DT = 0.02
RADIUS, MASS = 0.075, 0.215
THICKNESS = 0.05
SWEPT_RADIUS = 0.06
"""Of the sphere that CCD moves ahead of the ball [m]; it has to be smaller than the ball itself."""
SPEEDS = (10.0, 20.0, 30.0, 40.0)
RESTITUTION = 0.5
BALL = TerrainSurface(name="ball", friction=0.8, restitution=RESTITUTION)
HARD = TerrainSurface(name="hard", friction=0.5, restitution=1.0)
METHODS = ("neither", "sub-steps", "CCD")


class SweptEngine(BulletEngine):
    """Our engine, with Bullet's CCD for the bodies that ask for it."""

    def sweep(self, rows: Sequence[int]) -> None:
        """Turn CCD on for some bodies."""
        for row in rows:
            self._p.changeDynamics(self._ids[row], -1, ccdSweptSphereRadius=SWEPT_RADIUS, **self._kw)


@dataclass(frozen=True)
class Shots:
    """What became of some shots at a wall."""

    wall: str
    method: str
    speed: float
    passed: int
    stuck: int
    bounce_mean: float
    bounce_min: float
    bounce_max: float
    """Speed away from the wall over speed into it, of the shots that came back."""


@dataclass(frozen=True)
class Cost:
    """Time of the engine for one tick."""

    method: str
    median_ms: float
    p95_ms: float
    substeps: float
    fastest: float
    """Mean over the ticks of the fastest ball [m/s]: the check that the four really flew."""


def wall_shape(kind: str) -> Shape:
    """A wall of 0.05 m across x, 4 m wide and high."""
    if kind == "box":
        return Box((THICKNESS, 4.0, 4.0))
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)]
    return Mesh(corners * (THICKNESS, 4.0, 4.0), np.array(faces, dtype=np.int64))


def count(method: str, speed: float) -> int:
    """Steps of a tick."""
    return Substepping().count(DT, speed) if method == "sub-steps" else 1


def shoot(kind: str, method: str, speed: float, shots: int) -> Shots:
    """Shoot straight at a wall, the start spread over a whole step, so that every phase of the hit occurs."""
    rng = np.random.default_rng(1)
    n = count(method, speed)
    passed = stuck = 0
    kept: list[float] = []
    engine = SweptEngine(gravity=0.0)
    with engine:
        engine.add_body(BodyDefinition(shape=wall_shape(kind), surface=HARD))
        ball = engine.add_body(BodyDefinition(shape=Sphere(RADIUS), surface=BALL, mass=MASS, pos=(-5.0, 0.0, 0.0)))
        if method == "CCD":
            engine.sweep([ball])
        for _ in range(shots):
            ahead = 0.15 + rng.random() * speed * DT
            # off the middle, where the diagonal of the mesh would count twice
            engine.set_pose(ball, (-0.1 - ahead, 0.3, 0.4), (0.0, 0.0, 0.0, 1.0))
            engine.set_velocity(ball, (speed, 0.0, 0.0), (0.0, 0.0, 0.0))
            for _ in range(math.ceil((ahead + 0.5) / (DT * speed)) + 2):
                for _ in range(n):
                    engine.step(DT / n)
            x = engine.pose(ball)[0][0]
            if x > 0.0:
                passed += 1
            elif x > -0.09:
                stuck += 1
            else:
                kept.append(-engine.velocity(ball)[0][0] / speed)
    few = np.array(kept or [math.nan])
    return Shots(kind, method, speed, passed, stuck, *(round(float(f(few)), 3) for f in (np.mean, np.min, np.max)))


def cost(method: str, seconds: float) -> Cost:
    """Time the engine with 100 balls rolling on a walled carpet and 4 in the air; CCD on the 4 alone, or on all."""
    length, width = 16.0, 8.0
    rng = np.random.default_rng(2)
    engine = SweptEngine(gravity=GRAVITY)
    with engine:
        engine.add_body(BodyDefinition(shape=HalfSpace(), surface=CARPET))
        walls = FieldBoundary(length=length, width=width, side_height=0.5, end_height=2.0)
        for wall in walls.elements():
            x, y, z = wall.position.tolist()
            engine.add_body(BodyDefinition(shape=wall.shape, surface=WALL, pos=(x, y, z)))
        grid = [(1.0 + 0.7 * i, 1.0 + 1.4 * j, RADIUS) for i in range(20) for j in range(5)]
        grid += [(1.0, 1.0 + 1.5 * j, 1.0) for j in range(4)]
        balls = [
            engine.add_body(BodyDefinition(shape=Sphere(RADIUS), surface=BALL, mass=MASS, pos=place)) for place in grid
        ]
        rolling, flying = balls[:100], balls[100:]
        if method.startswith("CCD"):
            engine.sweep(balls if method == "CCD, all" else flying)
        times, steps, fastest = [], [], []
        for tick in range(round(seconds / DT)):
            if tick % 50 == 0:  # each second: 100 kicks of 2 m/s, and 4 shots of 12 m/s at 60 degrees
                for ball, angle in zip(rolling, rng.uniform(0.0, math.tau, 100).tolist(), strict=True):
                    vx, vy = 2.0 * math.cos(angle), 2.0 * math.sin(angle)
                    engine.set_velocity(ball, (vx, vy, 0.0), (-vy / RADIUS, vx / RADIUS, 0.0))
                for j, ball in enumerate(flying):
                    engine.set_pose(ball, (1.0, 1.0 + 1.5 * j, 1.0), (0.0, 0.0, 0.0, 1.0))
                    engine.set_velocity(ball, (6.0, 0.0, 10.4), (0.0, 0.0, 0.0))
            speed = float(np.linalg.norm(engine.velocities(balls)[:, :3], axis=1).max()) + GRAVITY * DT
            n = count(method, speed)
            start = perf_counter()
            for _ in range(n):
                engine.step(DT / n)
            times.append(1e3 * (perf_counter() - start))
            steps.append(n)
            fastest.append(speed)
    median, p95 = np.percentile(times, (50, 95)).round(3).tolist()
    return Cost(method, median, p95, round(float(np.mean(steps)), 2), round(float(np.mean(fastest)), 1))


def best_of(rounds: int, measure: Callable[[], Cost]) -> Cost:
    """The quietest of some rounds: other programs only ever add time."""
    return min((measure() for _ in range(rounds)), key=lambda c: c.median_ms)


def main() -> int:
    """Measure and print two tables, or JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--shots", type=int, default=200, help="per cell (default: 200)")
    parser.add_argument("--seconds", type=float, default=6.0, help="simulated time of each timing (default: 6)")
    options = parser.parse_args()
    shots = [shoot(k, m, v, options.shots) for k in ("box", "mesh") for m in METHODS for v in SPEEDS]
    ways = ("neither", "sub-steps", "CCD, the 4", "CCD, all")
    costs = [best_of(3, lambda way=way: cost(way, options.seconds)) for way in ways]  # type: ignore[misc]
    if options.json:
        print(json.dumps({"shots": [asdict(s) for s in shots], "cost": [asdict(c) for c in costs]}))
        return 0
    console = Console()
    title = f"{options.shots} shots at a wall of 0.05 m; bounce kept of {RESTITUTION}"
    table = Table(title=title, title_justify="left")
    for column in ("wall", "method", "m/s", "steps", "passed", "stuck", "bounce", "min", "max"):
        table.add_column(column, justify="left" if column in ("wall", "method") else "right")
    for s in shots:
        table.add_row(
            s.wall, s.method, f"{s.speed:.0f}", str(count(s.method, s.speed)), str(s.passed), str(s.stuck),
            f"{s.bounce_mean:.3f}", f"{s.bounce_min:.3f}", f"{s.bounce_max:.3f}",
        )  # fmt: skip
    console.print(table)
    table = Table(title="Engine, ms a tick: 100 rolling, 4 flying; best of 3", title_justify="left")
    for column in ("method", "median", "p95", "steps", "fastest m/s"):
        table.add_column(column, justify="left" if column == "method" else "right")
    for c in costs:
        table.add_row(c.method, f"{c.median_ms:.2f}", f"{c.p95_ms:.2f}", f"{c.substeps:.1f}", f"{c.fastest:.1f}")
    console.print(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Each auto is played once and looked at from many sides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest
from games.rebuilt.runner import AutoRun, play_auto
from games.rebuilt.sim import RebuiltSim

from games.rebuilt.autos import find_auto


@dataclass
class Played:
    """A run with what was seen at each tick."""

    run: AutoRun
    lowest: float = 1.0
    """Of any fuel on the field [m]."""
    lost: list[int] = field(default_factory=list)
    """Ticks at which the fuel did not add up."""
    floor: list[tuple[float, float, float]] = field(default_factory=list)
    """Roll, pitch and height of the robot."""
    poses: list[tuple[float, ...]] = field(default_factory=list)
    held: list[int] = field(default_factory=list)
    ghosts: float = 0.0
    """Farthest that a sleeper's body was from where the sleeper is said to lie, at the end [m]."""


def play(name: str, alliance: str = "blue", seed: int = 0, **kw) -> Played:
    seen = Played(run=None)  # type: ignore[arg-type]

    def look(sim: RebuiltSim) -> None:
        fuel = sim.fuel
        if not fuel.is_conserved:
            seen.lost.append(sim.ticks)
        seen.lowest = min(seen.lowest, float(sim.pieces.state.pos[sim.pieces.on_field(), 2].min()))
        chassis = sim.robots[0].chassis
        roll, pitch, _ = chassis.roll_pitch_yaw
        seen.floor.append((roll, pitch, chassis.pos[2]))
        seen.poses.append((*chassis.pos, *chassis.quat))
        seen.held.append(fuel.held)

    seen.run = play_auto(find_auto(name), alliance=alliance, seed=seed, on_tick=look, **kw)
    pieces = seen.run.sim.pieces
    asleep = np.nonzero(pieces.state.status == 2)[0]
    bodies = seen.run.sim.world.engine.centers(pieces._pool.rows_of(asleep))
    seen.ghosts = float(np.abs(bodies - pieces.state.pos[asleep]).max())
    return seen


@pytest.fixture(scope="session")
def played() -> Iterator[dict[tuple[str, str], Played]]:
    """By auto and alliance, made when first asked for."""

    class Runs(dict):
        def __missing__(self, key: tuple[str, str]) -> Played:
            self[key] = play(*key)
            return self[key]

    runs = Runs()
    yield runs
    for one in runs.values():
        one.run.sim.close()

"""Staging of the 504 fuel at the start of a match (game manual, arena, FUEL staging).

The box in the neutral zone measures 206 x 72 in, with a divider of 2 in across the box. The box therefore has 34 x 12
positions at a pitch of 6 in. The box contains 360 fuel and the preloads of absent robots, at most 408 fuel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from games.rebuilt.dimensions import DEPOT_Y, FIELD_LENGTH, FIELD_WIDTH
from games.rebuilt.field import FIELD
from games.rebuilt.fuel import FUEL
from simcore.errors import ConfigError
from simcore.match.game import RobotEntry, StagedPieces
from simcore.quantities import COUNT, Quantity, require_fields
from simcore.typing import FloatArray
from simcore.units import inches

__all__ = ["Staging", "depot_places", "neutral_places"]

_PITCH = inches(6.0)
_ROWS, _COLUMNS = 34, 12
_DIVIDER = inches(2.0)
_RADIUS = inches(5.91) / 2
_JITTER = 0.001  # [m] to either side: scatter of placement by hand, too small for overlaps


@dataclass(frozen=True, slots=True, kw_only=True)
class Staging:
    """Numbers of staged fuel; the defaults are the manual's numbers, 504 in total."""

    neutral: int = 360
    """Number of fuel in the box of the neutral zone, without the preloads of absent robots."""
    depot: int = 24
    """Number of fuel in each of the two depots."""
    chute: int = 24
    """Number of fuel in each of the two outposts' chutes, off the field."""
    preload_per_robot: int = 8
    """Default and largest number of fuel preloaded in a robot."""
    robots: int = 6
    """Largest number of robots; the preloads of absent robots are staged in the neutral zone."""

    def __post_init__(self) -> None:
        depot = Quantity("fuel", 0, 24, is_whole=True)  # capacity of a depot
        require_fields(self, neutral=COUNT, depot=depot, chute=COUNT, preload_per_robot=COUNT, robots=COUNT)

    def __call__(self, rng: np.random.Generator, entries: Sequence[RobotEntry]) -> list[StagedPieces]:
        """Return the staged fuel of a match with a blue first robot; unused preloads are in the neutral zone.

        Raises:
            ConfigError: If there are too many robots or preloads, or more fuel than the neutral zone holds.
        """
        if len(entries) > self.robots:
            raise ConfigError(f"Staging counts preloads for {self.robots} robots, got {len(entries)}")
        taken = 0
        for entry in entries:
            preload = self.preload_per_robot if entry.preload is None else entry.preload
            if preload > self.preload_per_robot:
                raise ConfigError(f"Staging: preload must be 0..{self.preload_per_robot} fuel, got {preload}")
            taken += preload
        missing = self.preload_per_robot * len(entries) - taken
        places = [neutral_places(self.in_neutral_zone(len(entries)) + missing, rng)]
        places += [depot_places(alliance, self.depot, rng) for alliance in ("blue", "red")]
        staged = [StagedPieces(kind=FUEL.name, positions=some) for some in places]
        return [*staged, StagedPieces(kind=FUEL.name, off_field=2 * self.chute)]

    @property
    def total(self) -> int:
        """Total number of fuel in the match."""
        return self.neutral + 2 * self.depot + 2 * self.chute + self.preload_per_robot * self.robots

    def in_neutral_zone(self, robots_present: int) -> int:
        """Return the number of fuel staged in the neutral zone for a given number of robots on the field.

        Raises:
            ConfigError: If the number exceeds the capacity of the box.
        """
        count = self.neutral + self.preload_per_robot * max(0, self.robots - robots_present)
        if count > _ROWS * _COLUMNS:
            raise ConfigError(
                f"Staging: the neutral zone holds {_ROWS * _COLUMNS} fuel, got {count} "
                f"({self.neutral} and the preloads of {self.robots - robots_present} absent robots)"
            )
        return count


def neutral_places(count: int, rng: np.random.Generator) -> FloatArray:
    """Return random positions of fuel on the grid of the neutral zone's box, field frame [m], shape (count, 3)."""
    x = (np.arange(_COLUMNS) - (_COLUMNS - 1) / 2) * _PITCH
    half = _DIVIDER / 2 + (np.arange(_ROWS // 2) + 0.5) * _PITCH
    y = np.concatenate((-half[::-1], half))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    taken = np.sort(rng.permutation(len(grid))[:count])
    places = np.empty((count, 3))
    places[:, :2] = grid[taken] + (FIELD_LENGTH / 2, FIELD_WIDTH / 2) + rng.uniform(-_JITTER, _JITTER, (count, 2))
    places[:, 2] = _RADIUS
    return places


def depot_places(alliance: str, count: int, rng: np.random.Generator) -> FloatArray:
    """Return positions of fuel in a depot, in rows of 6 from the wall outward, field frame [m], shape (count, 3)."""
    x = (np.arange(4) + 0.5) * _PITCH + 0.003
    y = DEPOT_Y + (np.arange(6) - 2.5) * _PITCH
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)[:count]
    places = np.empty((count, 3))
    places[:, :2] = grid + rng.uniform(-_JITTER, _JITTER, (count, 2))
    places[:, 2] = _RADIUS
    return places if alliance == "blue" else FIELD.symmetry.flip_points(places)

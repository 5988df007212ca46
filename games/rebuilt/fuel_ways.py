"""Return of scored and lost fuel to the field, through a hub's exit or by field staff."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from games.rebuilt import dimensions as dim
from games.rebuilt.field import FIELD
from games.rebuilt.fuel import FUEL
from simcore.match.game import PlayedMatch
from simcore.match.scoring import Alliance, other_alliance
from simcore.typing import FloatArray
from simcore.units import TICK, degrees

__all__ = ["HUB_EXITS", "FuelWays", "hub_exit", "own_first"]

HUB_EXITS = "hub_exits"
"""Name of the option with which scored fuel leaves a hub through the exit into the neutral zone, as on a real field."""

# Estimates: no figures are published for a hub's motors, and the manual says "randomly distributed".
_DELAY, _DELAY_SPREAD = 1.0, 0.25  # [s]; time from the throat to the exit, and largest deviation
_PERIOD = 0.1  # [s]; shortest time between two fuel from a hub
_SPEED, _SPEED_SPREAD = 2.0, 0.3  # [m/s]
_FAN, _DIP, _DIP_SPREAD = degrees(15.0), degrees(15.0), degrees(2.5)  # to either side; downward, and largest deviation
_CREW = (3.0, 8.0)  # [s]; range of the time until field staff return fuel that left the field


def hub_exit(alliance: Alliance, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Draw the position [m] and velocity [m/s] of a fuel at a hub's exit, field frame, shape (3,) each."""
    half = 0.5 * dim.HUB_EXIT_WIDTH - FUEL.bounding_radius
    low, high = dim.HUB_EXIT_BOTTOM + FUEL.bounding_radius, dim.HUB_EXIT_TOP - FUEL.bounding_radius
    fan, dip = rng.uniform(-_FAN, _FAN), _DIP + rng.uniform(-_DIP_SPREAD, _DIP_SPREAD)
    speed = _SPEED + rng.uniform(-_SPEED_SPREAD, _SPEED_SPREAD)
    y, z = dim.HUB_CENTER[1] + rng.uniform(-half, half), rng.uniform(low, high)
    pos = np.array([dim.HUB_EXIT_X + FUEL.bounding_radius + 0.005, y, z])
    level = speed * math.cos(dip)
    vel = np.array([level * math.cos(fan), level * math.sin(fan), -speed * math.sin(dip)])
    if alliance == "red":
        pos, vel = FIELD.symmetry.flip_points(pos[None])[0], FIELD.symmetry.flip_vectors(vel[None])[0]
    return pos, vel


def own_first(match: PlayedMatch) -> list[tuple[Alliance, np.random.Generator]]:
    """Return each alliance with a random generator, first the alliance of the first robot.

    Because of this order, a match with a red first robot is the image of the match with a blue first robot under the
    symmetry of the field.
    """
    own = match.entries[0].alliance
    return list(zip((own, other_alliance(own)), match.rules_rng.spawn(2), strict=True))


class FuelWays:
    """Fuel inside the hubs and outside the field in one match.

    Args:
        match: Match with staged pieces.
    """

    def __init__(self, match: PlayedMatch) -> None:
        self._match = match
        self._rng = dict(own_first(match))
        self._hubs: dict[Alliance, deque[tuple[float, int]]] = {alliance: deque() for alliance in self._rng}
        self._last = dict.fromkeys(self._rng, -math.inf)
        self._outside: dict[int, tuple[float, float, float]] = {}  # by slot: time and position of the return [s, m, m]

    def in_hub(self, alliance: Alliance) -> int:
        """Return the number of fuel inside a hub."""
        return len(self._hubs[alliance])

    def enter_hub(self, alliance: Alliance, slot: int) -> None:
        """Put a scored fuel into a hub's queue for the exit; without the option `HUB_EXITS`, do nothing."""
        if HUB_EXITS in self._match.options:
            self._match.pieces.set_aside(np.array([slot]))
            delay = _DELAY + self._rng[alliance].uniform(-_DELAY_SPREAD, _DELAY_SPREAD)
            self._hubs[alliance].append((self._match.time + delay, slot))

    def leave_field(self, slot: int) -> bool:
        """Remove a fuel outside the field until field staff return the fuel 3 to 8 s later.

        Returns:
            Whether the fuel was removed; False for a fuel without a finite position.
        """
        pieces = self._match.pieces
        x, y = pieces.state.pos[slot, :2].tolist()
        if not math.isfinite(x + y):
            return False
        near: Alliance = "blue" if x < dim.FIELD_CENTER[0] else "red"
        pieces.score(np.array([slot]))
        pieces.set_aside(np.array([slot]))
        self._outside[slot] = self._match.time + self._rng[near].uniform(*_CREW), x, y
        return True

    def act(self) -> list[int]:
        """Release fuel from the hubs and return fuel to the field, when due.

        Returns:
            Slots of the fuel released from the hubs.
        """
        match, out = self._match, []
        for alliance, queue in self._hubs.items():
            if queue and queue[0][0] <= match.time and match.time - self._last[alliance] > _PERIOD - 0.5 * TICK:
                _, slot = queue.popleft()
                pos, vel = hub_exit(alliance, self._rng[alliance])
                match.pieces.release(np.array([slot]), pos[None])
                match.pieces.push(np.array([slot]), vel[None], flying=True)
                self._last[alliance] = match.time
                out.append(slot)
        for slot in [slot for slot, (due, _, _) in self._outside.items() if due <= match.time]:
            _, x, y = self._outside.pop(slot)
            match.pieces.put_down(np.array([slot]), np.array([[x, y]]))
        return out

"""Staging of the 126 coral and 18 algae at the start of a match."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from games.reefscape import dimensions as dim
from games.reefscape.field import ALLIANCES, FIELD
from games.reefscape.pieces import ALGAE, CORAL
from simcore.errors import ConfigError
from simcore.match.game import RobotEntry, StagedPieces
from simcore.match.scoring import Alliance
from simcore.typing import FloatArray

__all__ = ["ALGAE_COUNT", "CORAL_COUNT", "ROBOTS", "STATION_STOCK", "mark_places", "reef_algae_places", "stage"]

ROBOTS = 6
STATION_STOCK = 60
"""Number of coral for the two stations of an alliance, including the preloads of robots."""
CORAL_COUNT = 2 * (STATION_STOCK + len(dim.MARK_YS))
ALGAE_COUNT = 2 * (6 + len(dim.MARK_YS))
_ABOVE_BORE = 0.5 * math.sqrt(dim.ALGAE_DIAMETER**2 - dim.CORAL_INNER_DIAMETER**2)  # [m] from coral end to algae center
_LODGED = 20.0  # [N]; force that pulls an algae out along the reef's pipes; estimate: teams report 15 to 30
_JITTER = 0.001  # [m] to either side: scatter of placement by hand


def mark_places() -> FloatArray:
    """Return the centers of the three marks for blue's staged pieces on the carpet, field frame [m], shape (3, 2)."""
    return np.array([(dim.MARK_X, y) for y in dim.MARK_YS])


def reef_algae_places() -> FloatArray:
    """Return the centers of the six algae on blue's reef, one per face, alternately high and low [m], shape (6, 3)."""
    low, high = dim.REEF_ALGAE_HEIGHTS
    (cx, cy), r = dim.REEF_CENTER, dim.REEF_ALGAE_RADIUS
    places = []
    for face, yaw_deg in enumerate(dim.REEF_FACE_YAWS_DEG):
        yaw = math.radians(yaw_deg)
        z = high if face in dim.HIGH_ALGAE_FACES else low
        places.append((cx + r * math.cos(yaw), cy + r * math.sin(yaw), z))
    return np.array(places)


def stage(rng: np.random.Generator, entries: Sequence[RobotEntry]) -> list[StagedPieces]:
    """Return the staged pieces of a match with a blue first robot; unused preloads are at the stations.

    Raises:
        ConfigError: If a robot's preload is more than one coral.
    """
    preloads = 0
    for entry in entries:
        if entry.preload is not None and entry.preload > 1:
            raise ConfigError(f"a robot of REEFSCAPE begins with one coral at most, got {entry.preload}")
        preloads += 1 if entry.preload is None else entry.preload
    staged = []
    for alliance in ALLIANCES:
        marks = mark_places() + rng.uniform(-_JITTER, _JITTER, (len(dim.MARK_YS), 2))
        coral = np.column_stack([marks, np.full(len(marks), CORAL.rest_height)])
        on_top = np.column_stack([marks, np.full(len(marks), dim.CORAL_LENGTH + _ABOVE_BORE)])
        on_reef = _of_alliance(alliance, reef_algae_places())
        staged.append(StagedPieces(kind=CORAL.name, positions=_of_alliance(alliance, coral)))
        staged.append(StagedPieces(kind=ALGAE.name, positions=_of_alliance(alliance, on_top), resting=True))
        staged.append(StagedPieces(kind=ALGAE.name, positions=on_reef, lodged=_LODGED))
    return [*staged, StagedPieces(kind=CORAL.name, off_field=2 * STATION_STOCK - preloads)]


def _of_alliance(alliance: Alliance, places: FloatArray) -> FloatArray:
    return places if alliance == "blue" else FIELD.symmetry.flip_points(places)

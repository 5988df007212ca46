"""How pieces move through a hopper: its outlet, its inlet, its floor and belt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from simcore.errors import ConfigError
from simcore.physics.contact_law import FOAM, WALL, pair_friction
from simcore.quantities import FRICTION, RATIO, ROBOT_LENGTH, ROBOT_PLACE, Quantity, require_fields

__all__ = ["FACES", "OPPOSITE", "HopperConfig", "Side"]

Side: TypeAlias = Literal["front", "back", "left", "right", "bottom"]
FACES: dict[str, tuple[int, int]] = {
    "front": (0, 1), "back": (0, -1), "left": (1, 1), "right": (1, -1), "bottom": (2, -1)
}  # fmt: skip
"""Axis of each side's normal, and which way it points."""
OPPOSITE: dict[str, Side] = {"front": "back", "back": "front", "left": "right", "right": "left", "bottom": "back"}
_LEAN = Quantity("rad", 0.0, 1.2)


@dataclass(frozen=True, slots=True, kw_only=True)
class HopperConfig:
    """How pieces move through a storage; the box is that of its `StorageConfig`."""

    outlet: Side = "front"
    """Side with the opening to the shooter."""
    outlet_width: float
    """Across, along y (in the left or right side along x) [m]. Two balls can bridge one below two diameters."""
    outlet_height: float | None = None
    """Of the opening, of one in the bottom along x [m]; None: as the width."""
    outlet_place: tuple[float, float] | None = None
    """Its middle, across and up (of one in the bottom along y and x), robot frame [m]; None: in the middle of the side,
    down at the floor."""
    inlet: Side | None = None
    """Wall at whose top intakes put pieces in; None: opposite the outlet."""
    belt: str | None = None
    """Mechanism that moves what lies on the floor toward the outlet, or away from the inlet if the outlet is in the
    bottom; None: nothing does."""
    belt_travel: float = 0.025
    """Way of a piece per radian of that mechanism [m]: radius of its roller, half of it where pieces roll along a fixed
    ceiling; negative if it turns backward to feed."""
    funnel: float = 0.0
    """By which angle the walls beside the opening lean toward it [rad]; 0: pieces in its dead corners stay there."""
    slope: float = 0.0
    """Of the floor, down to an outlet in a wall [rad]."""
    friction: float = pair_friction(FOAM.friction, WALL.friction)
    """Coulomb coefficient of pieces on the belt, and in an arch at its ends and between them [-]. Estimate: 0.4, as of
    foam on a wall; of foam on foam it may be 0.6."""

    def __post_init__(self) -> None:
        require_fields(
            self, outlet_width=ROBOT_LENGTH, outlet_height=ROBOT_LENGTH, outlet_place=(ROBOT_PLACE,) * 2,
            belt_travel=RATIO, funnel=_LEAN, slope=_LEAN, friction=FRICTION,
        )  # fmt: skip
        for name, known in (("outlet", (*FACES,)), ("inlet", (None, *FACES)[:-1])):
            if getattr(self, name) not in known:
                names = ", ".join(side for side in known if side)
                raise ConfigError(f"HopperConfig: {name} must be one of {names}, got {getattr(self, name)!r}")
        if self.slope and self.outlet == "bottom":
            raise ConfigError("HopperConfig: a floor with a slope needs an outlet in a wall, got 'bottom'")

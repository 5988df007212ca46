"""What every piece of one kind has in common."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from simcore.errors import ConfigError
from simcore.physics.shapes import Box, Cylinder, Sphere
from simcore.physics.surface import TerrainSurface
from simcore.pieces.aerodynamics import Aerodynamics, AirFactors, air_factors
from simcore.quantities import MASS, ROBOT_HEIGHT, ROBOT_LENGTH, require, require_fields
from simcore.units import GRAVITY

__all__ = ["GamePieceConfig"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GamePieceConfig:
    """One kind of game piece."""

    name: str
    """As the manual and the telemetry keys say it, e.g. `Ball`."""
    shape: Sphere | Cylinder | Box
    """Collision shape; a cylinder stands on its flat side, a box lies on its xy face."""
    mass: float
    """Mass [kg]."""
    friction: float = 0.8
    """Coulomb friction factor; a pair has the product of both sides [-]."""
    restitution: float = 0.5
    """Bounce factor; a pair has the product of both sides [-], 0 to 1."""
    rolling: float = 0.0
    """Rolling resistance lever arm of the piece itself [m]; what it rolls on adds its own."""
    stiffness: float = 1e5
    """Of a contact under load, force over depth [N/m]: a piece that a robot presses against a wall with 600 N gives way
    by 6 mm on each side. Estimate for dense foam, within a factor of 3; softer pieces need more sub-steps."""
    color: str = "#f2c511"
    """Of its drawings, `#rrggbb`."""
    aerodynamics: Aerodynamics | None = None
    """Drag and spin lift; None for a piece that no air acts on."""

    def __post_init__(self) -> None:
        if not self.name or "/" in self.name:
            raise ConfigError(f"GamePieceConfig: name must be non-empty without '/', got {self.name!r}")
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", self.color):
            raise ConfigError(f"{self.name}: color must be '#rrggbb', got {self.color!r}")
        require_fields(self, self.name, mass=MASS, rolling=ROBOT_HEIGHT)
        require(self.name, "radius around its shape", self.bounding_radius, ROBOT_LENGTH)
        if self.air.lift > 0.0 and not isinstance(self.shape, Sphere):
            raise ConfigError(f"{self.name}: spin lift is for spheres, got a {type(self.shape).__name__}")
        self.surface  # noqa: B018  (checks friction and restitution)

    @property
    def surface(self) -> TerrainSurface:
        """The contact material of the piece."""
        return TerrainSurface(
            name=self.name,
            friction=self.friction,
            restitution=self.restitution,
            rolling=self.rolling,
            stiffness=self.stiffness,
        )

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around the center that holds the piece [m]."""
        shape = self.shape
        if isinstance(shape, Sphere):
            return shape.radius
        if isinstance(shape, Cylinder):
            return math.hypot(shape.radius, shape.height / 2)
        return 0.5 * math.hypot(*shape.size)

    @property
    def inner_radius(self) -> float:
        """Radius of the largest ball around the center that the piece holds [m]."""
        shape = self.shape
        if isinstance(shape, Sphere):
            return shape.radius
        return min(shape.radius, shape.height / 2) if isinstance(shape, Cylinder) else min(shape.size) / 2

    @property
    def rest_height(self) -> float:
        """Height of the center above flat ground when staged [m]."""
        shape = self.shape
        if isinstance(shape, Sphere):
            return shape.radius
        return shape.height / 2 if isinstance(shape, Cylinder) else shape.size[2] / 2

    @property
    def air(self) -> AirFactors:
        """What the air does to it; other shapes than balls count as the ball of the same frontal area."""
        if self.aerodynamics is None:
            return AirFactors()
        shape = self.shape
        if isinstance(shape, Sphere):
            radius = shape.radius
        elif isinstance(shape, Cylinder):
            radius = math.sqrt(2.0 * shape.radius * shape.height / math.pi)
        else:
            radius = math.sqrt(shape.size[0] * shape.size[2] / math.pi)
        return air_factors(self.aerodynamics, radius=radius, mass=self.mass)

    @property
    def aero_speed(self) -> float:
        """Speed above which drag exceeds 3 % of the weight [m/s]; slower pieces have drag only while in flight."""
        k = self.air.drag
        return math.sqrt(0.03 * GRAVITY / k) if k > 0.0 else math.inf

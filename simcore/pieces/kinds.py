"""Kinds of game pieces, and the variation of single pieces."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError
from simcore.pieces.aerodynamics import Aerodynamics, AirFactors, air_factors
from simcore.quantities import MASS, ROBOT_HEIGHT, ROBOT_LENGTH, STIFFNESS, require, require_fields
from simcore.typing import FloatArray
from simcore.world.contact_law import FOAM, FOAM_STIFFNESS, FoamStiffness, TerrainSurface
from simcore.world.rotation import Quaternion
from simcore.world.shapes import (
    Box,
    Compound,
    Cylinder,
    Hull,
    Sphere,
    bounding_radius,
    inner_radius,
    mass_properties,
    mean_frontal_area,
    smallest_thickness,
    stands,
    support_height,
)

__all__ = ["GamePieceConfig", "PieceVariation"]

_MOST_PARTS = 32
_DENSE_FROM, _DENSE_TO, _DENSE_ENERGY = 0.6, 0.9, 300.0  # of the radius, and [J]; see `GamePieceConfig.foam`
_STIFFEST = 2.5e6  # largest k / m of a ball [1/s^2]; stiffer balls in a collision may overlap deeply within a step
_OFF_CENTER = 0.01  # largest distance of the center of mass from the origin, as a fraction of the bounding radius
_THINNEST = 0.003  # [m]; PyBullet rounds the edges of hulls with a radius of 1 mm


@dataclass(frozen=True, slots=True, kw_only=True)
class GamePieceConfig:
    """Config of a kind of game piece: shape, mass, contact surface, aerodynamics and color."""

    name: str
    """Name in the manual and in telemetry keys, for example `Ball`."""
    shape: Sphere | Cylinder | Box | Hull | Compound
    """Collision shape, with the origin at the center of mass. The z axis of the shape points up if the piece stands
    upright. `simcore.world.shapes` has tubes, tori and cones, and `centered` to move the origin."""
    mass: float
    """Mass [kg]."""
    friction: float = FOAM.friction
    """Friction factor [-]; the coefficient of friction of a pair is the product of the two factors."""
    restitution: float = FOAM.restitution
    """Restitution factor, 0 to 1 [-]; the coefficient of restitution of a pair is the product of the two factors."""
    rolling: float = 0.0
    """Rolling resistance lever arm of the piece [m]; the lever arm of the other surface adds to this value."""
    stiffness: float | FoamStiffness | None = None
    """Contact stiffness on one side of the piece [N/m], or the stiffness of foam for a ball. The limit for a ball is
    2.5e6 N/m per kg at a compression of a tenth of the radius. None for 1e5 N/m, or for the limit if that is lower."""
    color: str = "#f2c511"
    """Color in drawings, `#rrggbb`."""
    aerodynamics: Aerodynamics | None = None
    """Drag and spin lift; None for a piece without aerodynamic forces."""

    def __post_init__(self) -> None:
        require_fields(self, self.name, mass=MASS, rolling=ROBOT_HEIGHT)
        if not self.name or "/" in self.name:
            raise ConfigError(f"GamePieceConfig: name must be non-empty without '/', got {self.name!r}")
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", self.color):
            raise ConfigError(f"{self.name}: color must be '#rrggbb', got {self.color!r}")
        if isinstance(self.stiffness, FoamStiffness):
            if not isinstance(self.shape, Sphere):
                raise ConfigError(f"{self.name}: a FoamStiffness is for spheres, got a {type(self.shape).__name__}")
        elif self.stiffness is not None:
            require(self.name, "stiffness", self.stiffness, STIFFNESS)
        if isinstance(self.shape, Sphere):
            self._check_foam()
        elif not isinstance(self.shape, Cylinder | Box):
            self._check_shape()
        require(self.name, "radius around its shape", self.bounding_radius, ROBOT_LENGTH)
        if self.air.lift > 0.0 and not isinstance(self.shape, Sphere):
            raise ConfigError(f"{self.name}: spin lift is for spheres, got a {type(self.shape).__name__}")
        self.surface  # noqa: B018  (checks friction and restitution)

    def _check_foam(self) -> None:
        """Raise `ConfigError` if a ball is too stiff for the ball's mass; the loop could not simulate the contacts."""
        linear, cubic, _, _ = self.foam
        stiffness = linear + 3.0 * cubic * (0.1 * self.bounding_radius) ** 2
        if stiffness > _STIFFEST * self.mass:
            raise ConfigError(
                f"{self.name}: a stiffness of {stiffness:.3g} N/m is too much for a ball of {self.mass:.3g} kg; at "
                f"most {_STIFFEST * self.mass:.3g} N/m can be simulated, or at least {stiffness / _STIFFEST:.3g} kg"
            )

    def _check_shape(self) -> None:
        """Raise `ConfigError` if a shape has too many parts, an origin off the center of mass, or a part too thin."""
        shape = self.shape
        if isinstance(shape, Compound) and len(shape.parts) > _MOST_PARTS:
            raise ConfigError(
                f"{self.name}: {len(shape.parts)} parts are too many to be simulated, at most {_MOST_PARTS} are"
            )
        center = mass_properties(shape).center
        if float(np.abs(center).max()) > _OFF_CENTER * bounding_radius(shape):
            x, y, z = center.tolist()
            raise ConfigError(
                f"{self.name}: the origin of its shape must be its center of mass, which is at ({x:.4g}, {y:.4g}, "
                f"{z:.4g}) m; give `centered(shape)` of simcore.world.shapes"
            )
        thickness = smallest_thickness(shape)
        if thickness < _THINNEST:
            raise ConfigError(
                f"{self.name}: a part is {1e3 * thickness:.2g} mm thick, engines need {1e3 * _THINNEST:.0f} mm; make "
                "it thicker"
            )

    @property
    def foam(self) -> tuple[float, float, float, float]:
        """Parameters k1 [N/m], k3 [N/m^3], d0 [m] and k2 [N/m^2] of a ball in `simcore.loop.contact.foam_force`.

        Foam that is compressed by more than 60 % of the radius becomes dense and hard. An energy of 300 J (half of a
        robot's energy at 4.6 m/s) compresses the foam by 90 %. These values are estimates, because no value for the
        bottoming out of foam balls is published.
        """
        s, radius = self._one_side, self.bounding_radius
        linear, cubic = (s.linear, s.cubic) if isinstance(s, FoamStiffness) else (s, 0.0)
        return linear, cubic, _DENSE_FROM * radius, 3.0 * _DENSE_ENERGY / ((_DENSE_TO - _DENSE_FROM) * radius) ** 3

    @property
    def surface(self) -> TerrainSurface:
        """Surface of the piece for contacts in the loop and in the engine."""
        return TerrainSurface(
            name=self.name,
            friction=self.friction,
            restitution=self.restitution,
            rolling=self.rolling,
            stiffness=None if isinstance(self._one_side, FoamStiffness) else self._one_side,
        )

    @property
    def _one_side(self) -> float | FoamStiffness:
        """Contact stiffness on one side: `stiffness`, or the default if `stiffness` is None [N/m]."""
        if self.stiffness is not None:
            return self.stiffness
        return min(FOAM_STIFFNESS, _STIFFEST * self.mass) if isinstance(self.shape, Sphere) else FOAM_STIFFNESS

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest sphere around the center that contains the piece [m]."""
        return bounding_radius(self.shape)

    @property
    def inner_radius(self) -> float:
        """Radius of the largest sphere around the center inside the piece, with cavities filled [m]."""
        return inner_radius(self.shape)

    @property
    def rest_height(self) -> float:
        """Height of the center of an upright piece above flat ground [m]."""
        return support_height(self.shape)

    def rest_height_at(self, quat: Quaternion) -> float:
        """Return the height of the center above flat ground for a piece at rest in an attitude x, y, z, w [m]."""
        return support_height(self.shape, quat)

    def stands_at(self, quat: Quaternion) -> bool:
        """Return whether the piece stands stably on flat ground in an attitude x, y, z, w."""
        return stands(self.shape, quat)

    @property
    def air(self) -> AirFactors:
        """Aerodynamic factors; a piece that is not a ball has the factors of a ball with the same mean frontal area."""
        if self.aerodynamics is None:
            return AirFactors()
        shape = self.shape
        radius = shape.radius if isinstance(shape, Sphere) else math.sqrt(mean_frontal_area(shape) / math.pi)
        return air_factors(self.aerodynamics, radius=radius, mass=self.mass)


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceVariation:
    """Variation of single pieces: factors on the values of the kind, one per slot of the pool, shape (n,).

    Mass and restitution also apply to bodies in the engine. The diameter changes the aerodynamics and spin of a piece,
    and the effect of a shooter's wheels. The collision shape keeps the size of the kind, because half of 1 % of a
    diameter of 15 cm is less than the contact margin of 3 mm.
    """

    mass: FloatArray
    """Factor on the mass of each piece [-]."""
    diameter: FloatArray
    """Factor on the diameter of each piece [-]."""
    restitution: FloatArray
    """Factor on the restitution factor of each piece [-]."""
    drag: FloatArray
    """Factor on the drag coefficient of each piece [-]."""

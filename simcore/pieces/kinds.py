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
_STIFFEST = 2.5e6  # k / m of a ball [1/s^2]; a stiffer one thrown at another may overlap it deeply within a step
_OFF_CENTER = 0.01  # fraction of the bounding radius that the center of mass may be off the origin
_THINNEST = 0.003  # [m]; PyBullet rounds the edges of hulls with 1 mm


@dataclass(frozen=True, slots=True, kw_only=True)
class GamePieceConfig:
    """One kind of game piece."""

    name: str
    """Name as in the manual and in telemetry keys, e.g. `Ball`."""
    shape: Sphere | Cylinder | Box | Hull | Compound
    """Collision shape, with its origin at the center of mass (`simcore.world.shapes` has tubes, rings and
    cones, and `centered`). The piece stands on the ground with the z axis of its shape up."""
    mass: float
    """Mass [kg]."""
    friction: float = FOAM.friction
    """Coulomb friction factor; a pair has the product of both [-]."""
    restitution: float = FOAM.restitution
    """Restitution factor; a pair has the product of both [-], 0 to 1."""
    rolling: float = 0.0
    """Rolling resistance lever arm of the piece itself [m]; the surface adds its own."""
    stiffness: float | FoamStiffness | None = None
    """Contact stiffness on one side: for balls that of foam; for other shapes force over depth [N/m]. A ball has at
    most 2.5e6 N/m per kg at a compression of a tenth of its radius. None: 1e5 N/m, or that limit below 40 g."""
    color: str = "#f2c511"
    """Color of its drawings, `#rrggbb`."""
    aerodynamics: Aerodynamics | None = None
    """Drag and spin lift; None: air does not affect the piece."""

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
        """Refuse a ball that is too stiff for its mass: no step of the loop holds it."""
        linear, cubic, _, _ = self.foam
        stiffness = linear + 3.0 * cubic * (0.1 * self.bounding_radius) ** 2
        if stiffness > _STIFFEST * self.mass:
            raise ConfigError(
                f"{self.name}: a stiffness of {stiffness:.3g} N/m is too much for a ball of {self.mass:.3g} kg; at "
                f"most {_STIFFEST * self.mass:.3g} N/m can be simulated, or at least {stiffness / _STIFFEST:.3g} kg"
            )

    def _check_shape(self) -> None:
        """Refuse shapes that engines do not simulate well."""
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
        """Foam law of a ball: the four numbers of `simcore.loop.contact.foam_force`.

        Foam squeezed by more than 60 % of the radius becomes dense and hard: so hard that 300 J, half of a robot's
        energy at 4.6 m/s, squeeze it by 90 %. Estimate: there is no published figure for where foam balls bottom out.
        """
        s, radius = self._one_side, self.bounding_radius
        linear, cubic = (s.linear, s.cubic) if isinstance(s, FoamStiffness) else (s, 0.0)
        return linear, cubic, _DENSE_FROM * radius, 3.0 * _DENSE_ENERGY / ((_DENSE_TO - _DENSE_FROM) * radius) ** 3

    @property
    def surface(self) -> TerrainSurface:
        """Contact material of the piece."""
        return TerrainSurface(
            name=self.name,
            friction=self.friction,
            restitution=self.restitution,
            rolling=self.rolling,
            stiffness=None if isinstance(self._one_side, FoamStiffness) else self._one_side,
        )

    @property
    def _one_side(self) -> float | FoamStiffness:
        """How it gives way, where its config does not say as well."""
        if self.stiffness is not None:
            return self.stiffness
        return min(FOAM_STIFFNESS, _STIFFEST * self.mass) if isinstance(self.shape, Sphere) else FOAM_STIFFNESS

    @property
    def bounding_radius(self) -> float:
        """Radius of the smallest ball around the center that contains the piece [m]."""
        return bounding_radius(self.shape)

    @property
    def inner_radius(self) -> float:
        """Radius of the largest ball around the center inside of the piece, cavities included [m]."""
        return inner_radius(self.shape)

    @property
    def rest_height(self) -> float:
        """Height of the center above flat ground while the piece stands with its z axis up [m]."""
        return support_height(self.shape)

    def rest_height_at(self, quat: Quaternion) -> float:
        """Return the height of the center above flat ground that the piece touches in an attitude x, y, z, w [m]."""
        return support_height(self.shape, quat)

    def stands_at(self, quat: Quaternion) -> bool:
        """Return whether the piece stays in an attitude x, y, z, w on flat ground."""
        return stands(self.shape, quat)

    @property
    def air(self) -> AirFactors:
        """Aerodynamic factors; shapes other than balls count as the ball of equal mean frontal area."""
        if self.aerodynamics is None:
            return AirFactors()
        shape = self.shape
        radius = shape.radius if isinstance(shape, Sphere) else math.sqrt(mean_frontal_area(shape) / math.pi)
        return air_factors(self.aerodynamics, radius=radius, mass=self.mass)


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceVariation:
    """Factors of single pieces, one per slot of the pool, shape (n,).

    Mass and restitution also apply to the bodies in the engine. The diameter changes the aerodynamics of a piece, its
    spin and the effect of a shooter's wheels; its body keeps the size of its kind: half of 1 % of a diameter of 15 cm
    is less than the contact margin of 3 mm.
    """

    mass: FloatArray
    diameter: FloatArray
    restitution: FloatArray
    drag: FloatArray
    """Factor on the drag coefficient [-]."""

"""Robot as a rigid body: shape, mass, center of mass, inertia and moving masses.

The mass, center of mass and moments of inertia in a robot's config apply to the whole robot at the start, without game
pieces. The body is the robot without moving masses. Moving masses and held pieces are point masses. The body keeps the
moment of inertia of each moving mass about the center of this mass. The model ignores the moment of inertia of each
piece about the center of the piece (0.02 kg m^2 for 50 balls of 0.215 kg).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from simcore.errors import ConfigError
from simcore.quantities import FRICTION, INERTIA, MASS, ROBOT_LENGTH, ROBOT_PLACE, require_fields
from simcore.robot.fixed_wheel_config import FixedWheelConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.units import plain_sum
from simcore.world.contact_law import BUMPER, BUMPER_CLOTH, RUBBER, TerrainSurface
from simcore.world.linkage import Joint, MechanismMotion, part_pose
from simcore.world.robot_dynamics import BumperPart
from simcore.world.rotation import Vector
from simcore.world.shapes import Box, Compound, Part, Sphere

__all__ = [
    "BUMPER_STIFFNESS",
    "FRAME_STIFFNESS",
    "ChassisConfig",
    "MassDistribution",
    "MovingMass",
    "PointMass",
    "moved_points",
    "with_points",
]

PointMass: TypeAlias = tuple[float, Vector]
"""Mass [kg] and position in the robot frame [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingMass:
    """Part of the robot's mass that mechanisms move, such as an elevator stage, a carriage or an arm."""

    name: str
    mass: float
    """Mass of the part, included in the mass of the whole robot [kg]."""
    joints: tuple[Joint, ...]
    """Joints that move the part, from the robot outward."""
    center: Vector = (0.0, 0.0, 0.0)
    """Center of mass in the frame after the last joint [m]."""

    def __post_init__(self) -> None:
        require_fields(self, f"moving mass {self.name!r}", mass=MASS, center=(ROBOT_PLACE,) * 3)
        if not self.joints:
            raise ConfigError(f"moving mass {self.name!r}: it needs a joint that moves it")


class MassDistribution(NamedTuple):
    """Mass properties of a rigid body in the robot frame.

    The axes are x forward, y left and z up. The origin is on the floor, below the center of the robot.
    """

    mass: float
    """Mass [kg]."""
    center: Vector
    """Center of mass [m]."""
    inertia: Vector
    """Moments of inertia about the axes through the center of mass parallel to the robot axes [kg m^2].

    The model ignores products of inertia: the wheels limit roll and pitch, and products of inertia do not affect yaw.
    """


def moved_points(parts: Iterable[MovingMass], mechanisms: Mapping[str, MechanismMotion]) -> list[PointMass]:
    """Return the moving masses as point masses at the current positions of the mechanisms."""
    return [(part.mass, part_pose(part.joints, mechanisms, part.center)[0]) for part in parts]


def with_points(body: MassDistribution, points: Iterable[PointMass]) -> MassDistribution:
    """Combine a body and point masses into one rigid body; negative masses remove points from the body.

        m = sum m_i,   c = sum m_i r_i / m,   I_x = sum (I_xi + m_i (y_i^2 + z_i^2)) - m (c_y^2 + c_z^2), ...

    >>> whole = with_points(MassDistribution(30.0, (0.0, 0.0, 0.2), (2.0, 2.0, 3.0)), [(10.0, (0.0, 0.0, 0.6))])
    >>> whole.mass, round(whole.center[2], 6), [round(moment, 6) for moment in whole.inertia]
    (40.0, 0.3, [3.2, 3.2, 3.0])
    """
    m0, (x0, y0, z0), (ix, iy, iz) = body
    # Sums are about the body's center of mass, so that the result without points is bit-identical to the body.
    mass = m0
    sx = sy = sz = xx = yy = zz = 0.0
    for m, (x, y, z) in points:
        x, y, z = x - x0, y - y0, z - z0
        mass += m
        sx, sy, sz = sx + m * x, sy + m * y, sz + m * z
        xx, yy, zz = xx + m * x * x, yy + m * y * y, zz + m * z * z
    cx, cy, cz = sx / mass, sy / mass, sz / mass
    xx, yy, zz = xx - sx * cx, yy - sy * cy, zz - sz * cz
    return MassDistribution(mass, (x0 + cx, y0 + cy, z0 + cz), (ix + yy + zz, iy + xx + zz, iz + xx + yy))


BUMPER_STIFFNESS = 1e6
"""Contact stiffness of bumpers: force per depth and per length of contact [N/m^2]; estimate, within a factor of 2.

The value is E x height / thickness for pool noodles 2.5 in (0.0635 m) thick and together 5 in (0.127 m) high, on rigid
plywood. Young's modulus E of polyethylene foam is about 0.5 MPa. The bumpers compress by 1 mm when a robot pushes
against a wall with full traction, and by 11 mm in a flat impact on a wall at 3 m/s.
"""
FRAME_STIFFNESS = 4e6
"""Contact stiffness of the frame above the bumpers, with aluminum tubes and mounted parts [N/m^2]; estimate, within a
factor of 3."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChassisConfig:
    """Mass, shape and wheels of a robot; the defaults describe a 55 kg robot with bumpers of 0.8 x 0.8 m."""

    mass: float = 55.0
    """Mass of the robot with bumpers and battery [kg]."""
    bumper_length: float = 0.8
    """Length over the bumpers, along x [m]."""
    bumper_width: float = 0.8
    """Width over the bumpers, along y [m]."""
    clearance: float = 0.05
    """Ground clearance of frame and bumpers [m]."""
    bumper_top: float = 0.25
    """Height of the upper edge of the bumpers above the carpet [m]."""
    height: float = 0.5
    """Height of the top of the frame above the carpet [m]."""
    bumper_thickness: float = 0.085
    """Distance from the outside of the bumpers to the frame [m]. The 2026 manual, R4xx, has 3.25 in of noodle and
    plywood."""
    bay: tuple[float, float] | None = None
    """Depth and width of an opening in the back of bumpers and frame, for example for a climber [m]; None for a closed
    back."""
    center_of_mass_height: float = 0.2
    """Height of the center of mass above the carpet [m]."""
    yaw_inertia: float | None = None
    """Yaw moment of inertia about the center of mass [kg m^2]; None for the value of a uniform plate with the size of
    the bumpers."""
    wheel_positions: tuple[tuple[float, float], ...] = (
        (0.2667, 0.2667),
        (0.2667, -0.2667),
        (-0.2667, 0.2667),
        (-0.2667, -0.2667),
    )
    """Centers of the wheels, robot frame [m]."""
    wheel_radius: float = 0.0508
    """Radius of the wheels [m]."""
    friction: float = RUBBER.friction
    """Coefficient of friction of treads on carpet, used without a drivetrain model [-]."""
    surface: TerrainSurface = BUMPER
    """Contact properties of bumpers and frame against game pieces. Contacts with walls and robots use only the
    restitution factor."""
    bumper_friction: float = BUMPER_CLOTH
    """Friction factor of the bumper fabric against walls and robots [-]."""

    def __post_init__(self) -> None:
        owner = "ChassisConfig"
        require_fields(
            self,
            mass=MASS,
            bumper_length=ROBOT_LENGTH,
            bumper_width=ROBOT_LENGTH,
            clearance=ROBOT_LENGTH,
            bumper_top=ROBOT_LENGTH,
            height=ROBOT_LENGTH,
            bumper_thickness=ROBOT_LENGTH,
            bay=(ROBOT_LENGTH, ROBOT_LENGTH),
            center_of_mass_height=ROBOT_LENGTH,
            yaw_inertia=INERTIA,
            wheel_radius=ROBOT_LENGTH,
            friction=FRICTION,
            bumper_friction=FRICTION,
            wheel_positions=[(ROBOT_PLACE, ROBOT_PLACE)],
        )
        if not self.clearance < self.bumper_top <= self.height:
            raise ConfigError(
                f"{owner}: clearance < bumper_top <= height must hold, got {self.clearance}, {self.bumper_top}, "
                f"{self.height} m"
            )
        inset = 2.0 * self.bumper_thickness
        if self.bay is not None and not (
            self.bumper_thickness < self.bay[0] < self.bumper_length - self.bumper_thickness
            and self.bay[1] < self.bumper_width - inset
        ):
            raise ConfigError(f"{owner}: bay must leave frame in front and on both sides, got {self.bay} m")
        if len(self.wheel_positions) < 3:
            raise ConfigError(
                f"{owner}: wheel_positions must have at least 3 wheels to stand on, got {len(self.wheel_positions)}"
            )
        for x, y in self.wheel_positions:
            if abs(x) > self.bumper_length / 2 or abs(y) > self.bumper_width / 2:
                raise ConfigError(f"{owner}: wheel at ({x}, {y}) m lies outside of the bumpers")

    @classmethod
    def around(cls, drivetrain: SwerveConfig | FixedWheelConfig, *, bumper: tuple[float, float]) -> ChassisConfig:
        """Return a chassis config with the mass properties and wheels of a drivetrain; other fields have defaults.

        Args:
            drivetrain: Drivetrain of the robot.
            bumper: Length and width over the bumpers [m].

        Raises:
            ConfigError: If a wheel is outside the bumpers or there are fewer than three wheels.
        """
        return cls(
            mass=drivetrain.mass,
            bumper_length=bumper[0],
            bumper_width=bumper[1],
            center_of_mass_height=drivetrain.center_of_mass[2],
            yaw_inertia=drivetrain.yaw_inertia,
            wheel_positions=drivetrain.wheel_positions,
            wheel_radius=drivetrain.wheel_radius,
            friction=drivetrain.wheel_cof,
        )

    @property
    def inertia(self) -> Vector:
        """Moments of inertia of a uniform box of the robot's size about the center of mass [kg m^2].

        The moment of inertia about z is `yaw_inertia` instead, if given.
        """
        a, b, c, m = self.bumper_length, self.bumper_width, self.height, self.mass
        yaw = self.yaw_inertia if self.yaw_inertia is not None else m * (a * a + b * b) / 12.0
        return (m * (b * b + c * c) / 12.0, m * (a * a + c * c) / 12.0, yaw)

    @property
    def shape(self) -> Compound:
        """Collision shape in the robot frame: boxes for bumpers and frame, spheres for wheels."""
        return _shape(self)

    @property
    def bumpers(self) -> tuple[BumperPart, ...]:
        """Parts that collide with walls and robots: the bumpers, and the frame above the bumpers."""
        inset = 2.0 * self.bumper_thickness
        length, width = self.bumper_length, self.bumper_width
        layers = [(length, width, self.clearance, self.bumper_top, BUMPER_STIFFNESS)]
        if self.height > self.bumper_top and min(length, width) > inset:
            layers.append((length - inset, width - inset, self.bumper_top, self.height, FRAME_STIFFNESS))
        return tuple(
            BumperPart(
                x=part.offset[0], y=part.offset[1], half_length=0.5 * part.shape.size[0],
                half_width=0.5 * part.shape.size[1], bottom=bottom, top=top, friction=self.bumper_friction,
                restitution=self.surface.restitution, stiffness=stiffness,
            )
            for a, b, bottom, top, stiffness in layers
            for part in self.around_bay(a, b, top)
            if isinstance(part.shape, Box)
        )  # fmt: skip

    @property
    def points(self) -> tuple[Vector, ...]:
        """Contact points of bumpers and frame with the field: centers of spheres of 10 mm radius, robot frame [m]."""
        return _points(self)

    def around_bay(self, length: float, width: float, top: float) -> list[Part]:
        """Return a box of the given length and width from the ground clearance to the height `top` [m].

        Return three boxes around the bay instead, if the robot has a bay.
        """
        z, tall = 0.5 * (top + self.clearance), top - self.clearance
        if self.bay is None:
            return [Part(Box((length, width, tall)), (0.0, 0.0, z))]
        end = self.bay[0] - 0.5 * self.bumper_length  # of the bay, along x
        side = 0.5 * (width - self.bay[1])
        front, back = 0.5 * length - end, end + 0.5 * length
        y = 0.5 * (self.bay[1] + side)
        return [
            Part(Box((front, width, tall)), (end + 0.5 * front, 0.0, z)),
            *(Part(Box((back, side, tall)), (end - 0.5 * back, sign * y, z)) for sign in (1.0, -1.0)),
        ]

    @property
    def traction_radius(self) -> float:
        """Mean distance from the robot center to the wheels [m]: the lever arm of traction in yaw."""
        return plain_sum(math.hypot(x, y) for x, y in self.wheel_positions) / len(self.wheel_positions)


@lru_cache(maxsize=64)  # one shape object per config, because other caches use the shape as key
def _shape(config: ChassisConfig) -> Compound:
    parts = config.around_bay(config.bumper_length, config.bumper_width, config.bumper_top)
    inset = 2.0 * config.bumper_thickness
    if config.height > config.bumper_top and min(config.bumper_length, config.bumper_width) > inset:
        parts += config.around_bay(config.bumper_length - inset, config.bumper_width - inset, config.height)
    parts += [Part(Sphere(config.wheel_radius), (x, y, config.wheel_radius)) for x, y in config.wheel_positions]
    return Compound(tuple(parts))


_BALL = 0.01  # [m]


@lru_cache(maxsize=64)
def _points(config: ChassisConfig) -> tuple[Vector, ...]:
    """Return the value of `ChassisConfig.points`: corners and side midpoints of bumpers and frame.

    The points are at three heights: bottom and top of the bumpers, and top of the frame. Points in the bay are left
    out.
    """
    found: dict[Vector, None] = {}
    half_x, half_y = 0.5 * config.bumper_length - _BALL, 0.5 * config.bumper_width - _BALL
    inset, bay = config.bumper_thickness, config.bay
    for top, dx in ((config.clearance + 2.0 * _BALL, 0.0), (config.bumper_top, 0.0), (config.height, inset)):
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                x, y = i * (half_x - dx), j * (half_y - dx)
                is_in_bay = bay is not None and x < bay[0] - 0.5 * config.bumper_length and abs(y) < 0.5 * bay[1]
                if (i or j) and not is_in_bay:
                    found[round(x, 6), round(y, 6), round(top - _BALL, 6)] = None
    return tuple(found)

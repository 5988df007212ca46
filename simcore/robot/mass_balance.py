"""Keeps mass and momentum of one robot as pieces come and go and its mechanisms move.

Once a tick, before motion, engine, wheel loads and drivetrain are told mass, center and inertia if they have changed.
The pose of the robot's body stays. Its velocity follows from what is conserved:

- What came in brought the momentum that it had, what was shot or put down took its own along. Both momenta of the
  robot and what came, linear and angular about their common center of mass, are those of the robot afterwards: an
  inelastic impact on the way in, a recoil on the way out.
- Where mass moves within the robot, the momentum of its center and the spin about it stay: an arm that is stretched
  slows a turn, and what pushes the body back while the arm speeds up and slows down is left out.
- What people put in or take out moves with the robot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from simcore.geometry.linkage import MechanismMotion
from simcore.geometry.rotation import Vector, rotate, rotate_back
from simcore.pieces.placer import Placer
from simcore.pieces.storage import Storage
from simcore.robot.chassis import ChassisSimulation
from simcore.robot.mass_distribution import MassDistribution, MovingMass, PointMass, moved_points, with_points
from simcore.typing import FloatArray
from simcore.units import plain_sum

__all__ = ["MassBalance"]

_CENTER_BIT = 0.002
"""By less than this the center of mass does not move [m]: 1 % of a low one's height. A move costs PyBullet 0.5 ms."""
_INERTIA_BIT = 0.002  # [-]; nor do moments of inertia change by less, relatively
_MASS_BIT = 1e-6  # [kg]


class MassBalance:
    """Of one robot.

    Args:
        body: The robot without its moving masses, see `RobotConfig.bare_body`.
        parts: The moving masses.
        mechanisms: Of the robot, by name.
        storages: Of the robot.
        placers: Of the robot.
        chassis: What is told.
    """

    def __init__(
        self,
        body: MassDistribution,
        parts: Sequence[MovingMass],
        mechanisms: Mapping[str, MechanismMotion],
        storages: Sequence[Storage],
        placers: Sequence[Placer],
        chassis: ChassisSimulation,
    ) -> None:
        self._body = body
        self._parts = parts
        self._mechanisms = mechanisms
        self._storages = storages
        self._placers = placers
        self._chassis = chassis
        self._stored: list[list[int]] = [[] for _ in storages]
        self._has_hopper = any(storage.hopper is not None for storage in storages)  # in which pieces move
        self._laden = body  # the body with what is in storages
        self._exchanged: list[tuple[float, Vector, Vector]] = []

    def exchange(self, mass: float, pos: Vector, vel: Vector) -> None:
        """Note a piece that came in since the last `update`, or left.

        Args:
            mass: Of the piece [kg]; negative if it left.
            pos: Where, field frame [m].
            vel: Its velocity there [m/s].
        """
        self._exchanged.append((mass, pos, vel))

    def now(self, masses: FloatArray, radii: FloatArray) -> MassDistribution:
        """Mass, center and inertia with what is held and as mechanisms stand.

        Args:
            masses: Of the pieces, by slot [kg].
            radii: Their bounding radii [m].
        """
        stored = [storage.pieces for storage in self._storages]
        if stored != self._stored or self._has_hopper:
            self._stored = [slots[:] for slots in stored]
            self._laden = with_points(
                self._body,
                [
                    (float(masses[slot]), storage.place(number, float(radii[slot])))
                    for storage in self._storages
                    for number, slot in enumerate(storage.pieces)
                ],
            )
        points: list[PointMass] = moved_points(self._parts, self._mechanisms)
        points += [(float(masses[p.piece]), p.held_state().pos) for p in self._placers if p.piece is not None]
        return with_points(self._laden, points) if points else self._laden

    def update(self, masses: FloatArray, radii: FloatArray) -> None:
        """Tell the chassis what has changed, between two steps of it; see `now`."""
        old, new = self._chassis.distribution, self.now(masses, radii)
        exchanged = self._exchanged
        is_lighter_or_heavier = abs(new.mass - old.mass) > _MASS_BIT
        (ax, ay, az), (bx, by, bz) = new.center, old.center
        moved = max(abs(ax - bx), abs(ay - by), abs(az - bz))
        (ax, ay, az), (bx, by, bz) = new.inertia, old.inertia
        turned = max(abs(ax - bx) / bx, abs(ay - by) / by, abs(az - bz) / bz)
        if not (exchanged or is_lighter_or_heavier or moved > _CENTER_BIT or turned > _INERTIA_BIT):
            return
        if moved <= _CENTER_BIT:
            new = new._replace(center=old.center)
        self._exchanged = []
        self._chassis.set_mass(new, *self._velocity(old, new, exchanged))

    def _velocity(
        self, old: MassDistribution, new: MassDistribution, exchanged: Sequence[tuple[float, Vector, Vector]]
    ) -> tuple[Vector, Vector]:
        """Of the new center of mass, and the angular velocity, field frame [m/s, rad/s]."""
        c = self._chassis
        ox, oy, oz = rotate(c.quat, old.center)
        (vx, vy, vz), (wx, wy, wz) = c.vel, c.rate
        known = old.mass + plain_sum(mass for mass, _, _ in exchanged)
        if abs(new.mass - known) > _MASS_BIT:  # people have put something in, or taken it out
            px, py, pz = rotate(c.quat, new.center)
            px, py, pz = px - ox, py - oy, pz - oz
            return (vx + wy * pz - wz * py, vy + wz * px - wx * pz, vz + wx * py - wy * px), c.rate
        rows = [(m, (x - c.pos[0], y - c.pos[1], z - c.pos[2]), v) for m, (x, y, z), v in exchanged]
        if not rows:
            mx, my, mz = ox, oy, oz
            linear = c.vel
        else:
            rows.append((old.mass, (ox, oy, oz), c.vel))
            mx, my, mz = (plain_sum(m * place[axis] for m, place, _ in rows) / new.mass for axis in range(3))
            ux, uy, uz = (plain_sum(m * v[axis] for m, _, v in rows) / new.mass for axis in range(3))
            linear = (ux, uy, uz)
        ix, iy, iz = old.inertia
        wx, wy, wz = rotate_back(c.quat, c.rate)
        sx, sy, sz = rotate(c.quat, (ix * wx, iy * wy, iz * wz))
        for m, (px, py, pz), (vx, vy, vz) in rows:
            px, py, pz = m * (px - mx), m * (py - my), m * (pz - mz)
            sx, sy, sz = sx + py * vz - pz * vy, sy + pz * vx - px * vz, sz + px * vy - py * vx
        ix, iy, iz = new.inertia
        sx, sy, sz = rotate_back(c.quat, (sx, sy, sz))
        return linear, rotate(c.quat, (sx / ix, sy / iy, sz / iz))

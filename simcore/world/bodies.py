"""Records of a world's rigid bodies for the loop: robots, and the engine's bodies that balls can touch."""

from __future__ import annotations

import numpy as np

from simcore.loop.robot_state import BODY, Records, join, records
from simcore.world.rotation import IDENTITY, Quaternion, Vector, matrix
from simcore.world.shapes import Shape, bounding_radius
from simcore.world.solids_builder import SolidsBuilder

__all__ = ["Bodies"]

_MARKS = 62  # largest number of robots that the contact marks of a ball can distinguish


class Bodies:
    """Records of the robots and of the engine's bodies that balls can touch, one per body.

    Args:
        solids: Builder to which `add` passes the shapes.
    """

    def __init__(self, solids: SolidsBuilder) -> None:
        self._solids = solids
        self.records: Records = records(BODY, 0)
        """Records of type `BODY`, in the order in which the bodies were added."""
        self.rows: list[int] = []
        """Row in the world of each body, indexed by body number."""
        self.number_of: dict[int, int] = {}
        """Body number of each body, by row in the world."""
        self.carriers: list[int] = []
        """Numbers of the bodies that robots drive on."""
        self.robots: list[int] = []
        """Numbers of the robots' bodies, in the order in which the robots were added."""

    def add(
        self,
        row: int,
        shape: Shape,
        surface: Vector,
        mass: float,
        inertia: Vector,
        *,
        center: Vector = (0.0, 0.0, 0.0),
        inertia_axes: Quaternion = IDENTITY,
        pivot: Vector | None = None,
        pos: Vector = (0.0, 0.0, 0.0),
        is_robot: bool = False,
        drivable: bool = False,
    ) -> int:
        """Add a body and return the number of the body.

        Args:
            row: Row of the body in the world.
            shape: Collision shape.
            surface: Friction [-], restitution [-] and rolling lever [m].
            mass: Mass [kg].
            inertia: Principal moments of inertia about the center of mass, or about `pivot` if given [kg m^2].
            center: Center of mass in the body frame [m].
            inertia_axes: Attitude of the principal axes in the body frame.
            pivot: Fixed point about which the body swings, field frame [m]; None for a free body.
            pos: Origin of the body, field frame [m].
            is_robot: Whether the body is a robot; the loop moves robots, and balls can always touch robots.
            drivable: Whether robots drive on the body; balls can always touch drivable bodies.
        """
        number = len(self.rows)
        self.rows.append(row)
        self.number_of[row] = number
        body = records(BODY)
        model = body["model"]
        model["first_solid"] = self._solids.add(
            shape, (0.0, 0.0, 0.0), IDENTITY, surface, row=row, body=number, drivable=drivable
        )
        model["last_solid"] = self._solids.count
        model["row"], model["is_robot"], model["swings"] = row, is_robot, pivot is not None
        model["reach"], model["mass"], model["inertia"] = bounding_radius(shape), mass, inertia
        model["principal"], model["center"] = matrix(inertia_axes), center if pivot is None else pivot
        body["pos"], body["quat"], body["axes"] = pos, IDENTITY, np.eye(3)
        body["com"] = model["center"] if pivot is not None else np.add(pos, center)
        if drivable:
            model["carries"], body["is_active"] = 1, 1
            self.carriers.append(number)
        if is_robot:
            model["mark"], body["is_active"] = 1 << min(len(self.robots), _MARKS), 1
            self.robots.append(number)
        self.records = join((self.records, body))
        return number

    def of(self, row: int) -> Records:
        """Return a view of the record of the body with a given row, shape (1,)."""
        number = self.number_of[row]
        return self.records[number : number + 1]

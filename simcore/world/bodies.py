"""Records of a world's rigid bodies for the loop: robots, swinging bodies, and bodies that only the engine moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from simcore.loop.body import kick_and_drift
from simcore.loop.robot_state import BODY, Records, join, records
from simcore.typing import FloatArray
from simcore.world.engine import Engine
from simcore.world.rotation import IDENTITY, Quaternion, Vector, matrix, rotate, rotate_back
from simcore.world.shapes import Shape, bounding_radius
from simcore.world.solids_builder import SolidsBuilder

__all__ = ["Bodies", "Pivot"]

_MARKS = 62  # largest number of robots that the contact marks of a ball can distinguish

_kick_and_drift: Callable[..., None] = kick_and_drift


class Pivot(NamedTuple):
    """Fixed point about which a body swings, or hinge about which a body turns."""

    place: Vector
    """Fixed point, field frame [m]."""
    hinge: str | None = None
    """Axis of the hinge, `x` or `y`; None for free rotation about the fixed point."""
    spring: float = 0.0
    """Stiffness of the spring that returns a hinged body to the initial pose [N m/rad]."""
    damping: float = 0.0
    """Decay rate of the angular velocity [1/s]."""


class Bodies:
    """Records of the robots, swinging bodies and other bodies that balls can touch, one per body.

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
        """Number of each body, by row."""
        self.robots: list[int] = []
        """Numbers of the robots' bodies, in the order in which the robots were added."""
        self.swinging: list[int] = []
        """Numbers of the bodies on a pivot."""
        self._moments: dict[int, FloatArray] = {}  # moments of inertia of swinging bodies about the center of mass
        self._resting: set[int] = set()  # swinging bodies that sleep in the engine
        self._touched: set[int] = set()  # bodies that touched one of the engine's bodies since `show_to`

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
        pivot: Pivot | None = None,
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
            inertia: Principal moments of inertia about the center of mass [kg m^2].
            center: Center of mass in the body frame [m].
            inertia_axes: Attitude of the principal axes in the body frame.
            pivot: Pivot above, below or in the center of mass, which is then the origin; None for a free body.
            pos: Origin of the body, field frame [m].
            is_robot: Whether the body is a robot. The loop moves robots and bodies on a pivot, and balls can always
                touch these bodies.
            drivable: Whether robots drive on the body.
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
        model["row"], model["is_robot"], model["carries"] = row, is_robot, drivable
        model["reach"], model["mass"], model["inertia"] = bounding_radius(shape), mass, inertia
        model["principal"], model["center"] = matrix(inertia_axes), center
        body["pos"], body["quat"], body["axes"] = pos, IDENTITY, np.eye(3)
        body["com"] = np.add(pos, center)
        if is_robot:
            model["mark"], body["is_active"] = 1 << min(len(self.robots), _MARKS), 1
            self.robots.append(number)
        if pivot is not None:
            model["swings"], body["is_active"] = 1, 1
            model["center"] = body["com"] = pivot.place
            model["spring"], model["drag"] = pivot.spring, pivot.damping
            swing = mass * (pos[2] - pivot.place[2]) ** 2
            about = np.add(inertia, (swing, swing, 0.0))
            model["hinge"] = -1 if pivot.hinge is None else "xy".index(pivot.hinge)
            model["inertia"] = about if pivot.hinge is None else np.where(np.arange(3) == model["hinge"], about, np.inf)
            self.swinging.append(number)
            self._moments[number] = np.array(inertia)
        self.records = join((self.records, body))
        return number

    def of(self, row: int) -> Records:
        """Return a view of the record of the body with a given row, shape (1,)."""
        number = self.number_of[row]
        return self.records[number : number + 1]

    def is_moved_by_loop(self, row: int) -> bool:
        """Return whether the loop moves the body with a given row: a robot or a body on a pivot."""
        number = self.number_of.get(row, -1)
        return number in self.robots or number in self.swinging

    def turn(self, row: int, quat: Quaternion) -> None:
        """Turn a swinging body about the pivot to an attitude, at rest, and wake the body."""
        body = self.records[self.number_of[row]]
        arm = rotate_back(body["quat"].tolist(), (body["pos"] - body["com"]).tolist())
        body["quat"], body["axes"], body["rate"], body["is_awake"] = quat, matrix(quat), 0.0, 1
        body["pos"] = body["com"] + rotate(quat, arm)

    def set_velocity(self, row: int, linear: Sequence[float], angular: Sequence[float]) -> None:
        """Set the velocity of a robot [m/s, rad/s], or the angular velocity of a swinging body, and wake the body.

        A pivot is at rest. A hinged body takes the component of the angular velocity along the hinge.
        """
        body = self.records[self.number_of[row]]
        hinge = int(body["model"]["hinge"])
        body["is_awake"], body["rate"] = 1, angular
        if not body["model"]["swings"]:
            body["vel"] = linear
        elif hinge >= 0:
            body["rate"] = np.where(np.arange(3) == hinge, angular, 0.0)

    # --- the engine's bodies --------------------------------------------------------------------------------------

    def show_to(self, engine: Engine, before: FloatArray, h: float, gravity: float) -> None:
        """Copy the mean velocities of robots and swinging bodies in a step to the engine, for contacts with its bodies.

        Args:
            engine: Engine of all other bodies.
            before: Positions [m] and attitudes of all bodies at the start of the step, shape (n, 7).
            h: Length of the step [s].
            gravity: Gravitational acceleration in the engine, downward; added to the velocity to cancel gravity in
                the engine's step [m/s^2].
        """
        for number in (*self.robots, *self.swinging):
            row, body = self.rows[number], self.records[number]
            is_swinging = bool(body["model"]["swings"])
            if is_swinging and number in self._resting and not body["is_awake"]:
                continue
            vel, rate = body["mean_twist"][:3], body["mean_twist"][3:]
            if is_swinging:
                vel = np.cross(rate, before[number, :3] - body["com"])
            engine.set_pose(row, before[number, :3].tolist(), before[number, 3:].tolist())
            if is_swinging and not body["is_awake"]:
                engine.sleep(row)
                self._resting.add(number)
                continue
            if number in self._resting:
                engine.wake(row)
                self._resting.remove(number)
            vx, vy, vz = vel.tolist()
            engine.set_velocity(row, (vx, vy, vz + gravity * h), rate.tolist())

    def note_touched(self, engine: Engine) -> None:
        """Note the robots and swinging bodies that touch one of the engine's bodies, after an engine's step."""
        others = {*self.robots, *self.swinging} - self._touched
        self._touched |= {number for number in others if engine.touching(self.rows[number])}

    def take_from(self, engine: Engine, before: FloatArray, h: float) -> None:
        """Apply the velocity change from contacts with the engine's bodies in h [s] to robots and swinging bodies.

        The method also moves these bodies by the displacement of this velocity change over h. Impulse and angular
        impulse of the contacts turn a swinging body about the pivot.

        Args:
            engine: Engine of all other bodies.
            before: Positions [m] and attitudes of all bodies at the start of the step, shape (n, 7).
            h: Length of the step [s].
        """
        for number in sorted(self._touched | self._resting):
            body, row = self.records[number], self.rows[number]
            linear, angular = engine.velocity(row)
            if number in self._resting and number not in self._touched:
                if any(linear) or any(angular):  # a near body has woken the engine's copy, which would fall
                    engine.set_pose(row, before[number, :3].tolist(), before[number, 3:].tolist())
                    engine.sleep(row)
                continue
            vel, rate = linear - body["mean_twist"][:3], angular - body["mean_twist"][3:]
            if body["model"]["swings"]:
                arm, axes = before[number, :3] - body["com"], matrix(before[number, 3:].tolist())
                vel = linear - np.cross(body["mean_twist"][3:], arm)
                spin = axes @ (self._moments[number] * (rate @ axes)) + np.cross(arm, body["model"]["mass"] * vel)
                rate = axes @ ((spin @ axes) / body["model"]["inertia"])
                vel = np.zeros(3)
                if not rate.any():
                    continue
                body["is_awake"] = 1
                body["impulse"][3:] += spin
            _kick_and_drift(self.records, number, *vel.tolist(), *rate.tolist(), h)
        self._touched.clear()

"""Manager of all game pieces of a world: staging, motion, sleep, holding, launch and scoring.

The loop moves and wakes balls (`simcore.loop.balls`). Pieces of other shapes are bodies of the engine. The manager puts
a piece to sleep when the piece has been supported and slow for 0.3 s. The manager wakes a piece that is not a ball
before a moving object can reach the piece.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simcore.errors import CapacityError, ConfigError, NonFiniteError, UnknownNameError
from simcore.pieces.aerodynamics import AirFactors, drag_acceleration
from simcore.pieces.kinds import GamePieceConfig, PieceVariation
from simcore.pieces.pool import ON_FIELD, PiecePool, PieceStatus, ShownPieces
from simcore.pieces.resting_places import RestingPlace, RestingPlaces
from simcore.quantities import COUNT, FORCE, Quantity, require, shown
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK
from simcore.world.rotation import IDENTITY, Quaternion, Vector, rotate
from simcore.world.shapes import Box, Compound, Shape, Sphere, bounding_box, parts_of
from simcore.world.world import PhysicsWorld

__all__ = ["Footprint", "GamePieceManager"]

_ROBOT_HEIGHT = 0.6  # [m]; pieces above this height fly over a robot
_SUPPORT_REACH = 0.02  # [m]; largest distance of an object that may support a piece
_DEEPEST = 0.02  # [m]; deeper overlaps of a staged piece with a field element are mistakes
_SOFT, _HARD = 0.1, 0.003  # largest depth in a wall at release: fraction of a ball's radius, [m] for other pieces
_SLEEPY = 0.3  # [s]; time for which a piece must be slow before it sleeps
_GAINS = 0.01  # [m/s]; the time restarts for a slow piece that speeds up by more than this
_ROCKING, _TURNING = 0.08, 0.5  # [m/s, rad/s]; speeds below which pieces that are not balls, and may rock, are slow
_WAKES = 0.005, 0.05  # [m/s]; speeds below which robots and pieces do not wake other pieces
_MARGIN = 0.05  # [m], around moving objects
_WINDY = 3.0  # [m/s]; speed above which drag acts on pieces that are not balls
_BOXES, _PLAIN, _PARTS = (0.02, 0.005, 0.005), (0.005, 0.00125, 0.004), (0.02, 0.0025, 0.004)
"""Largest displacement of a point in an engine step [m], and shortest and longest step [s], for boxes, for other shapes
with one part, and for shapes with several parts.

An engine finds a contact only after the bodies touch, and for shapes other than boxes only one contact point per step.
A disc that falls flat from 1.3 m therefore sinks in by 3 mm, or by 33 mm in steps of 5 ms.
"""
_INSIDE = 0.3  # [m], from the edge of the field to the center of a piece: within reach across the guardrail
_SPACING = 0.01  # [m], between pieces that are put down
_MOST_TRIES = 4000
_PIECE_SPEED = Quantity("m/s", 0.0, 1000.0)  # a tick takes steps of a quarter radius, so 1e9 m/s would take minutes
_FREE, _STAGED, _ASLEEP, _AWAKE, _HELD, _IN_FLIGHT, _SCORED, _PLACED = (int(status) for status in PieceStatus)
_LOOSE = (_STAGED, *ON_FIELD, _SCORED)  # statuses of pieces outside robots
_ALL = (*_LOOSE, _HELD)


@dataclass(frozen=True, slots=True)
class Footprint:
    """Box around a robot or hanging body, and speed of the body, for the search for pieces that the body can reach."""

    x: float
    """x coordinate of the center, field frame [m]."""
    y: float
    """y coordinate of the center, field frame [m]."""
    yaw: float
    """Yaw of the box's length axis [rad]."""
    half_length: float
    """Half of the length [m]."""
    half_width: float
    """Half of the width [m]."""
    speed: float
    """Speed of the fastest point of the box, including rotation [m/s]."""
    heights: tuple[float, float] = (-math.inf, math.inf)
    """Heights of the lowest and highest point of the body [m]."""
    waking_speed: float = 0.005
    """Speed below which the body wakes no pieces [m/s]."""

    def gap(self, pos: FloatArray) -> FloatArray:
        """Return the horizontal distance of points (n, 2 or 3) from the box [m], negative inside, shape (n,)."""
        dx, dy = pos[:, 0] - self.x, pos[:, 1] - self.y
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        ahead, aside = np.abs(c * dx + s * dy) - self.half_length, np.abs(c * dy - s * dx) - self.half_width
        outside = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
        gap: FloatArray = outside + np.minimum(np.maximum(ahead, aside), 0.0)
        return gap


class GamePieceManager:
    """Manager of all pieces of a world.

    Methods change the status of a piece as follows, and raise an error for any other status:

    | method | from | to |
    |---|---|---|
    | `stage` | FREE | STAGED |
    | `release` | STAGED, on the field, HELD, SCORED | AWAKE |
    | `put_down` | STAGED, on the field, SCORED | AWAKE |
    | `hold` | STAGED, on the field, SCORED | HELD |
    | `launch` | HELD | IN_FLIGHT, AWAKE |
    | `score` | on the field | SCORED |
    | `set_aside` | SCORED | STAGED |

    Args:
        world: World that contains the pieces.
        types: Kinds of pieces, each with the largest number of pieces.
        field_size: Length and width of the field [m]; the manager puts back pieces that come to rest outside the field
            or are more than 0.5 m outside.
        never_sleep: Whether to disable sleep, for measurements.
        places: Resting places on the field, where pieces stay and count.
        variation: Variation of single pieces; None for pieces without variation.
    """

    on_taken: Sequence[Callable[[int], None]] = ()
    """Callback of each robot, by robot number; `release` calls the callback with the slot of a piece that the robot
    held."""

    def __init__(
        self,
        world: PhysicsWorld,
        types: Sequence[tuple[GamePieceConfig, int]],
        *,
        field_size: tuple[float, float],
        never_sleep: bool = False,
        places: Sequence[RestingPlace] = (),
        variation: PieceVariation | None = None,
    ) -> None:
        self._world = world
        self._field_size = field_size
        self._sleepy = math.inf if never_sleep else _SLEEPY
        self._kinds = {config.name: kind for kind, (config, _) in enumerate(types)}
        self._pool = PiecePool(world, list(types), variation)
        self.state = self._pool.state
        self._balls = self._pool.balls
        self._is_ball = self._pool.is_ball
        self._others = (~self._is_ball).nonzero()[0]
        self._is_shot = np.zeros(len(self._pool.rows), dtype=bool)
        self.places = RestingPlaces(places, self._pool)
        """Assignment of pieces to resting places."""
        self.shown = ShownPieces(self._pool, self.attitudes)
        """Slots and poses of the pieces on the field, for displays."""
        self._outer = np.array([(-0.5, -0.5, -0.5), (field_size[0] + 0.5, field_size[1] + 0.5, 30.0)])
        self._robots: list[Footprint] = []
        self.out_of_field: Callable[[int], bool] | None = None
        """Function that the manager calls with the slot of each piece that has left the field; the manager puts the
        piece back on the field if the function is None or returns False."""
        self.total = 0
        """Number of pieces added to the match so far."""
        self.recovered = 0
        """Number of times that a piece was put back from outside the field."""
        self._start = self.state.pos.copy()  # positions at the start of the tick
        self._leaving: dict[int, int] = {}  # by slot, not for balls: row of the robot that the piece is leaving
        self._steps = np.array([_steps_of(kind.shape) for kind, _ in types]).reshape(-1, 3)[self.state.kind]
        self.fastest = 0.0
        """Speed of the fastest awake piece at the start of the tick, plus the possible gain from gravity in the tick
        [m/s]."""

    # --- life -----------------------------------------------------------------------------------------------------

    def stage(self, name: str, count: int) -> IntArray:
        """Add pieces to the match, off the field, and return the slots of the pieces.

        Raises:
            UnknownNameError: If no kind has this name.
            CapacityError: If the pool has too few free slots.
        """
        require("stage", "count", count, COUNT)
        slots = self._pool.take(self._kind(name), count)
        self.state.status[slots] = _STAGED
        self.total += len(slots)
        return slots

    def spawn(
        self,
        name: str,
        positions: FloatArray,
        attitudes: FloatArray | None = None,
        *,
        resting: bool = False,
        lodged: float | None = None,
    ) -> IntArray:
        """Place new pieces on the field, and return the slots; pieces that stand on the carpet sleep immediately.

        The method places no piece if the method raises an error.

        Args:
            name: Name of the kind.
            positions: Centers of the pieces, field frame [m], shape (n, 3).
            attitudes: Unit quaternions x, y, z, w, shape (n, 4); None for upright pieces.
            resting: Whether the pieces rest on other pieces or field elements, and sleep immediately.
            lodged: Force that frees pieces that are wedged in place [N]; None for pieces that are not lodged.

        Raises:
            UnknownNameError: If no kind has this name.
            CapacityError: If the pool has too few free slots.
            ConfigError: If an attitude is not a unit quaternion, resting pieces have no support, the force is not above
                0, or lodged pieces are not balls.
            NonFiniteError: If a position is not finite.
        """
        positions = _rows(f"spawn {name}", positions, np.size(positions) // 3, 3)
        quats = _quaternions(name, attitudes, len(positions))
        if lodged is not None:
            require(name, "force that lodged pieces come free at", lodged, FORCE)
            if not isinstance(self._pool.types[self._kind(name)].shape, Sphere):
                raise ConfigError(f"{name}: only balls can be lodged")
        if resting:
            self._require_support(name, positions)
        slots = self.stage(name, len(positions))
        self._release(slots, positions, quats, resting=resting or lodged is not None)
        if lodged is not None:
            self._balls.hold[slots] = lodged
        return slots

    def release(self, slots: IntArray, positions: FloatArray, attitudes: FloatArray | None = None) -> None:
        """Place pieces at rest on the field; the pieces may be staged, scored, held or already on the field.

        The loop pushes a ball that partly overlaps a field element out of the element at 0.5 m/s. For a held piece, the
        method calls the robot's callback in `on_taken`. Nothing changes if the method raises an error.

        Args:
            slots: Slots of the pieces.
            positions: Centers of the pieces, field frame [m], shape (n, 3).
            attitudes: Unit quaternions x, y, z, w, shape (n, 4); None for upright pieces.

        Raises:
            ConfigError: If a slot has no piece, an attitude is not a unit quaternion, the center of a ball would be
                inside a field element, or a piece of another shape would be more than 2 cm inside.
            NonFiniteError: If a position is not finite.
        """
        self._require("release", slots, _ALL)
        positions = _rows("release", positions, len(slots), 3)
        quats = _quaternions("release", attitudes, len(slots))
        for slot, pos, quat in zip(slots.tolist(), positions.tolist(), quats, strict=True):
            depth = self.depth(slot, pos, quat)
            if depth > (self._pool.radius[slot] if self._is_ball[slot] else _DEEPEST):
                at = f"{self.kind_name(slot)} {slot} at ({pos[0]:.3f}, {pos[1]:.3f}, {pos[2]:.3f}) m"
                raise ConfigError(f"release: {at}, its center, would be {1000.0 * depth:.0f} mm deep in an element")
        for slot in slots[self.state.status[slots] == _HELD].tolist():
            if self.state.holder[slot] < len(self.on_taken):
                self.on_taken[self.state.holder[slot]](slot)
        self._release(slots, positions, quats)

    def hold(self, slots: IntArray, holder: int) -> None:
        """Move pieces into a robot, and wake sleeping pieces that may have leaned on these pieces.

        Raises:
            ConfigError: If a slot has no piece, a robot already holds the piece, or the robot does not exist; nothing
                changes.
        """
        self._require("hold", slots, _LOOSE)
        if type(holder) is not int or holder < 0 or (self.on_taken and holder >= len(self.on_taken)):
            raise ConfigError(f"hold: there are robots 0 to {len(self.on_taken) - 1}, got {holder}")
        for slot in slots.tolist():
            self._wake_leaning(slot)
            self._pool.park(slot)
            self.state.status[slot] = _HELD
            self.state.holder[slot] = holder

    def launch(
        self,
        holder: int,
        pos: Sequence[float],
        vel: Sequence[float],
        spin: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        slot: int | None = None,
        quat: Quaternion = IDENTITY,
        flying: bool = True,
    ) -> int:
        """Launch a held piece with a velocity, and return the slot of the piece.

        The robot keeps the piece if the method raises an error.

        Args:
            holder: Number of the robot that holds the piece.
            pos: Center of the piece at the muzzle, field frame [m].
            vel: Velocity of the piece, field frame [m/s].
            spin: Angular velocity of the piece, field frame [rad/s].
            slot: Slot of the piece; None for the lowest slot that the robot holds.
            quat: Attitude of the piece, field frame, unit quaternion x, y, z, w.
            flying: Whether the robot shoots the piece into the air; otherwise the robot puts the piece down.

        Raises:
            CapacityError: If the robot holds no piece, or does not hold the piece in `slot`.
            NonFiniteError: If a value is not finite.
            ConfigError: If the speed is above 1,000 m/s.
        """
        held = self.held(holder) if type(holder) is int else self.held(-1)
        if len(held) == 0:
            holders = sorted(set(self.state.holder[self.state.status == _HELD].tolist()))
            raise CapacityError(f"robot {shown(holder)} has no piece to launch; those with pieces: {holders or 'none'}")
        if slot is None:
            slot = int(held[0])
        elif slot not in held:
            raise CapacityError(f"robot {holder} holds pieces {held.tolist()}, got {slot}")
        _rows("launch: position, velocity and spin", (pos, vel, spin), 3, 3)
        _require_speed("launch", vel)
        self._pool.place(slot, (float(pos[0]), float(pos[1]), float(pos[2])), quat)
        self._set_velocity(slot, vel, spin)
        self.state.status[slot] = _IN_FLIGHT if flying else _AWAKE
        self.state.holder[slot] = -1
        self._is_shot[slot] = flying
        if flying and holder < len(self._world.robot_rows):
            self._leave(slot, self._world.robot_rows[holder])
        return slot

    def _leave(self, slot: int, robot: int) -> None:
        """Ignore contacts between a launched piece and the robot in row `robot` until the piece has left the robot."""
        if self._is_ball[slot]:
            self._world.balls.leave(slot, robot)
        else:
            self._leaving[slot] = robot
            self._world.set_piece_touchable(self._pool.rows[slot], True, robots=False)

    def _leave_robot_around(self, slot: int, shape: Shape, pos: Sequence[float], quat: Quaternion) -> None:
        """Ignore contact of a piece that is not a ball with the robot that contains the piece, until the piece is out.

        The engine would throw piece and robot apart.
        """
        low, high = bounding_box(shape)
        for offset in ((0.0, 0.0, 0.0), *np.diag(0.8 * low).tolist(), *np.diag(0.8 * high).tolist()):
            robot = self._world.robots.containing(np.add(pos, rotate(quat, offset)).tolist())
            if robot >= 0:
                self._leave(slot, robot)
                return

    def _let_touch_robots(self) -> None:
        """Enable contacts with robots for pieces, other than balls, that have left the robot after the launch."""
        for slot, robot in list(self._leaving.items()):
            away = math.dist(self.state.pos[slot], self._world.bodies.of(robot)["pos"][0])
            is_here = self.state.status[slot] in ON_FIELD
            if not is_here or away > self._pool.radius[slot] + self._world.balls.reach(robot):
                del self._leaving[slot]
                if is_here:
                    self._world.set_piece_touchable(self._pool.rows[slot], True)

    def fly(self, slot: int, h: float) -> None:
        """Advance a newly launched piece by h [s].

        A piece that is not a ball does not move if a field element or the floor may be in the path.
        """
        if self._is_ball[slot]:
            self._world.balls.fly(self._balls.only(slice(slot, slot + 1)), h)
            return
        pos, vel, reach = self.state.pos[slot], self.state.vel[slot], self._pool.radius[slot]
        drop = np.array((0.0, 0.0, self._world.gravity * h))
        end = pos + h * (vel - 0.5 * drop)
        low, high = np.minimum(pos, end) - reach, np.maximum(pos, end) + reach
        if low[2] > 0.0 and self._world.is_free(low.tolist(), high.tolist()):
            row, quat = self._pool.rows[slot], self._balls.quat[slot].tolist()
            self.state.pos[slot], self.state.vel[slot] = end, vel - drop
            self._world.set_pose(row, end.tolist(), (quat[0], quat[1], quat[2], quat[3]))
            self._world.set_velocity(row, self.state.vel[slot].tolist(), self._balls.spin[slot].tolist())

    def _set_velocity(self, slot: int, vel: Sequence[float], spin: Sequence[float]) -> None:
        self.state.vel[slot] = vel
        self._balls.spin[slot] = spin
        if not self._is_ball[slot]:
            self._world.set_velocity(self._pool.rows[slot], vel, spin)

    def depth(self, slot: int, pos: Vector, quat: Quaternion) -> float:
        """Return the overlap that a piece would have with field elements at a pose [m].

        For a piece on the field that is not a ball, the test uses a parked piece of the same kind. The result is 0 if
        no such piece is parked.

        Args:
            slot: Slot of the piece.
            pos: Center of the piece, field frame [m].
            quat: Attitude of the piece, field frame.
        """
        if self._is_ball[slot]:
            return self._world.balls.depth(pos, float(self._pool.radius[slot]))
        if self.state.status[slot] in ON_FIELD:
            like_it = ((self.state.kind == self.state.kind[slot]) & ~self.is_on_field).nonzero()[0]
            if not len(like_it):
                return 0.0
            slot = int(like_it[0])
        self._pool.place(slot, pos, quat)
        depth: float = self._world.engine.depth(self._pool.rows[slot])
        self._pool.park(slot)
        return depth

    def is_free(self, slot: int, depth: float) -> bool:
        """Return whether a piece can be released at a position with a given overlap `depth` with field elements [m].

        The limit is 0.1 of the radius for a ball and 3 mm for other pieces.
        """
        return depth < (_SOFT * float(self._pool.radius[slot]) if self._is_ball[slot] else _HARD)

    def require_room(self) -> None:
        """Check that no piece on the field, except lodged balls, is over 2 cm deep in a field element or the floor.

        Raises:
            ConfigError: If a piece is inside an element; the message names the element and the depth.
        """
        for slot in self.on_field().tolist():
            if self._is_ball[slot] and self._balls.hold[slot] > 0.0:  # lodged on purpose
                continue
            kind = self._pool.types[self.state.kind[slot]]
            pos, reach = self.state.pos[slot].tolist(), 0.9 * float(self._pool.radius[slot])
            near = self._world.field_in([c - reach for c in pos], [c + reach for c in pos])
            depth = self._depth_now(slot) if near else kind.inner_radius - pos[2]
            if depth <= _DEEPEST:
                continue
            names = " and ".join(sorted(map(self._world.body_name, near))) or "the floor"
            raise ConfigError(
                f"{kind.name} {slot} is staged inside of {names}: ({pos[0]:.3f}, {pos[1]:.3f}, {pos[2]:.3f}) m is "
                f"{1000.0 * depth:.0f} mm deep in it; positions are of a piece's center"
            )

    def _depth_now(self, slot: int) -> float:
        """Return the current overlap of a piece on the field with field elements [m]."""
        if self._is_ball[slot]:
            return self._world.balls.depth(tuple(self.state.pos[slot].tolist()), float(self._pool.radius[slot]))
        return float(self._world.engine.depth(self._pool.rows[slot]))

    def score(self, slots: IntArray) -> None:
        """Remove scored pieces from the field, and wake sleeping pieces that may have leaned on these pieces.

        Raises:
            ConfigError: If a piece is not on the field; nothing changes.
        """
        self._require("score", slots, ON_FIELD)
        for slot in slots.tolist():
            self._wake_leaning(slot)
            self._pool.park(slot)
            self.state.status[slot] = _SCORED

    def set_aside(self, slots: IntArray) -> None:
        """Stage scored pieces that human players or field staff will put on the field again.

        Raises:
            ConfigError: If a piece has not scored; nothing changes.
        """
        self._require("set_aside", slots, (_SCORED,))
        self.state.status[slots] = _STAGED

    def push(self, slots: IntArray, velocities: FloatArray, *, flying: bool = False) -> None:
        """Set the velocities of pieces on the field, set the angular velocities to zero, and wake the pieces.

        A lodged piece does not move unless the force for this velocity within one tick reaches the force that frees the
        piece. Nothing changes if the method raises an error.

        Args:
            slots: Slots of the pieces.
            velocities: Velocities, field frame [m/s], shape (n, 3).
            flying: Whether the pieces are in the air without contact, as after a launch.

        Raises:
            ConfigError: If a piece is not on the field or a speed is above 1,000 m/s.
            NonFiniteError: If a velocity is not finite.
        """
        self._require("push", slots, ON_FIELD)
        velocities = _rows("push", velocities, len(slots), 3)
        for velocity in velocities:
            _require_speed("push", velocity)
        for slot, velocity in zip(slots.tolist(), velocities.tolist(), strict=True):
            hold = self._balls.hold[slot]
            if hold > 0.0 and self._pool.mass[slot] * math.hypot(*velocity) < hold * TICK:
                continue
            self._wake(slot)
            self._balls.hold[slot] = 0.0
            self._set_velocity(slot, velocity, (0.0, 0.0, 0.0))
            if flying:
                self._balls.is_touched[slot] = 0
                self._is_shot[slot] = True
                self.state.status[slot] = _IN_FLIGHT

    def clear(self) -> None:
        """Remove all pieces from the match, so that all slots are free."""
        slots = np.nonzero(self.state.status != _FREE)[0]
        for slot in slots.tolist():
            self._pool.park(slot)
        self.state.status[slots] = _FREE
        self.state.holder[slots] = -1
        self.total = 0

    def spare(self, name: str, count: int) -> IntArray:
        """Choose pieces that can be put on the field, and return the slots of these pieces.

        The method chooses unused pieces first, then staged pieces, then scored pieces. The method stages the chosen
        unused pieces.

        Raises:
            UnknownNameError: If no kind has this name.
            CapacityError: If fewer than `count` pieces are off the field and outside robots; nothing changes.
        """
        require("spare", "count", count, COUNT)
        mine = self.state.kind == self._kind(name)
        slots = np.concatenate([np.nonzero(mine & (self.state.status == s))[0] for s in (_FREE, _STAGED, _SCORED)])
        if len(slots) < count:
            raise CapacityError(
                f"{len(slots)} of the game's {int(mine.sum())} {name} are neither on the field nor in a robot, "
                f"got {count} to put down; resetting the field takes them all back"
            )
        slots = slots[:count]
        self.stage(name, int((self.state.status[slots] == _FREE).sum()))
        return slots

    def put_down(self, slots: IntArray, places: FloatArray) -> None:
        """Place pieces on the carpet at rest, each at a free position close to a given position.

        Args:
            slots: Slots of the pieces.
            places: Desired positions, field frame [m], shape (n, 2).

        Raises:
            ConfigError: If a slot has no piece or a robot holds the piece; nothing changes.
        """
        self._require("put_down", slots, _LOOSE)
        places = _rows("put_down", places, len(slots), 2)
        for slot, (x, y) in zip(slots.tolist(), places.tolist(), strict=True):
            self._move_to_free_place(slot, (x, y))

    def make_room(self, robots: Sequence[Footprint]) -> None:
        """Move pieces inside the footprints of newly placed robots to the nearest free positions.

        Args:
            robots: Footprints of all robots at their current poses.
        """
        self._robots = list(robots)
        here = self.on_field()
        here = here[self.state.pos[here, 2] < _ROBOT_HEIGHT]
        inside = [robot.gap(self.state.pos[here]) < self._pool.radius[here] for robot in robots]
        for slot in here[np.any(inside, axis=0)].tolist():
            x, y, _ = self.state.pos[slot].tolist()
            self._move_to_free_place(slot, (x, y))

    # --- state ----------------------------------------------------------------------------------------------------

    @property
    def is_untouched(self) -> BoolArray:
        """Whether the piece of each slot was launched into the air and has had no contact since, shape (n,)."""
        untouched: BoolArray = self._is_shot & (self._balls.is_touched == 0)
        return untouched

    @property
    def types(self) -> list[GamePieceConfig]:
        """Kinds of pieces, in the order of `PieceState.kind`."""
        return self._pool.types

    def kind_name(self, slot: int) -> str:
        """Return the name of the kind of the piece in a slot."""
        return str(self._pool.types[self.state.kind[slot]].name)

    def row(self, slot: int) -> int:
        """Return the engine row of a piece, or -1 for a ball."""
        return self._pool.rows[slot]

    def robots_touching(self, slot: int) -> list[int]:
        """Return the engine rows of the robots that a piece touched.

        For a ball, the method returns contacts in this tick. For any other piece, the method returns contacts in the
        last engine step.
        """
        if self._is_ball[slot]:
            return self._world.balls.robots_touching(slot)
        return [row for row in self._world.engine.touching(self._pool.rows[slot]) if row in self._world.robot_rows]

    @property
    def awake(self) -> IntArray:
        """Slots of the awake pieces, including pieces in flight."""
        status = self.state.status
        slots: IntArray = ((status == _AWAKE) | (status == _IN_FLIGHT)).nonzero()[0]
        return slots

    @property
    def in_contact(self) -> IntArray:
        """Slots of the awake pieces that touch something. Pieces in flight are not among them."""
        slots: IntArray = (self.state.status == _AWAKE).nonzero()[0]
        return slots

    @property
    def is_on_field(self) -> BoolArray:
        """Whether the piece of each slot is on the field or in the air, shape (n,)."""
        return self._pool.is_on_field

    def on_field(self, name: str | None = None) -> IntArray:
        """Return the slots of pieces on the field or in the air, of one kind or of all kinds."""
        here = self.is_on_field
        if name is not None:
            here &= self.state.kind == self._kind(name)
        return np.nonzero(here)[0]

    def attitudes(self, slots: IntArray) -> FloatArray:
        """Return the attitudes w, x, y, z of the pieces in given slots, shape (n, 4).

        The attitude of a piece off the field is the last attitude on the field.
        """
        quat = self._balls.quat
        if len(self._others):
            moving = (self.state.status[slots] == _AWAKE) | (self.state.status[slots] == _IN_FLIGHT)
            for slot in slots[moving & ~self._is_ball[slots]].tolist():
                quat[slot] = self._world.engine.pose(self._pool.rows[slot])[1]
        taken, rows = quat.take(slots, axis=0), np.empty((len(slots), 4))
        rows[:, 0], rows[:, 1:] = taken[:, 3], taken[:, :3]
        return rows

    @property
    def radius(self) -> FloatArray:
        """Bounding radius of each slot's piece [m], shape (n,)."""
        return self._pool.radius

    @property
    def mass(self) -> FloatArray:
        """Mass of each slot's piece [kg], shape (n,)."""
        return self._pool.mass

    @property
    def size(self) -> FloatArray:
        """Ratio of each piece's diameter to the nominal diameter of its kind, by slot [-], shape (n,)."""
        return self._pool.size

    def air_of(self, slot: int) -> AirFactors:
        """Return the aerodynamic factors of the piece in a slot."""
        return self._pool.air_of(slot)

    def held(self, holder: int) -> IntArray:
        """Return the slots of the pieces that a robot holds."""
        return np.nonzero((self.state.status == _HELD) & (self.state.holder == holder))[0]

    def count(self, status: PieceStatus, name: str | None = None) -> int:
        """Count the pieces with a status, of one kind or of all kinds."""
        mask: BoolArray = self.state.status == int(status)
        if name is not None:
            mask &= self.state.kind == self._kind(name)
        return int(np.count_nonzero(mask))

    # --- one tick -------------------------------------------------------------------------------------------------

    def begin_tick(self, robots: Sequence[Footprint], dt: float) -> float:
        """Begin a tick: wake pieces other than balls that a moving object can reach, and list the bodies near balls.

        The loop wakes balls.

        Args:
            robots: Footprints of all moving objects other than pieces.
            dt: Duration of the tick [s].

        Returns:
            Longest engine step that the pieces allow [s].
        """
        state, self._robots = self.state, list(robots)
        self._start[:] = state.pos
        awake = self.awake
        self.fastest = (
            float(np.sqrt(_squares(state.vel.take(awake, axis=0)).max(initial=0.0))) + self._world.gravity * dt
        )
        if not len(self._others):
            self._world.balls.begin_tick([], [])
            return math.inf
        self._let_touch_robots()
        self._wake_reached(awake, dt)
        slots = self._near_balls(dt)
        fixed = slots[self._pool.is_frozen[slots]]
        self._world.balls.begin_tick(self._pool.rows_of(slots), self._pool.rows_of(fixed))
        return self._longest_step()

    def apply_drag(self, h: float) -> None:
        """Apply drag for an engine step of h [s] to pieces other than balls that are faster than 3 m/s."""
        slots = self._moving_others()
        if len(slots):
            slots = slots[_squares(self.state.vel[slots]) > _WINDY * _WINDY]
            rows = self._pool.rows_of(slots)
            drag = drag_acceleration(self._world.engine.velocities(rows)[:, :3], self._pool.drag[slots])
            self._world.engine.apply_forces(rows, self._pool.mass[slots][:, None] * drag)

    def gather(self, dt: float) -> None:
        """Update the state of awake pieces after a tick of dt [s], and put back pieces that have left the field."""
        state, balls = self.state, self._balls
        state.before[:] = self._start
        others = self._moving_others()
        if len(others):
            state.pos[others] = self._world.engine.centers(self._pool.rows_of(others))
            state.vel[others] = (state.pos[others] - state.before[others]) / dt
            for slot in others[state.status[others] == _IN_FLIGHT].tolist():
                if self._world.engine.touching(self._pool.rows[slot]) or balls.is_touched[slot]:
                    balls.is_touched[slot] = 1
                    state.status[slot] = _AWAKE
        awake = self.awake
        if not len(awake):
            return
        self._pool.changes += 1
        moving = awake[self._is_ball[awake]]
        state.status[moving] = np.where(balls.contacts[moving] > 0, _AWAKE, _IN_FLIGHT)
        places = state.pos.take(awake, axis=0)
        within = (places > self._outer[0]) & (places < self._outer[1])  # False for NaN
        if not within.all():
            self._put_back(awake[~within.all(axis=1)])

    def settle(self, dt: float) -> None:
        """Put pieces to sleep that have been slow and supported for 0.3 s, after a tick of dt [s].

        The method puts pieces that come to rest outside the field back on the field.
        """
        state, still = self.state, self._balls.still
        others = self._moving_others()
        if len(others):
            spin = self._world.engine.velocities(self._pool.rows_of(others))[:, 3:]
            speed, calm = np.sqrt(_squares(state.vel[others])), self._balls.calm
            is_slow = (speed < _ROCKING) & (_squares(spin) < _TURNING**2)
            begins = (still[others] == 0.0) | (speed > calm[others] + _GAINS)  # no equilibrium if a piece gains speed
            calm[others] = np.where(begins, speed, calm[others])
            still[others] = np.where(begins, 0.0, still[others])
            still[others] = np.where(is_slow & (state.status[others] == _AWAKE), still[others] + dt, 0.0)
        ready = self.awake
        ready = ready[still[ready] > self._sleepy - 1e-9]
        if len(ready):
            x, y = state.pos[ready, 0], state.pos[ready, 1]
            out = (x < 0.0) | (x > self._field_size[0]) | (y < 0.0) | (y > self._field_size[1])
            if out.any():  # behind a wall or on top of a wall
                self._put_back(ready[out])
                ready = ready[~out]
            self._fall_asleep(ready)

    def _moving_others(self) -> IntArray:
        """Return the slots of the awake pieces that the engine moves, that is, of pieces other than balls."""
        status = self.state.status[self._others]
        moving: IntArray = self._others[(status == _AWAKE) | (status == _IN_FLIGHT)]
        return moving

    def _wake_reached(self, awake: IntArray, dt: float) -> None:
        """Wake sleeping pieces, other than balls, that a moving object can reach within dt [s]."""
        state, radius = self.state, self._pool.radius
        status = state.status[self._others]
        asleep = self._others[(status == _ASLEEP) | (status == _PLACED)]
        if not len(asleep):
            return
        pos, own = state.pos[asleep], radius[asleep] + _MARGIN
        reached: BoolArray = np.zeros(len(asleep), dtype=bool)
        for robot in self._robots:
            if robot.speed > max(_WAKES[0], robot.waking_speed):
                grow, (low, high) = own + robot.speed * dt, robot.heights
                reached |= (robot.gap(pos) < grow) & (pos[:, 2] > low - grow) & (pos[:, 2] < high + grow)
        speed = np.sqrt(_squares(state.vel[awake]))
        fast = speed > _WAKES[1]
        for slot, way in zip(awake[fast].tolist(), (speed[fast] * dt).tolist(), strict=True):
            grow = own + float(radius[slot]) + way
            reached |= _squares(pos - state.pos[slot]) < grow * grow
        for slot in asleep[reached].tolist():
            self._wake(slot)

    def _near_balls(self, dt: float) -> IntArray:
        """Return the slots of the pieces other than balls that balls could touch within dt [s]."""
        state, radius = self.state, self._pool.radius
        here = self.is_on_field
        balls, others = (here & self._is_ball).nonzero()[0], self._others[here[self._others]]
        if not (len(balls) and len(others)):
            return others[:0]
        reach = radius[balls] + np.sqrt(_squares(state.vel[balls])) * dt + _MARGIN
        way = np.sqrt(_squares(state.vel[others])) * dt
        away = _squares(state.pos[others][:, None] - state.pos[balls][None])
        near: BoolArray = (away < (reach[None] + (radius[others] + way)[:, None]) ** 2).any(axis=1)
        return others[near]

    def _longest_step(self) -> float:
        """Compute the longest engine step that awake pieces in the engine allow [s]."""
        slots = self._moving_others()
        if not len(slots):
            return math.inf
        twist = self._world.engine.velocities(self._pool.rows_of(slots))
        rim = np.sqrt(_squares(twist[:, :3])) + self._pool.radius[slots] * np.sqrt(_squares(twist[:, 3:]))
        move, shortest, longest = self._steps[slots].T
        return float(np.minimum(longest, np.maximum(shortest, move / np.maximum(rim, 1e-6))).min())

    # --- internals ------------------------------------------------------------------------------------------------

    def _kind(self, name: str) -> int:
        if not isinstance(name, str) or name not in self._kinds:
            raise UnknownNameError("game piece type", name, self._kinds)
        return self._kinds[name]

    def _wake(self, slot: int) -> None:
        if self.state.status[slot] in (_ASLEEP, _PLACED):
            self.state.status[slot] = _AWAKE
        self._balls.still[slot] = 0.0
        if not self._is_ball[slot]:
            self._world.engine.wake(self._pool.rows[slot])

    def _wake_leaning(self, slot: int) -> None:
        """Wake the sleeping pieces close to a piece that is removed from the field.

        The sleeping pieces may have leaned on the removed piece.
        """
        state = self.state
        if state.status[slot] not in ON_FIELD:
            return
        asleep = np.nonzero(self._pool.is_frozen & (self._balls.hold == 0.0))[0]
        reach = self._pool.radius[asleep] + 1.5 * self._pool.radius[slot]
        for other in asleep[_squares(state.pos[asleep] - state.pos[slot]) < reach * reach].tolist():
            if other != slot:
                self._wake(other)

    def _fall_asleep(self, slots: IntArray) -> None:
        self.attitudes(slots)  # stores the attitudes, which are not read again during sleep
        self.state.status[slots] = _ASLEEP
        self.state.vel[slots] = self._balls.spin[slots] = 0.0
        for slot in slots.tolist():
            if not self._is_ball[slot]:
                self._world.engine.fix(self._pool.rows[slot])
            if self.places.places:
                x, y, z, w = self._balls.quat[slot].tolist()
                self.places.judge(slot, (x, y, z, w), bool(self.robots_touching(slot)))

    def _release(
        self, slots: IntArray, positions: FloatArray, quats: list[Quaternion], *, resting: bool = False
    ) -> None:
        for slot, pos, quat in zip(slots.tolist(), positions.tolist(), quats, strict=True):
            config = self._pool.types[self.state.kind[slot]]
            height = config.rest_height if quat == IDENTITY else config.rest_height_at(quat)
            standing = abs(pos[2] - height) < 0.002 and (self._is_ball[slot] or config.stands_at(quat))
            self._wake_leaning(slot)
            self._pool.place(slot, (pos[0], pos[1], pos[2]), quat)
            if not self._is_ball[slot]:
                self._leave_robot_around(slot, config.shape, pos, quat)
            self.state.status[slot] = _AWAKE
            self.state.holder[slot] = -1
            self._is_shot[slot] = False
            if resting or standing:
                self._fall_asleep(np.array([slot]))

    def _put_back(self, slots: IntArray) -> None:
        """Put pieces back on the carpet at rest, each at a free position close to the present position.

        The method skips pieces for which `out_of_field` returns True.
        """
        for slot in slots.tolist():
            if self.out_of_field is not None and self.out_of_field(slot):
                continue
            x, y, _ = (0.0 if math.isnan(c) else c for c in self.state.pos[slot].tolist())
            self._move_to_free_place(slot, (x, y))
            self.recovered += 1

    def _move_to_free_place(self, slot: int, near: tuple[float, float]) -> None:
        """Place a piece on the carpet at rest, at a free position close to `near` [m].

        If the method finds no free position, the piece falls from 1 m above the carpet at `near`.
        """
        kind, others = self._pool.types[self.state.kind[slot]], self.on_field()
        radius, height, taken = kind.bounding_radius, kind.rest_height, self.state.pos[others[others != slot]]
        most = np.array(self._field_size) - _INSIDE
        middle = np.clip(near, _INSIDE, most)
        apart, reach = 2.0 * radius + _SPACING, np.array((radius, radius, height - 0.01))
        place = np.array((*middle, height + 1.0))
        for offset in _spiral(apart):
            spot = np.array((*(middle + offset), height))
            if (
                (spot[:2] >= _INSIDE).all()
                and (spot[:2] <= most).all()
                and not (_squares(taken - spot) < apart * apart).any()
                and not any(robot.gap(spot[None])[0] < radius for robot in self._robots)
                and self._world.is_free((spot - reach).tolist(), (spot + reach).tolist())
            ):
                place = spot
                break
        self._release(np.array([slot]), place[None], [IDENTITY])

    def _require(self, what: str, slots: IntArray, allowed: Sequence[int]) -> None:
        """Raise `ConfigError` if the slots of a request are invalid, or if a piece does not have an allowed status."""
        count = len(self.state.status)
        if not (isinstance(slots, np.ndarray) and slots.ndim == 1 and np.issubdtype(slots.dtype, np.integer)):
            raise ConfigError(f"{what}: pieces must be an array of whole numbers, shape (n,), got {shown(slots)}")
        if ((slots < 0) | (slots >= count)).any() or len(np.unique(slots)) < len(slots):
            raise ConfigError(f"{what}: pieces must be different numbers from 0 to {count - 1}, got {shown(slots)}")
        wrong = slots[~np.isin(self.state.status[slots], allowed)]
        if len(wrong):
            status = PieceStatus(int(self.state.status[wrong[0]])).name
            names = [PieceStatus(value).name for value in allowed]
            raise ConfigError(f"{what}: piece {int(wrong[0])} is {status}, it must be one of {names}")

    def _require_support(self, name: str, positions: FloatArray) -> None:
        """Raise `ConfigError` if a new resting piece is not close to the carpet, a field element or another piece."""
        reach = self._pool.types[self._kind(name)].bounding_radius + _SUPPORT_REACH
        others = self.on_field()
        is_near = self._world.near_field(positions, np.full(len(positions), reach)) | (positions[:, 2] < reach)
        for place, near in zip(positions, is_near.tolist(), strict=True):
            away = np.linalg.norm(self.state.pos[others] - place, axis=1)
            if not (near or (away < reach + self._pool.radius[others]).any()):
                raise ConfigError(
                    f"{name}: a piece at {place.tolist()} m has nothing to rest on; stage what is below it before it, "
                    "or let it fall"
                )


def _steps_of(shape: Shape) -> tuple[float, float, float]:
    """Return the largest displacement in an engine step [m], and the shortest and longest step [s], for a shape."""
    if all(isinstance(part.shape, Sphere | Box) for part in parts_of(shape)):
        return _BOXES
    return _PARTS if isinstance(shape, Compound) else _PLAIN


def _squares(rows: FloatArray) -> FloatArray:
    """Return the squared lengths of vectors (..., 3), shape (...,)."""
    squares: FloatArray = np.einsum("...i,...i->...", rows, rows)
    return squares


def _rows(what: str, values: Any, count: int, width: int) -> FloatArray:
    """Convert values to an array of finite numbers, shape (count, width).

    Raises:
        NonFiniteError: If the number of values is wrong, or a value is not a finite number.
    """
    try:
        rows = np.asarray(values, dtype=float).reshape(count, width)
    except (TypeError, ValueError, OverflowError):
        rows = np.full((1, width), np.nan)
    if not np.isfinite(rows).all():
        raise NonFiniteError(f"{what}: {count} rows of {width} finite numbers are needed, got {shown(values)}")
    return rows


def _require_speed(what: str, velocity: Sequence[float] | FloatArray) -> None:
    """Raise `ConfigError` if a speed is above 1,000 m/s; the number of steps per tick increases with the speed."""
    require(what, "speed", math.hypot(*velocity), _PIECE_SPEED)


def _quaternions(what: str, attitudes: FloatArray | None, count: int) -> list[Quaternion]:
    """Convert attitudes, or None for upright pieces, to unit quaternions x, y, z, w of `count` pieces.

    Raises:
        ConfigError: If an attitude is not a unit quaternion.
        NonFiniteError: If the number of values is wrong, or a value is not a finite number.
    """
    if attitudes is None:
        return [IDENTITY] * count
    rows = _rows(what, attitudes, count, 4)
    if rows.shape != (count, 4) or not np.allclose(np.linalg.norm(rows, axis=-1), 1.0, atol=1e-6):
        raise ConfigError(f"{what}: {count} unit quaternions x, y, z, w are needed as attitudes, got {attitudes}")
    return [(x, y, z, w) for x, y, z, w in rows.tolist()]


def _spiral(spacing: float) -> Iterator[tuple[float, float]]:
    """Yield horizontal offsets [m], nearest first, on circles with a distance `spacing` [m] between neighbors."""
    yield 0.0, 0.0
    tries, ring = 1, 1
    while tries < _MOST_TRIES:
        count = math.floor(2.0 * math.pi * ring)
        for number in range(count):
            angle = 2.0 * math.pi * number / count
            yield ring * spacing * math.cos(angle), ring * spacing * math.sin(angle)
        tries += count
        ring += 1

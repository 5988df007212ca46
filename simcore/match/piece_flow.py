"""Pieces on their way into robots and out of them: intakes and storages, shooters and placers."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simcore.geometry.linkage import PartState
from simcore.geometry.rotation import IDENTITY, Quaternion, Vector, interpolate, multiply, rotate
from simcore.match.run_record import RunRecord
from simcore.physics.contact_law import pair_restitution
from simcore.physics.shapes import Sphere
from simcore.physics.world import PhysicsWorld
from simcore.pieces.flight import SQUEEZE, muzzle_obstacle
from simcore.pieces.intake import Intake, field_to_robot, on_part
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import Launch
from simcore.pieces.piece_manager import GamePieceManager
from simcore.pieces.placer import Placer
from simcore.pieces.shooter import Shooter, ShooterConfig
from simcore.robot.robot import Robot
from simcore.typing import BoolArray, FloatArray, IntArray
from simcore.units import TICK

__all__ = ["PieceFlow"]

_LOOK = 0.015  # [m] of its way; the wall of a tube with a give of 10 mm is too deep in a pipe of 42 mm for 28 mm of it
_STANDS = 1e-4  # [m]; one that has moved less since it was looked at is as deep as it was
_CARRIED = 0.25  # [m] in a tick; at 12 m/s it is people who put the robot elsewhere


@dataclass(slots=True)
class _Way:
    """Of one held piece."""

    slot: int
    pos: Vector
    quat: Quaternion
    free: tuple[Vector, Quaternion] | None = None
    """Where it was last in nothing [m]; None: not yet since it was taken, as of a piece that lies in the field."""
    is_free: bool = False
    """Whether it is in nothing now."""


class HeldContact:
    """Follows the pieces in placers through the field: those driven into it come out, as they would of a real claw.

    A held piece is no body, nor is what holds it: robots go where their chassis can go. So the way of each held piece
    through the field is looked along, and one that gets deeper into a static than claw and piece give comes loose
    where it was last free, with the velocity of the claw; what becomes of it is the engine's business.

    Args:
        world: What stands there.
        pieces: All of them.
    """

    def __init__(self, world: PhysicsWorld, pieces: GamePieceManager) -> None:
        self._world = world
        self._pieces = pieces
        self._ways: dict[Placer, _Way] = {}

    def forget(self, placer: Placer) -> None:
        """A placer's piece was let go."""
        self._ways.pop(placer, None)

    def is_free(self, placer: Placer) -> bool:
        """Whether a placer's piece, which has been followed in this tick, is in nothing and can be let go."""
        return self._ways[placer].is_free

    def follow(self, placer: Placer, slot: int, part: PartState) -> PartState | None:
        """Look along the way of a placer's piece since the last tick.

        Args:
            placer: What holds it.
            slot: Which piece.
            part: Its pose and motion, field frame.

        Returns:
            Pose and motion with which the piece comes loose; None: it stays.
        """
        way = self._ways.get(placer)
        reach = float(self._pieces.radius[slot])
        if way is None or way.slot != slot or math.dist(way.pos, part.pos) > _CARRIED:
            way = self._ways[placer] = _Way(slot, part.pos, part.quat)
            moved = _LOOK
        else:
            moved = math.dist(way.pos, part.pos) + reach * _angle(way.quat, part.quat)
        if moved < _STANDS:
            return None
        before, turned, way.pos, way.quat = way.pos, way.quat, part.pos, part.quat
        way.is_free = not self._is_near(part.pos, reach + moved)
        if way.is_free:
            way.free = part.pos, part.quat
            return None
        looks = math.ceil(moved / _LOOK)
        for number in range(1, looks + 1):
            share = number / looks
            x, y, z = (a + share * (b - a) for a, b in zip(before, part.pos, strict=True))
            quat = interpolate(turned, part.quat, share)
            depth = self._pieces.depth(slot, (x, y, z), quat)
            way.is_free = self._pieces.is_free(slot, depth)
            if way.is_free:
                way.free = (x, y, z), quat
            elif way.free is not None and depth > placer.config.give:
                return PartState(*way.free, part.vel, part.rate)
        return None

    def _is_near(self, pos: Vector, reach: float) -> bool:
        low, high = [c - reach for c in pos], [c + reach for c in pos]
        return pos[2] < reach or not self._world.is_free(low, high)


def _angle(a: Quaternion, b: Quaternion) -> float:
    """Between two attitudes, if it is small [rad]."""
    same = abs(math.fsum(p * q for p, q in zip(a, b, strict=True)))  # q and -q are the same attitude
    return 2.0 * math.sqrt(max(0.0, 2.0 - 2.0 * same))


_log = logging.getLogger(__name__)


class PieceFlow:
    """Moves pieces between the field and the robots, and notes where they went.

    Args:
        world: Where the pieces live.
        pieces: All of them.
        robots: All of them.
        record: Of the run.
    """

    def __init__(
        self, world: PhysicsWorld, pieces: GamePieceManager, robots: Sequence[Robot], record: RunRecord
    ) -> None:
        self._world = world
        self._pieces = pieces
        self._robots = robots
        self._record = record
        self.clear()

    def clear(self) -> None:
        """Forget what was in the way of pieces, as a match begins."""
        self._contact = HeldContact(self._world, self._pieces)
        self._is_blocked: set[tuple[int, int]] = set()  # robot and shooter by number
        self._is_jammed: set[tuple[int, str]] = set()  # robot by number, and storage

    # --- in -------------------------------------------------------------------------------------------------------

    def take_in(self) -> None:
        """Let intakes and placers take what they reach."""
        for robot in self._robots:
            slots = self._in_reach(robot, self._pieces.fastest * TICK)
            if len(slots):
                self._take_some_of(robot, slots)
            else:
                for intake in robot.intakes:
                    intake.pass_tick()
            for placer in robot.placers:
                if placer.takes and placer.is_at_handover and robot.storage_of(placer.config).in_turn:
                    placer.take(robot.storage_of(placer.config).take())
                    self._is_jammed.discard((robot.number, robot.storage_of(placer.config).config.name))
            robot.follow_hoppers(self._pieces.radius)
            robot.balance.update(self._pieces.mass, self._pieces.radius)
            robot.begin_tick()

    def _room_behind(self, robot: Robot, intake: Intake) -> int:
        """How many pieces an intake can take; none with a roller that holds a piece of a placer already."""
        rollers = [placer.config.roller for placer in robot.placers if placer.piece is not None]
        if intake.config.roller in rollers:
            return 0
        storage, wanted = robot.storage_of(intake.config), intake.config.kinds
        if storage.hopper is None:
            return storage.room
        radii = (kind.bounding_radius for kind in self._pieces.types if not wanted or kind.name in wanted)
        return storage.room_for(max(radii, default=0.0))

    def _in_reach(self, robot: Robot, moved: float) -> IntArray:
        """Slots of the pieces that may be taken by what takes pieces now.

        Args:
            robot: By which.
            moved: As far as a piece came since the last tick [m].
        """
        takers: list[Intake | Placer] = [
            intake for intake in robot.intakes if intake.is_active and self._room_behind(robot, intake) > 0
        ]
        takers += [placer for placer in robot.placers if placer.takes]
        if not takers:
            return np.zeros(0, dtype=np.int64)
        state, chassis = self._pieces.state, robot.chassis
        slots = self._pieces.on_field()  # sleepers too: a roller does not ask
        pos = state.pos.take(slots, axis=0)
        near: BoolArray = np.zeros(len(slots), dtype=bool)
        for taker in takers:
            before, now, radius = taker.around
            place = on_part((chassis.pos, chassis.quat), now)
            away = pos - place
            reach = radius + math.dist(place, on_part(robot.pose_before, before)) + moved
            near |= np.einsum("ij,ij->i", away, away) < reach * reach
        near &= ~self._pieces.is_untouched[slots]
        return slots[near]

    def _take_some_of(self, robot: Robot, slots: IntArray) -> None:
        state = self._pieces.state
        pos, quat = robot.pose_before
        now = field_to_robot(state.pos[slots], np.array(robot.chassis.pos), np.array(robot.chassis.quat))
        before = field_to_robot(state.before[slots], np.array(pos), np.array(quat))
        free: BoolArray = np.ones(len(slots), dtype=np.bool_)
        for intake in robot.intakes:
            taken = intake.captured(before, now) & free & self._is_kind(slots, intake.config.kinds)
            chosen = np.nonzero(taken)[0][: max(0, self._room_behind(robot, intake))]
            free[chosen] = False
            self._hold(robot, slots[chosen])
            robot.storage_of(intake.config).add(slots[chosen].tolist())
        for placer in robot.placers:
            is_fed = placer.is_at_handover and bool(robot.storage_of(placer.config).in_turn)
            if placer.takes and not is_fed:
                at = np.nonzero(placer.captured(now) & free & self._is_kind(slots, placer.config.kinds))[0]
                if len(at):
                    free[at[0]] = False
                    self._hold(robot, slots[at[:1]])
                    placer.take(int(slots[at[0]]))

    def _hold(self, robot: Robot, slots: IntArray) -> None:
        if len(slots):
            state = self._pieces.state
            self._record.note_taken_in(slots, robot.number)
            for slot in slots.tolist():
                (x, y, z), (u, v, w) = state.pos[slot].tolist(), state.vel[slot].tolist()
                robot.balance.exchange(float(self._pieces.mass[slot]), (x, y, z), (u, v, w))
            self._pieces.hold(slots, robot.number)

    def _is_kind(self, slots: IntArray, kinds: Sequence[str]) -> BoolArray:
        if not kinds:
            return np.ones(len(slots), dtype=np.bool_)
        is_wanted = np.array([kind.name in kinds for kind in self._pieces.types], dtype=np.bool_)
        return is_wanted[self._pieces.state.kind[slots]]

    # --- out ------------------------------------------------------------------------------------------------------

    def let_go(self, time: float) -> None:
        """Let pieces leave the muzzles of shooters whose gate is open, and placers that turn out, at a time [s]."""
        for robot in self._robots:
            for name in robot.advance_hoppers(self._world.gravity):
                if (robot.number, name) not in self._is_jammed:
                    self._is_jammed.add((robot.number, name))  # until a piece leaves it
                    its = f"its hopper{name and f' {name!r}'}"
                    _log.warning("robot %d at %.2f s: two pieces jam the outlet of %s", robot.number, time, its)
            for number, shooter in enumerate(robot.shooters):
                self._let_shoot(robot, number, shooter, time)
            for placer in robot.placers:
                if placer.piece is None:
                    continue
                part = robot.part_in_field(placer.held_state())
                loose = self._contact.follow(placer, placer.piece, part)
                if loose is not None:
                    self._knock_out(robot, placer, placer.piece, loose, time)
                elif placer.releases and self._contact.is_free(placer):  # in something it sticks in the placer
                    self._record.put_down += 1
                    self._leave(robot, placer, part)

    def _let_shoot(self, robot: Robot, number: int, shooter: Shooter, time: float) -> None:
        obstacles: list[str] = []
        struck: dict[int, Launch] = {}

        def is_free(launch: Launch) -> bool:
            name, slots = self._muzzle_obstacle(robot, shooter, launch)
            obstacles.append(name)
            struck.update(dict.fromkeys(slots, launch))
            return not name

        for launch in shooter.update(self._ready(robot, shooter.config), is_free):
            self._shoot(robot, shooter, launch)
        for slot, launch in struck.items():
            self._strike(robot, shooter, launch, slot)
        self._note_blocked((robot.number, number), obstacles, time)

    def _ready(self, robot: Robot, shooter: ShooterConfig) -> int:
        """How many pieces of a shooter's kinds come next out of its storage, before another kind is in the way."""
        storage = robot.storage_of(shooter)
        if not shooter.kinds:
            return len(storage.pieces if storage.hopper is None else storage.in_turn)
        count = 0
        for slot in storage.in_turn:
            if self._kind_of(slot).name not in shooter.kinds:
                break
            count += 1
        return count

    def _kind_of(self, slot: int) -> GamePieceConfig:
        kind: GamePieceConfig = self._pieces.types[self._pieces.state.kind[slot]]
        return kind

    def _muzzle_obstacle(self, robot: Robot, shooter: Shooter, launch: Launch) -> tuple[str, list[int]]:
        """Name of what keeps the next piece from leaving a muzzle, empty if it is free; and slots of pieces there.

        Of other pieces one that is still there, by more than foam gives: it jams the shooter until it has gone.
        """
        slot = robot.storage_of(shooter.config).in_turn[0]
        kind, muzzle = self._kind_of(slot), self._as_it_leaves(robot, shooter, launch, slot).pos
        motion = robot.motion_at(launch.delay / TICK)
        up = rotate(motion.quat, (0.0, 0.0, robot.chassis.config.center_of_mass_height))
        inside = (motion.pos[0] + up[0], motion.pos[1] + up[1], motion.pos[2] + up[2])
        row = muzzle_obstacle(self._world, inside, muzzle, kind.inner_radius, robot=robot.chassis.row)
        if row >= 0:
            return self._world.body_name(row), []
        others = self._pieces.on_field()
        radii = np.array([one.inner_radius for one in self._pieces.types])[self._pieces.state.kind[others]]
        away = np.linalg.norm(self._places_at(launch, others) - muzzle, axis=1)
        there = others[away < SQUEEZE * (kind.inner_radius + radii)].tolist()
        return (f"another {self._kind_of(there[0]).name}" if there else ""), there

    def _as_it_leaves(self, robot: Robot, shooter: Shooter, launch: Launch, slot: int) -> PartState:
        radius = float(self._pieces.radius[slot])
        return shooter.released(launch, radius=radius, robot=robot.motion_at(launch.delay / TICK))

    def _places_at(self, launch: Launch, slots: IntArray) -> FloatArray:
        """Where pieces are at the instant of a launch [m], shape (n, 3)."""
        state = self._pieces.state
        places: FloatArray = state.pos[slots] - (TICK - launch.delay) * state.vel[slots]  # of the end of the tick
        return places

    def _strike(self, robot: Robot, shooter: Shooter, launch: Launch, slot: int) -> None:
        """Let the next piece strike a loose one in front of its muzzle.

        It comes along the barrel at the speed of a shot, and strikes as balls of their inner radii do without friction.
        The loose piece goes; the wheels still have the other one, bring it to speed again and lose what the loose one
        gained.
        """
        state, slots, waiting = self._pieces.state, np.array([slot]), robot.storage_of(shooter.config).in_turn
        if not waiting:  # the last one has left another barrel
            return
        fed = waiting[0]
        leaves, kinds = self._as_it_leaves(robot, shooter, launch, fed), (self._kind_of(fed), self._kind_of(slot))
        ahead, before = np.array(rotate(leaves.quat, (1.0, 0.0, 0.0))), state.vel[slot].copy()
        masses = float(self._pieces.mass[fed]), float(self._pieces.mass[slot])
        reach = SQUEEZE * (kinds[0].inner_radius + kinds[1].inner_radius)
        beside = self._places_at(launch, slots)[0] - leaves.pos
        beside -= (beside @ ahead) * ahead
        normal = (beside + math.sqrt(max(0.0, reach * reach - float(beside @ beside))) * ahead) / reach
        approach = float((np.array(leaves.vel) - before) @ normal)
        if approach <= 0.0:  # it goes faster
            return
        bounce = 1.0 + pair_restitution(kinds[0].restitution, kinds[1].restitution)
        after = before + bounce * approach * masses[0] / (masses[0] + masses[1]) * normal
        self._pieces.push(slots, np.array([after]))
        shooter.after_shot(masses[1], float((after - before) @ ahead))
        for mass, vel in ((masses[1], before.tolist()), (-masses[1], after.tolist())):
            robot.balance.exchange(mass, leaves.pos, vel)

    def _note_blocked(self, shooter: tuple[int, int], obstacles: Sequence[str], time: float) -> None:
        """Log once when something comes to be in the way of a shooter.

        Args:
            shooter: Numbers of robot and shooter.
            obstacles: What was in the way of this tick's shots, empty for a shot that left; none if none was due.
            time: [s].
        """
        if not obstacles:
            return
        name = max(obstacles)
        if name and shooter not in self._is_blocked:
            _log.warning("robot %d at %.2f s: %s is in front of a muzzle; pieces stay in it", shooter[0], time, name)
            self._is_blocked.add(shooter)
        elif not name:
            self._is_blocked.discard(shooter)

    def _shoot(self, robot: Robot, shooter: Shooter, launch: Launch) -> None:
        """Release a piece at its instant within the tick that ends now, and fly it on to the tick's end."""
        storage = robot.storage_of(shooter.config)
        slot = storage.take()
        self._is_jammed.discard((robot.number, storage.config.name))
        kind = self._kind_of(slot)
        motion = robot.motion_at(launch.delay / TICK)
        size = float(self._pieces.size[slot])
        launch = shooter.gripped(launch, size)
        piece = shooter.released(launch, radius=size * kind.bounding_radius, robot=motion)
        quat = IDENTITY if isinstance(kind.shape, Sphere) else multiply(piece.quat, storage.config.attitude)
        self._pieces.launch(robot.number, piece.pos, piece.vel, piece.rate, slot=slot, quat=quat)
        self._pieces.fly(slot, TICK - launch.delay)
        mass = float(self._pieces.mass[slot])
        shooter.after_shot(mass, float(launch.aim.speed))
        x, y, z = (r + now - then for r, now, then in zip(piece.pos, robot.chassis.pos, motion.pos, strict=True))
        robot.balance.exchange(-mass, (x, y, z), piece.vel)  # with the place where the muzzle is at the tick's end
        self._record.note_shot(slot, robot.number, self._pieces.state.pos[slot].tolist())

    def _knock_out(self, robot: Robot, placer: Placer, slot: int, part: PartState, time: float) -> None:
        """Let a placer's piece go that was driven into the field."""
        self._record.knocked_out += 1
        _log.warning(
            "robot %d at %.2f s: %s in a placer was driven into the field at (%.2f, %.2f, %.2f) m and came out of it",
            *(robot.number, time, self._kind_of(slot).name, *part.pos),
        )
        self._leave(robot, placer, part)

    def _leave(self, robot: Robot, placer: Placer, part: PartState) -> None:
        """Let a placer's piece go with a pose and a motion."""
        self._contact.forget(placer)
        slot = placer.let_go()
        self._pieces.launch(robot.number, part.pos, part.vel, part.rate, slot=slot, quat=part.quat, flying=False)
        robot.balance.exchange(-float(self._pieces.mass[slot]), part.pos, part.vel)

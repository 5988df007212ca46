"""Transfer of pieces into and out of robots: intakes, storages, shooters and placers."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence

import numpy as np

from simcore.match.run_record import RunRecord
from simcore.pieces.flight import SQUEEZE, muzzle_obstacle
from simcore.pieces.kinds import GamePieceConfig
from simcore.pieces.launch import Launch
from simcore.pieces.piece_manager import GamePieceManager
from simcore.robot.intake import Intake, field_to_robot, on_part
from simcore.robot.placer import Placer
from simcore.robot.robot import Robot
from simcore.robot.shooter import Shooter, ShooterConfig
from simcore.typing import BoolArray, IntArray
from simcore.units import TICK
from simcore.world.linkage import PartState
from simcore.world.rotation import IDENTITY, multiply, rotate
from simcore.world.shapes import Sphere
from simcore.world.world import PhysicsWorld

__all__ = ["PieceFlow"]

_log = logging.getLogger(__name__)
_NONE: IntArray = np.zeros(0, dtype=np.int64)


class PieceFlow:
    """Transfer of pieces between the field and robots, which records each intake, shot and placement.

    Args:
        world: Physics world of the pieces.
        pieces: All pieces.
        robots: All robots.
        record: Record of the run.
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
        """Clear the sets of blocked muzzles and jammed storages, so that the next block or jam is logged again.

        Call the method at the start of a match and after a reset of the field.
        """
        self._is_blocked: set[tuple[int, int]] = set()  # numbers of robot and shooter
        self._is_jammed: set[tuple[int, str]] = set()  # number of the robot, and storage

    # --- in -------------------------------------------------------------------------------------------------------

    def take_in(self) -> None:
        """Move pieces within reach into robots, hand pieces from storages to placers, and begin the robots' tick."""
        for robot, slots in zip(self._robots, self._in_reach(self._pieces.fastest * TICK), strict=True):
            slots = slots[self._pieces.is_on_field[slots]]  # an earlier robot may have taken some of them
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
        """Return the number of pieces that an intake can move into the storage.

        The number is 0 if a placer with a piece uses the same roller.
        """
        rollers = [placer.config.roller for placer in robot.placers if placer.piece is not None]
        if intake.config.roller in rollers:
            return 0
        storage, wanted = robot.storage_of(intake.config), intake.config.kinds
        if storage.hopper is None:
            return storage.room
        radii = (kind.bounding_radius for kind in self._pieces.types if not wanted or kind.name in wanted)
        return storage.room_for(max(radii, default=0.0))

    def _in_reach(self, moved: float) -> list[IntArray]:
        """Return the slots of the pieces that active intakes and placers could reach, one array per robot.

        Args:
            moved: Largest distance that any piece has moved in a tick [m].
        """
        owners, places, reaches = [], [], []
        for robot in self._robots:
            pose = robot.chassis.pos, robot.chassis.quat
            for taker in self._takers(robot):
                before, now, radius = taker.around
                owners.append(robot.number)
                places.append(on_part(pose, now))
                reaches.append(radius + math.dist(places[-1], on_part(robot.pose_before, before)) + moved)
        found = [_NONE] * len(self._robots)
        if owners:
            slots = self._pieces.on_field()  # also sleeping pieces, which a roller takes as well
            away = self._pieces.state.pos.take(slots, axis=0) - np.array(places)[:, None]
            near = np.einsum("kij,kij->ki", away, away) < np.square(reaches)[:, None]
            near &= ~self._pieces.is_untouched[slots]
            for number in set(owners):
                found[number] = slots[near[np.array(owners) == number].any(axis=0)]
        return found

    def _takers(self, robot: Robot) -> list[Intake | Placer]:
        """Return the active intakes with room for a piece, and the placers that take pieces now."""
        intakes = [one for one in robot.intakes if one.is_active and self._room_behind(robot, one) > 0]
        return [*intakes, *(placer for placer in robot.placers if placer.takes)]

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
        """Advance hoppers, shoot pieces from shooters with an open gate, and release pieces from placers.

        A piece stays in the robot if an obstacle blocks the muzzle or if the placer's piece overlaps another body. The
        method logs each new jam and each newly blocked muzzle.

        Args:
            time: Simulated time, for log messages [s].
        """
        for robot in self._robots:
            for name in robot.advance_hoppers(self._world.gravity):
                if (robot.number, name) not in self._is_jammed:
                    self._is_jammed.add((robot.number, name))  # until a piece leaves the storage
                    its = f"its hopper{name and f' {name!r}'}"
                    _log.warning("robot %d at %.2f s: pieces jam the outlet of %s", robot.number, time, its)
            for number, shooter in enumerate(robot.shooters):
                self._let_shoot(robot, number, shooter, time)
            for placer in robot.placers:
                if placer.piece is None or not placer.releases:
                    continue
                part = robot.part_in_field(placer.held_state())
                depth = self._pieces.depth(placer.piece, part.pos, part.quat)
                if self._pieces.is_free(placer.piece, depth):  # a piece inside a wall or pipe stays in the placer
                    self._put_down(robot, placer, part)

    def _let_shoot(self, robot: Robot, number: int, shooter: Shooter, time: float) -> None:
        obstacles: list[str] = []

        def is_free(launch: Launch) -> bool:
            obstacles.append(self._muzzle_obstacle(robot, shooter, launch))
            return not obstacles[-1]

        for launch in shooter.update(self._ready(robot, shooter.config), is_free):
            self._shoot(robot, shooter, launch)
        self._note_blocked((robot.number, number), obstacles, time)

    def _ready(self, robot: Robot, shooter: ShooterConfig) -> int:
        """Return how many of the next pieces in the storage are of the shooter's kinds, without interruption."""
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

    def _muzzle_obstacle(self, robot: Robot, shooter: Shooter, launch: Launch) -> str:
        """Return the name of an obstacle for the next piece between robot and muzzle; empty if there is no obstacle.

        Another piece is an obstacle if the pieces would overlap by more than foam can compress. The other piece then
        blocks the shooter until the muzzle is free.
        """
        slot = robot.storage_of(shooter.config).in_turn[0]
        kind, motion = self._kind_of(slot), robot.motion_at(launch.delay / TICK)
        muzzle = shooter.released(launch, radius=float(self._pieces.radius[slot]), robot=motion).pos
        up = rotate(motion.quat, (0.0, 0.0, robot.chassis.config.center_of_mass_height))
        inside = (motion.pos[0] + up[0], motion.pos[1] + up[1], motion.pos[2] + up[2])
        row = muzzle_obstacle(self._world, inside, muzzle, kind.inner_radius, robot=robot.chassis.row)
        if row >= 0:
            return self._world.body_name(row)
        others, state = self._pieces.on_field(), self._pieces.state
        radii = np.array([one.inner_radius for one in self._pieces.types])[state.kind[others]]
        places = state.pos[others] - (TICK - launch.delay) * state.vel[others]  # at the time of the launch
        away = np.linalg.norm(places - muzzle, axis=1)
        there = others[away < SQUEEZE * (kind.inner_radius + radii)].tolist()
        return f"another {self._kind_of(there[0]).name}" if there else ""

    def _note_blocked(self, shooter: tuple[int, int], obstacles: Sequence[str], time: float) -> None:
        """Log a warning when an obstacle begins to block a shooter; log again only after a shot has left.

        Args:
            shooter: Numbers of the robot and the shooter.
            obstacles: Obstacle of each shot in this tick, an empty string for a shot that has left.
            time: Simulated time [s].
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
        """Release a piece at the launch time, advance the flight to the end of the tick, and record the shot."""
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
        robot.balance.exchange(-mass, (x, y, z), piece.vel)  # with the muzzle's position at the end of the tick
        self._record.note_shot(slot, robot.number, self._pieces.state.pos[slot].tolist())

    def _put_down(self, robot: Robot, placer: Placer, part: PartState) -> None:
        """Release a placer's piece with the pose and velocity of a part in the field frame, and count the release."""
        self._record.put_down += 1
        slot = placer.let_go()
        self._pieces.launch(robot.number, part.pos, part.vel, part.rate, slot=slot, quat=part.quat, flying=False)
        robot.balance.exchange(-float(self._pieces.mass[slot]), part.pos, part.vel)

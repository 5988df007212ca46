"""A field with one robot and no pieces but those it shoots: where it can stand, and real shots of the engine."""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.scatter import Scatter
from simcore.match.starts import StartError
from simcore.pieces.flight import free_shares, path
from simcore.pieces.pool import PieceStatus
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.shooting.shot_task import ShotDraws, ShotTask, Stand
from simcore.typing import FloatArray
from simcore.units import GRAVITY, TICK, degrees

__all__ = ["PracticeField", "RealShot"]

_TURN = degrees(5.0)
_FARTHEST_TURN = degrees(90.0)
_DEVIATIONS = np.array([(0.0, 0.0), (2.0, 2.0), (2.0, -2.0), (-2.0, 2.0), (-2.0, -2.0)])
"""Of the shots whose way must be free: up and aside, in standard deviations."""
_ROOM = 0.02
"""Added to a piece's radius where its way must be free [m]: one that grazes a bar by 5 mm goes elsewhere."""
_LEVEL = 0.005  # [m] and [rad]: a robot on a bump shoots otherwise
_LONGEST = 300  # ticks of a shot
_MOST_WAITS = 20  # ticks until a shot must have left


class RealShot(NamedTuple):
    """A shot that the engine played: its places from the end of the tick in which it left [m], its velocity there."""

    points: FloatArray
    vel: FloatArray
    scored: bool


class PracticeField:
    """The game's field without its pieces, and the robot on it. Use as a context manager.

    Args:
        task: Which shooter, at what.
        barrel: Number of the only barrel that shoots.
        seed: Of what is left to chance.
        engine: Name of the physics engine; None: see `engine_choice`.
    """

    def __init__(self, task: ShotTask, *, barrel: int = 0, seed: int = 0, engine: str | None = None) -> None:
        self.task = task
        launch = replace(task.shooter.launch, barrels=(task.barrels[barrel],))
        shooters = tuple(replace(one, launch=launch) if one is task.shooter else one for one in task.robot.shooters)
        entry = RobotEntry(config=replace(task.robot, shooters=shooters), preload=0)
        game = replace(task.game, staging=lambda rng, entries: [], preload=0)
        self._match = Match(game, robots=[entry], practice=True, seed=seed, engine=engine)
        self._robot = self._match.robots[0]
        self._slot = self._match.pieces.stage(task.kind.name, 1)
        self._match.pieces.hold(self._slot, 0)

    def __enter__(self) -> PracticeField:
        return self

    def __exit__(self, *_: object) -> None:
        self._match.close()

    # --- where the robot can stand ----------------------------------------------------------------------------------

    def stands(self, wanted: Stand) -> list[Stand]:
        """Where the robot can stand at a distance and look at the target, the most straight on first.

        Level, on the carpet, up to 90 degrees to either side of where a shot comes straight at the opening.
        """
        found = []
        for number in range(round(_FARTHEST_TURN / _TURN) + 1):
            for side in (1.0, -1.0) if number else (1.0,):
                stand = wanted._replace(bearing=self.task.opening.approach + side * number * _TURN)
                with contextlib.suppress(StartError):
                    self._carry(stand, stand.bearing)
                    chassis = self._robot.chassis
                    if abs(chassis.pos[2]) < _LEVEL and math.hypot(*chassis.roll_pitch_yaw[:2]) < _LEVEL:
                        found.append(stand)
        return found

    def _carry(self, stand: Stand, yaw: float) -> None:
        x, y = stand.place(self.task.opening.middle)
        self._match.carry_to(0, (x, y, yaw - self.task.shooter.launch.heading))

    def _send_off(self, stand: Stand, yaw: float) -> None:
        """Let the robot drive at the stand's velocity, so that it comes by its place in half a tick."""
        heading, chassis = yaw - self.task.shooter.launch.heading, self._robot.chassis
        vx, vy, _ = stand.velocity.tolist()
        drive = self._robot.drive
        if isinstance(drive, TankDrive) or not (vx or vy):
            return
        c, s = math.cos(heading), math.sin(heading)
        along, across = c * vx + s * vy, c * vy - s * vx
        x, y, z = chassis.pos
        self._match.world.set_pose(chassis.row, (x - 0.5 * TICK * vx, y - 0.5 * TICK * vy, z), chassis.quat)
        self._match.world.set_velocity(chassis.row, (vx, vy, 0.0))
        chassis.read()
        drive.reset(vx=along, vy=across)
        drive.set_chassis_speeds(along, across, 0.0)

    def is_way_free(self, stand: Stand, elevation: float, speed: float, scatter: Scatter) -> bool:
        """Whether nothing is in the way of shots from any barrel, until they are over the opening.

        Those as meant, by elevation [rad] and speed [m/s], must come there; those that are off to either side, up or
        down by two standard deviations must come half of the way.
        """
        task, opening = self.task, self.task.opening
        barrel = np.repeat(np.arange(len(task.barrels)), len(_DEVIATIONS))
        up, aside = np.tile(_DEVIATIONS, (len(task.barrels), 1)).T
        n = len(barrel)
        draws = ShotDraws.none(n)._replace(
            exit_speed=np.exp(scatter.exit_speed * up),
            elevation=scatter.elevation * up,
            azimuth=scatter.azimuth * aside,
        )
        meant = np.full(n, elevation), np.full(n, speed)
        rows = task.rows(stand, *meant, task.lead(stand, *meant), barrel, draws)
        points = path(rows, math.ceil(2.0 * speed / (GRAVITY * TICK)))  # back at the muzzle's height at the latest
        start, end = points[:-1], points[1:]
        depth = (end - opening.middle) @ opening.inward
        is_over = (-opening.reach < depth) & (depth <= 0.0) & opening.holds(end.reshape(-1, 3)).reshape(depth.shape)
        is_meant = up == 0.0
        if not is_over[:, is_meant].any(axis=0).all():
            return False
        is_near = np.hypot(*np.moveaxis(end - rows.pos, -1, 0)[:2]) < 0.5 * stand.distance
        flies = (is_meant | np.logical_and.accumulate(is_near)) & ~np.logical_or.accumulate(is_over)
        start, end, wide = start[flies], end[flies], task.kind.bounding_radius + _ROOM
        world = self._match.world
        close = world.near_field(start, np.linalg.norm(end - start, axis=1) + wide)  # no other robot is there
        shares = free_shares(world, start[close], end[close], wide, robot=self._robot.chassis.row)
        return bool((shares >= 1.0).all())

    # --- real shots -------------------------------------------------------------------------------------------------

    def shoot(self, stand: Stand, elevation: float, speed: float, *, turn: float = 0.0) -> RealShot | None:
        """Let the robot shoot once from a stand, turned beyond the aim [rad]; None if the piece has not left.

        Wheels and hood are where elevation [rad] and speed [m/s] have them as the gate opens; the rest is the match's.
        """
        match, task, slot = self._match, self.task, int(self._slot[0])
        mechanisms = self._robot.mechanisms
        yaw = task.lead(stand, np.array([elevation]), np.array([speed]))
        self._carry(stand, float(yaw[0]) + turn)
        if match.pieces.state.status[slot] != PieceStatus.HELD:
            match.pieces.hold(self._slot, 0)
        storage = self._robot.storage_of(task.shooter)
        storage.discard(slot)
        storage.add([slot])
        shots = len(match.record.shots)
        self._send_off(stand, float(yaw[0]) + turn)
        for _ in range(_MOST_WAITS):
            self._set(elevation, speed)
            match.tick()
            if len(match.record.shots) > shots:
                break
        else:
            return None
        for name in task.shooter.gate:
            mechanisms[name].velocity = 0.0
        vel = match.pieces.state.vel[slot].copy()
        for _ in range(_LONGEST):
            match.tick()
            has_scored = match.record.shots[-1].scored
            is_down = match.pieces.state.pos[slot, 2] < 2.0 * task.kind.bounding_radius
            if has_scored or (is_down and not match.pieces.is_untouched[slot]):
                break
        return RealShot(np.array(match.record.shots[-1].points), vel, has_scored)

    def _set(self, elevation: float, speed: float) -> None:
        """Wheels, hood and gate as a shot needs them, this tick."""
        shooter, mechanisms = self.task.shooter, self._robot.mechanisms
        turning = dict.fromkeys(shooter.wheels, shooter.wheel_speed_for(speed))
        for name in shooter.gate:
            turning[name] = (2.0 * shooter.gate_speed + 1.0) * (-1.0 if name in shooter.gate_reversed else 1.0)
        for name, velocity in turning.items():
            mechanisms[name].velocity = velocity
            mechanisms[name].coast()
        hood = self.task.hood_for(elevation)
        if shooter.hood is not None and hood is not None:
            mechanisms[shooter.hood].position, mechanisms[shooter.hood].velocity = hood, 0.0

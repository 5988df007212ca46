"""A field with one robot and no pieces but those it shoots: where it can stand, and shots in a match."""

from __future__ import annotations

import contextlib
import math
from dataclasses import replace

import numpy as np

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.match.starts import StartError
from simcore.pieces.pool import PieceStatus
from simcore.robot.fixed_wheel_drive import TankDrive
from simcore.shooting.shot_task import ShotTask, Stand
from simcore.units import TICK, degrees

__all__ = ["PracticeField"]

_TURN = degrees(5.0)
_FARTHEST_TURN = degrees(90.0)
_LEVEL = 0.005  # [m] and [rad]: a robot on a bump shoots otherwise
_LONGEST = 300  # ticks of a shot
_MOST_WAITS = 20  # ticks until a shot must have left


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
        self._shooter = self._robot.shooters[task.robot.shooters.index(task.shooter)]
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

    # --- real shots -------------------------------------------------------------------------------------------------

    def shoot(self, stand: Stand, elevation: float, speed: float, *, turn: float = 0.0) -> bool | None:
        """Whether a shot of the robot scores, from a stand, turned beyond the aim [rad]; None if none has left.

        Wheels and hood are where elevation [rad] and speed [m/s] have them as the gate opens; a shooter without a hood
        is built at that elevation. The rest is the match's.
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
        for _ in range(_LONGEST):
            match.tick()
            is_down = match.pieces.state.pos[slot, 2] < 2.0 * task.kind.bounding_radius
            if match.record.shots[-1].scored or (is_down and not match.pieces.is_untouched[slot]):
                break
        scored: bool = match.record.shots[-1].scored
        return scored

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
        if shooter.hood is None or hood is None:
            self._shooter.config = replace(self._shooter.config, elevation=elevation)
        else:
            mechanisms[shooter.hood].position, mechanisms[shooter.hood].velocity = hood, 0.0

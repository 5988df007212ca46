"""Shots of a robot in a match by wheels, hood and gate, to compare with predicted flights."""

from __future__ import annotations

import math
from dataclasses import replace

from simcore.match.game import RobotEntry
from simcore.match.match import Match
from simcore.pieces.pool import PieceStatus
from simcore.sweep.shot_task import ShotTask, Stand

_MOST_WAITS, _LONGEST = 20, 300  # ticks in which a shot must leave, and come down


class RealShots:
    """The game's field without pieces, and a robot at rest that shoots one piece. Use as a context manager."""

    def __init__(self, task: ShotTask, *, barrel: int = 0, seed: int = 0) -> None:
        self.task = task
        launch = replace(task.shooter.launch, barrels=(task.barrels[barrel],))
        shooters = tuple(replace(one, launch=launch) if one is task.shooter else one for one in task.robot.shooters)
        entry = RobotEntry(config=replace(task.robot, shooters=shooters), preload=0)
        game = replace(task.game, staging=lambda rng, entries: [], preload=0)
        self.match = Match(game, robots=[entry], practice=True, seed=seed)
        self.robot = self.match.robots[0]
        self.shooter = self.robot.shooters[task.robot.shooters.index(task.shooter)]
        self.slot = self.match.pieces.stage(task.kind.name, 1)
        self.match.pieces.hold(self.slot, 0)

    def __enter__(self) -> RealShots:
        return self

    def __exit__(self, *_: object) -> None:
        self.match.close()

    def shoot(self, stand: Stand, elevation: float, speed: float) -> bool:
        """Return whether a shot at an elevation [rad] and speed [m/s] scores, from a stand at rest."""
        match, task, slot = self.match, self.task, int(self.slot[0])
        match.carry_to(0, (*stand.place(task.opening.middle), task.aim(stand) - task.shooter.launch.heading))
        if match.pieces.state.status[slot] != PieceStatus.HELD:
            match.pieces.hold(self.slot, 0)
        storage = self.robot.storage_of(task.shooter)
        storage.discard(slot)
        storage.add([slot])
        shots = len(match.record.shots)
        for _ in range(_MOST_WAITS):
            self._set(elevation, speed)
            match.tick()
            if len(match.record.shots) > shots:
                break
        else:
            raise AssertionError("no shot has left")
        for name in task.shooter.gate:
            self.robot.mechanisms[name].velocity = 0.0
        for _ in range(_LONGEST):
            match.tick()
            is_down = match.pieces.state.pos[slot, 2] < 2.0 * task.kind.bounding_radius
            if match.record.shots[-1].scored or (is_down and not match.pieces.is_untouched[slot]):
                break
        scored: bool = match.record.shots[-1].scored
        return scored

    def _set(self, elevation: float, speed: float) -> None:
        """Set wheels, hood and gate for a shot in this tick."""
        shooter, mechanisms = self.task.shooter, self.robot.mechanisms
        turning = dict.fromkeys(shooter.wheels, shooter.wheel_speed_for(speed))
        for name in shooter.gate:
            turning[name] = (2.0 * shooter.gate_speed + 1.0) * (-1.0 if name in shooter.gate_reversed else 1.0)
        for name, velocity in turning.items():
            mechanisms[name].velocity = velocity
            mechanisms[name].coast()
        hood = self.task.hood_for(elevation)
        if shooter.hood is None or hood is None:
            self.shooter.config = replace(self.shooter.config, elevation=elevation)
        else:
            mechanisms[shooter.hood].position, mechanisms[shooter.hood].velocity = hood, 0.0


def low_shooter(robot):
    """Return a robot with a muzzle 0.35 m high at 62 deg, without a hood: shots rise steeply past the rim."""
    launch = replace(robot.shooters[0].launch, height=0.35)
    shooter = replace(robot.shooters[0], hood=None, elevation=math.radians(62.0), launch=launch)
    return replace(robot, shooters=(shooter,))

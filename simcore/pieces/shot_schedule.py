"""When pieces leave the robot: gate, cooldown, barrels, and a mean rate that ticks do not bend."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simcore.errors import ConfigError, NonFiniteError
from simcore.pieces.launch import Aim, LaunchParameters
from simcore.quantities import RATE, SPEED, require
from simcore.typing import BoolSupplier, FloatSupplier

__all__ = ["Launch", "ShotErrors", "ShotSchedule"]

_EARLIEST = -0.2  # of the period: pieces behind each other do not leave at once
_SAME_INSTANT = 1e-9  # an event this close to the end of a tick belongs to the next one [s]


@dataclass(frozen=True, slots=True)
class Launch:
    """One piece that leaves in this tick; `launch_state` turns it into a position and a velocity."""

    barrel: int
    """Index into `LaunchParameters.barrels`."""
    delay: float
    """From the start of the tick to the launch [s]."""
    aim: Aim
    """Speed and direction at that instant, relative to the robot."""
    spin: float = 1.0
    """Factor of the spin that the wheels would give it [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotErrors:
    """What single shots of a shooter are off by; suppliers are called once a shot, in the order of the shots."""

    exit_speed: FloatSupplier
    """Factor of the speed at which it leaves [-]."""
    elevation: FloatSupplier
    """[rad]"""
    azimuth: FloatSupplier
    """To the left [rad]."""
    spin: FloatSupplier
    """Factor [-]."""
    feed_time: FloatSupplier
    """Until the next one [s]."""
    hood: float = 0.0
    """How much farther the hood truly is than its encoder shows [rad]."""
    turret: float = 0.0
    """The same of the turret [rad]."""


class ShotSchedule:
    """Decides which pieces leave in a tick; knows neither the engine nor the pieces.

    Shots come in events, `shot_rate` of them a second, and each event fires every barrel for which there is a piece.
    The time left to the next event is carried over from tick to tick, so 8 events a second are 8000 in 1000 s though
    0.125 s is no whole number of ticks. While the gate is closed, or the robot is empty, this time only runs down to
    zero: the first shot then comes at once, and nothing that was missed is made up for.

    Args:
        launch: Place of the launcher and its barrels.
        shot_rate: Events a second while the gate is open [1/s].
        aim: Speed and direction of a launch at a share of the tick, from 0 at its start to 1 at its end.
        gate_open: Whether pieces are fed to the wheels.
        min_speed: Below this a piece jams instead of leaving [m/s].
        lateness: Of each event against its turn after the one before it [s], a fifth of the period earlier at most;
            None: none.
    """

    def __init__(
        self,
        launch: LaunchParameters,
        *,
        shot_rate: float,
        aim: Callable[[float], Aim],
        gate_open: BoolSupplier,
        min_speed: float = 0.5,
        lateness: FloatSupplier | None = None,
    ) -> None:
        require("ShotSchedule", "shot_rate", shot_rate, RATE)
        require("ShotSchedule", "min_speed", min_speed, SPEED)
        self.launch = launch
        self.shots = 0
        """Pieces launched since the start."""
        self._period = 1.0 / shot_rate
        self._min_speed = min_speed
        self._aim = aim
        self._gate_open = gate_open
        self._lateness = lateness
        self._until_next = 0.0

    def update(
        self, dt: float, held: int, is_free: Callable[[Launch], bool] | None = None, *, opened: float = 0.0
    ) -> list[Launch]:
        """Launches of a tick; the caller takes as many pieces out of the robot.

        Args:
            dt: Length of the tick [s].
            held: Pieces in the robot; no more than these are launched.
            is_free: Whether nothing is in the way of a launch. A piece that cannot leave stays in the robot; if that is
                so for all barrels, the event stays due, and is tried again as the next tick begins. None: always free.
            opened: From the start of the tick until a gate that is open at its end has opened [s].

        Raises:
            ConfigError: If `dt` is not above zero.
            NonFiniteError: If the gate is open and the aim is not finite.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"ShotSchedule: dt must be finite and > 0 s, got {dt}")
        launches: list[Launch] = []
        if self._gate_open():
            now = self._aim(1.0)
            if not np.isfinite(now.elevation + now.speed + now.turret_angle):
                raise NonFiniteError(
                    f"ShotSchedule: want finite numbers, got elevation {now.elevation} rad, speed {now.speed} m/s,"
                    f" turret {now.turret_angle} rad"
                )
            ready = held if now.speed >= self._min_speed else 0
            self._until_next = max(self._until_next, opened)
            while ready > 0 and self._until_next < dt - _SAME_INSTANT:
                delay = max(0.0, self._until_next)
                aim = self._aim(delay / dt)
                event = [Launch(barrel, delay, aim) for barrel in range(len(self.launch.barrels))]
                if is_free is not None:
                    event = [launch for launch in event if is_free(launch)]
                if not event:
                    break
                launches += event[:ready]
                ready = max(0, ready - len(event))
                self._until_next += self._period
                if self._lateness is not None:
                    self._until_next += max(_EARLIEST * self._period, self._lateness())
        self._until_next -= dt
        if self._until_next < -_SAME_INSTANT:  # no event was due, or none could be: ready, and no more than that
            self._until_next = 0.0
        self.shots += len(launches)
        return launches

"""When pieces leave the robot: gate, cooldown, barrels, and a mean rate that ticks do not bend."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simcore.errors import ConfigError, NonFiniteError, require_non_negative, require_positive
from simcore.pieces.launch import LaunchParameters
from simcore.typing import BoolSupplier, FloatSupplier

__all__ = ["Launch", "ShotSchedule"]

_SAME_INSTANT = 1e-9  # an event this close to the end of a tick belongs to the next one [s]


@dataclass(frozen=True, slots=True)
class Launch:
    """One piece that leaves in this tick; `launch_state` turns it into a position and a velocity."""

    barrel: int
    """Index into `LaunchParameters.barrels`."""
    elevation: float
    """Over the robot's floor plane [rad]."""
    speed: float
    """Relative to the muzzle [m/s]."""
    turret_angle: float
    """Counter-clockwise positive [rad]."""
    delay: float
    """From the start of the tick to the launch [s]."""


class ShotSchedule:
    """Decides which pieces leave in a tick; knows neither the engine nor the pieces.

    Shots come in events, `shot_rate` of them a second, and each event fires every barrel for which there is a piece.
    The time left to the next event is carried over from tick to tick, so 8 events a second are 8000 in 1000 s though
    0.125 s is no whole number of ticks. While the gate is closed, or the robot is empty, this time only runs down to
    zero: the first shot then comes at once, and nothing that was missed is made up for.

    Args:
        launch: Place of the launcher and its barrels.
        shot_rate: Events a second while the gate is open [1/s].
        elevation: Of the launch, as the hood is now [rad].
        speed: Exit speed, as the wheels turn now [m/s].
        gate_open: Whether pieces are fed to the wheels.
        turret_angle: None for a launcher fixed to the robot [rad].
        min_speed: Below this a piece jams instead of leaving [m/s].
    """

    def __init__(
        self,
        launch: LaunchParameters,
        *,
        shot_rate: float,
        elevation: FloatSupplier,
        speed: FloatSupplier,
        gate_open: BoolSupplier,
        turret_angle: FloatSupplier | None = None,
        min_speed: float = 0.5,
    ) -> None:
        require_positive("ShotSchedule", "shot_rate", shot_rate, "1/s")
        require_non_negative("ShotSchedule", "min_speed", min_speed, "m/s")
        self.launch = launch
        self.shots = 0
        """Pieces launched since the start."""
        self._period = 1.0 / shot_rate
        self._min_speed = min_speed
        self._elevation = elevation
        self._speed = speed
        self._gate_open = gate_open
        self._turret_angle = turret_angle
        self._until_next = 0.0

    @property
    def cooldown(self) -> float:
        """Time until the next event may come [s]."""
        return self._until_next

    def reset(self) -> None:
        """Forget cooldown and count, as at the start of a match."""
        self._until_next = 0.0
        self.shots = 0

    def update(self, dt: float, held: int) -> list[Launch]:
        """Launches of the tick that begins now; the caller takes as many pieces out of the robot.

        Args:
            dt: Length of the tick [s].
            held: Pieces in the robot; no more than these are launched.

        Raises:
            ConfigError: If `dt` is not above zero.
            NonFiniteError: If the gate is open and a supplier gives no finite number.
        """
        if not 0.0 < dt < math.inf:
            raise ConfigError(f"ShotSchedule: dt must be finite and > 0 s, got {dt}")
        launches: list[Launch] = []
        if self._gate_open():
            elevation = self._elevation()
            speed = self._speed()
            turret_angle = 0.0 if self._turret_angle is None else self._turret_angle()
            if not (math.isfinite(elevation) and math.isfinite(speed) and math.isfinite(turret_angle)):
                raise NonFiniteError(
                    f"ShotSchedule: want finite numbers, got elevation {elevation} rad, speed {speed} m/s,"
                    f" turret {turret_angle} rad"
                )
            ready = held if speed >= self._min_speed else 0
            while ready > 0 and self._until_next < dt - _SAME_INSTANT:
                delay = max(0.0, self._until_next)
                for barrel in range(min(len(self.launch.barrels), ready)):
                    launches.append(Launch(barrel, elevation, speed, turret_angle, delay))
                ready = max(0, ready - len(self.launch.barrels))
                self._until_next += self._period
        self._until_next -= dt
        if self._until_next < -_SAME_INSTANT:  # no event was due, or none could be: ready, and no more than that
            self._until_next = 0.0
        self.shots += len(launches)
        return launches

"""Fit of a shooter's exit efficiency and spin to measured shots."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from simcore.calibrate.fitting import Estimate, Parameter, fit
from simcore.errors import ConfigError, LogError
from simcore.loop.state import make_memory
from simcore.pieces.flight import FLIGHT_STEP, LONGEST
from simcore.quantities import DEGREES, DURATION, FIELD_LENGTH, RATE, Quantity, require
from simcore.sweep.shot_task import ShotTask, Stand
from simcore.typing import FloatArray
from simcore.world.ball_dynamics import StandingField
from simcore.world.contact_law import CARPET

__all__ = ["Shot", "ShotFit", "fit_shots", "read_shots"]

_SPREAD, _CLOCK = 0.15, 0.05
"""Assumed standard deviations of the distance between hits and the middle of the goal [m], and of flight times [s]."""
_KEYS: dict[str, Quantity] = {
    "distance": FIELD_LENGTH, "rps": RATE, "elevation_deg": DEGREES, "hood_deg": DEGREES, "time": DURATION,
}  # fmt: skip
_OUTCOMES = {"1": "hit", "hit": "hit", "0": "miss", "miss": "miss", "short": "short", "long": "long"}
_OTHER = {"rpm": ("rps", 1.0 / 60.0), "rad_s": ("rps", 1.0 / math.tau), "flight_time": ("time", 1.0),
          "angle_deg": ("elevation_deg", 1.0)}  # fmt: skip
"""Alternative keys, each with the equivalent key in `_KEYS` and the factor that converts the unit."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """Measured shot from a robot at rest."""

    distance: float
    """Horizontal distance from the robot's center to the middle of the goal [m]."""
    rps: float
    """Wheel speed when the piece leaves the shooter [turns/s]; the mean speed if the shooter has several wheels."""
    elevation_deg: float | None = None
    """Elevation of the shot [deg]; None to compute the elevation from `hood_deg`, or for a shooter without a hood."""
    hood_deg: float | None = None
    """Hood angle [deg]; None if the hood angle was not measured."""
    time: float | None = None
    """Time of flight from the muzzle to the goal [s]; None if the time was not measured."""
    result: str = ""
    """Result: `hit`, `miss`, `short` or `long`. An empty result counts as a hit if `time` is None."""

    @classmethod
    def parse(cls, text: str) -> Shot:
        """Parse the command-line notation of a shot, e.g. `distance=2.8,rps=38,time=1.1`.

        Raises:
            ConfigError: If a key is unknown or missing, or a value is out of range.

        >>> Shot.parse("distance=2.8,rps=38").rps
        38.0
        >>> Shot.parse("distance=2.8")
        Traceback (most recent call last):
        simcore.errors.ConfigError: shot: rps is missing, e.g. distance=2.8,rps=38
        """
        parts = [part.partition("=") for part in text.split(",")]
        return cls.of({key.strip(): value.strip() for key, _, value in parts}, "shot")

    @classmethod
    def of(cls, row: dict[str, str], where: str) -> Shot:
        """Create a shot from unparsed values by key, for example a row of a CSV file.

        Args:
            row: Text of each value by key, with the keys of `parse`.
            where: Name of the file and line, or of the option, for messages.

        Raises:
            ConfigError: If a key is unknown or missing, or a value is out of range.
        """
        found: dict[str, object] = {}
        for key, value in row.items():
            if key in ("result", "hit"):
                if value.lower() not in _OUTCOMES:
                    raise ConfigError(f"{where}: {key} must be hit, miss, short or long, got {value!r}")
                found["result"] = _OUTCOMES[value.lower()]
                continue
            name, size = _OTHER.get(key, (key, 1.0))
            if name not in _KEYS:
                hint = "; decimals take a point, as in distance=2.8,rps=38" if key[:1].isdigit() else ""
                raise ConfigError(f"{where}: no key {key!r}. Known: {', '.join((*_KEYS, *_OTHER, 'result'))}{hint}")
            try:
                number: object = size * float(value)
            except ValueError:
                number = value
            require(where, key, number, _KEYS[name])
            found[name] = number
        for field in fields(cls)[:2]:
            if field.name not in found:
                raise ConfigError(f"{where}: {field.name} is missing, e.g. distance=2.8,rps=38")
        return cls(**found)  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True, eq=False)
class ShotFit:
    """Fitted parameters of a shooter, predictions of held-out shots, and properties that remain unknown."""

    estimates: dict[str, Estimate]
    """Estimates by name: `exit_efficiency` [-], and `spin`, the ratio of the spin to that of wheels without slip [-].

    The spin is missing if the shots do not determine the spin.
    """
    rows: Sequence[tuple[Shot, float, float]]
    """Each shot with the prediction by a fit to the other shots: distance beyond the middle of the goal [m], and time
    of flight [s]. Empty if there is only one shot."""
    unknown: Sequence[str]


def read_shots(path: Path) -> list[Shot] | None:
    """Return the shots in a CSV file; return None for a file without a column `distance`, such as a log.

    Raises:
        ConfigError: If a row is invalid; the message names the line.
        LogError: If the file cannot be read.
    """
    try:
        rows = [row for row in csv.reader(path.read_text(encoding="utf-8-sig").splitlines()) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"cannot read {str(path)!r}: {getattr(error, 'strerror', None) or error}") from error
    if not rows or "distance" not in (head := [name.strip() for name in rows[0]]):
        return None
    return [
        Shot.of(
            {key: cell.strip() for key, cell in zip(head, row, strict=False) if cell.strip()},
            f"{path.name}, line {line}",
        )
        for line, row in enumerate(rows[1:], 2)
    ]


def fit_shots(task: ShotTask, shots: Sequence[Shot]) -> ShotFit:
    """Fit the exit efficiency of a shooter to measured shots, and also the spin if the shots determine the spin.

    A miss without a time of flight is ignored.

    Raises:
        ConfigError: If the elevation of a shot is unknown, or the shots do not determine the exit efficiency.
    """
    useful = [shot for shot in shots if shot.time is not None or shot.result != "miss"]
    if not useful:
        raise ConfigError(
            "shots: a miss says nothing unless it is short or long: give hits, flight times, short or long"
        )
    angles = {shot: _elevation(task, shot) for shot in useful}
    start = task.shooter.exit_efficiency

    def landed(shot: Shot, values: FloatArray) -> tuple[float, float]:
        return _flight(task, shot, angles[shot], start * math.exp(values[0]), values[1] if len(values) > 1 else 1.0)

    def errors(shot: Shot, values: FloatArray) -> FloatArray:
        beyond, seconds = landed(shot, values)
        found = [] if shot.time is None else [(seconds - shot.time) / _CLOCK]
        if shot.result in ("hit", "") and (shot.time is None or shot.result):
            found.append(beyond / _SPREAD)
        elif shot.result in ("short", "long"):
            found.append((max(0.0, beyond) if shot.result == "short" else min(0.0, beyond)) / _SPREAD)
        return np.array(found)

    efficiency, spin = Parameter("exit_efficiency", 0.0, -1.6, 1.2, 0.1), Parameter("spin", 1.0, 0.0, 4.0, 0.5)
    has_lift = bool(task.kind.air.lift) and len(useful) > 3
    wanted = [efficiency, *([spin] if has_lift else [])]

    def fitted(some: Sequence[Shot], parameters: Sequence[Parameter]) -> tuple[FloatArray, dict[str, Estimate]]:
        result = fit(lambda x: [errors(shot, x) for shot in some], parameters, noise=1.0)
        return result.values, result.estimates

    unknown: list[str] = []
    raw = fitted(useful, wanted)[1]
    if has_lift and raw["spin"].share > 0.3:
        wanted, has_lift = [efficiency], False
        raw = fitted(useful, wanted)[1]
    if not 0.98 * efficiency.lower < raw["exit_efficiency"].value < 0.98 * efficiency.upper:
        raise ConfigError("shots: no exit efficiency explains them: check distance, elevation and wheel speed")
    if not has_lift:
        unknown.append("spin: speed and spin have the same effect on these shots (the spin of the wheels is assumed)")
    unknown.append("drag: flight times hardly change with it")
    found = {"exit_efficiency": raw["exit_efficiency"].mapped(lambda x: start * math.exp(x))}
    found |= {"spin": raw["spin"]} if has_lift else {}
    if len(useful) == 1:
        unknown.append("how well this predicts: with one shot, none is left to predict")
    rows = []
    for shot in useful if len(useful) > 1 else ():
        others = [other for other in useful if other is not shot]
        rows.append((shot, *landed(shot, fitted(others, wanted)[0])))
    return ShotFit(found, rows, unknown)


def _elevation(task: ShotTask, shot: Shot) -> float:
    """Return the elevation of a shot [rad] from the measured elevation, the hood angle, or a shooter without a hood.

    Raises:
        ConfigError: If the elevation of the shot is unknown.
    """
    if shot.elevation_deg is not None:
        return math.radians(shot.elevation_deg)
    if shot.hood_deg is not None:
        return task.shooter.elevation + task.shooter.elevation_per_hood * math.radians(shot.hood_deg)
    low, high = task.elevations
    if low != high:
        raise ConfigError("shot: the shooter has a hood: add elevation_deg=<of the shot> or hood_deg=<of the hood>")
    return low


def _flight(task: ShotTask, shot: Shot, elevation: float, efficiency: float, spin: float) -> tuple[float, float]:
    """Simulate a shot without field elements until the piece descends through the goal's height.

    Args:
        task: Shooter and goal.
        shot: Distance and wheel speed of the shot.
        elevation: Elevation of the shot [rad].
        efficiency: Exit efficiency of the shooter [-].
        spin: Factor on the spin of the piece [-].

    Returns:
        Distance beyond the middle of the goal [m], and time of flight [s]. If the apex is below the goal, the time is
        that of the apex, and the distance is that of the apex minus twice the missing height.
    """
    speed = (
        task.shooter.exit_speed([shot.rps * math.tau] * len(task.shooter.wheels))
        * efficiency
        / task.shooter.exit_efficiency
    )
    stand = Stand(shot.distance, 0.0)
    balls = task.rows(stand, np.array([elevation]), np.array([speed]))
    balls.spin[:] *= spin
    field, memory, middle = StandingField.of((), CARPET), make_memory(1), task.opening.middle
    for step in range(LONGEST):
        before, speed_up = balls.pos[0].copy(), float(balls.vel[0, 2])
        field.fly(balls, memory, FLIGHT_STEP)
        now = balls.pos[0]
        if before[2] >= middle[2] > now[2] and balls.vel[0, 2] < 0.0:
            share = (before[2] - middle[2]) / (before[2] - now[2])
            place = before + share * (now - before)
            return float(place[0] - middle[0]), FLIGHT_STEP * (step + share)
        if speed_up >= 0.0 > balls.vel[0, 2] and now[2] < middle[2]:
            return float(now[0] - middle[0] - 2.0 * (middle[2] - now[2])), FLIGHT_STEP * (step + 1)
    return 0.0, FLIGHT_STEP * LONGEST

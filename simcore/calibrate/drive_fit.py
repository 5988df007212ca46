"""Fit of drivetrain parameters to logs, and cross-validation on held-out runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from simcore.calibrate.drive_model import DriveConfig, drive, varied
from simcore.calibrate.fitting import Estimate, Fit, Parameter, fit
from simcore.calibrate.runs import Run
from simcore.robot.fixed_wheel_config import TankConfig
from simcore.robot.swerve_config import SwerveConfig
from simcore.typing import FloatArray

__all__ = ["DriveFit", "Prediction", "fit_battery", "fit_drive", "increments", "predictions_of"]

_WINDOW = 0.1  # [s], window over which distances are compared; a longer window would hide the acceleration
_FAST = 0.3  # fraction of a run's top speed; slower data are ignored, as friction and backlash differ at creeping speed
_TOLERANCES = {"speed": 0.05, "sides": 0.01, "lag": 0.012}
"""Smallest deviation of each optional parameter that the fit accepts.

The parameters are the relative free speed (motors differ by 3 %, treads wear by 2.5 %), the relative efficiency of the
sides, and the delay between voltage and readings [s]. The data cannot separate smaller deviations from kS and mass.
"""
_BRISK = 0.5  # [m/s^2], minimum acceleration from which the mass can be fitted
_FOLDS = 5  # maximum number of folds in the cross-validation


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """Held-out run, and the motion that a fit to the other data predicts for the run."""

    run: Run
    way: FloatArray
    """Simulated distance [m] or angle [rad], shape (n,)."""
    first: int = 0
    """Index of the first held-out sample of the run."""

    @property
    def real(self) -> FloatArray:
        """Measured distance [m] or angle [rad], averaged over the sides, shape (n,)."""
        mean: FloatArray = self.run.way.mean(axis=1)
        return mean

    @property
    def error(self) -> float:
        """Error of the final distance divided by the largest distance from the start of the held-out part [-]."""
        real, ours = (way[self.first :] - way[self.first] for way in (self.real, self.way))
        farthest = float(real[np.abs(real).argmax()])
        return float(ours[-1] - real[-1]) / farthest

    @property
    def rms(self) -> float:
        """RMS error of the distance [m] or angle [rad] covered since the start of the held-out part."""
        off = (self.way - self.real)[self.first :]
        return math.sqrt(float(np.mean((off - off[0]) ** 2)))


@dataclass(frozen=True, slots=True, eq=False)
class DriveFit:
    """Fitted parameters of a drivetrain, predictions of held-out runs, and properties that remain unknown."""

    estimates: Mapping[str, Estimate]
    """Estimates by name: `ks` [V], `mass` [kg], `left_efficiency` [-], `right_efficiency` [-], `free_speed_share` [-],
    `wheel_radius` [m] and `lag` [s]. Parameters that the data do not determine are missing."""
    config: DriveConfig
    """Drivetrain with the fitted values."""
    predictions: Sequence[Prediction]
    unknown: Sequence[str]
    """Text for the user about each property that the data do not determine."""


def increments(run: Run, way: FloatArray, window: float = _WINDOW) -> FloatArray:
    """Return the mean speed in successive windows of a run [m/s] or [rad/s], shape (m, sides).

    Args:
        run: Run with the sample times.
        way: Distance [m] or angle [rad] at these times, shape (n,) or (n, sides).
        window: Length of a window [s].
    """
    grid = np.arange(0.0, run.times[-1] + 1e-9, window)
    columns = way.reshape(len(way), -1).T
    speeds: FloatArray = np.diff([np.interp(grid, run.times, column) for column in columns], axis=1).T / window
    return speeds


def fit_drive(config: DriveConfig, runs: Sequence[Run]) -> DriveFit:
    """Fit the parameters of a drivetrain to runs, and predict each run by a fit to other runs.

    If there is only one run, a fit to the first two thirds predicts the last third.
    """
    known = config.wheel_radius
    is_tank = isinstance(config, TankConfig) and all(run.way.shape[1] > 1 for run in runs)
    has_ground = any(run.ground is not None for run in runs)
    swift = max(float(np.abs(np.diff(increments(r, r.way.mean(axis=1)), axis=0)).max()) / _WINDOW for r in runs)
    has_mass = swift > _BRISK and _steps(runs)
    friction = config.modules[0].drive_friction_volts if isinstance(config, SwerveConfig) else config.friction_volts
    share = config.modules[0].free_speed_share if isinstance(config, SwerveConfig) else config.speed_share
    parameters = [Parameter("ks", max(friction, 0.05), 0.0, 4.0, 0.1)]
    parameters += [Parameter("mass", 0.0, -1.8, 1.8, 0.2)] if has_mass else []
    parameters += [Parameter("radius", 0.0, -0.3, 0.3, 0.02)] if has_ground else []
    extra = [Parameter("speed", 0.0, -0.4, 0.4, 0.05)]
    extra += [Parameter("sides", 0.0, -0.4, 0.4, 0.05)] if is_tank else []
    extra += [Parameter("lag", 0.0, -0.05, 0.1, 0.01)] if has_mass else []

    def built(values: Mapping[str, float]) -> DriveConfig:
        return varied(
            config, ks=values["ks"], mass=config.mass * math.exp(values.get("mass", 0.0)),
            sides=values.get("sides", 0.0), speed=share * math.exp(values.get("speed", 0.0)),
            radius=known * math.exp(values.get("radius", 0.0)),
        )  # fmt: skip

    def simulated(values: Mapping[str, float], run: Run) -> tuple[FloatArray, FloatArray]:
        done = drive(built(values), run, radius=known)
        late = run.times - values.get("lag", 0.0)
        way = np.column_stack([np.interp(late, run.times, column) for column in done.way.T])
        return way, done.ground

    def errors(run: Run, values: Mapping[str, float]) -> FloatArray:
        way, ground = simulated(values, run)
        real = run.way if is_tank else run.way.mean(axis=1, keepdims=True)
        speeds = increments(run, real)
        mean = speeds.mean(axis=1)
        is_fast = (np.abs(mean) > _FAST * np.abs(mean).max()) | (np.abs(np.gradient(mean, _WINDOW)) > _BRISK)
        off = (increments(run, way) - speeds)[is_fast]
        if run.ground is not None:
            measured = increments(run, run.ground)[is_fast]
            sign = math.copysign(1.0, float(run.ground[-1]) * float(real[-1].mean()))
            off = np.column_stack([off, increments(run, ground)[is_fast] - sign * measured])
        flat: FloatArray = off.ravel()
        return flat

    def fitted(wanted: Sequence[Parameter], some: Sequence[Run], start: Fit | None = None) -> Fit:
        names = [p.name for p in wanted]
        begin = None if start is None else [start[n] if n in start.names else 0.0 for n in names]
        return fit(
            lambda x: [errors(run, dict(zip(names, x.tolist(), strict=True))) for run in some], wanted, values=begin,
        )  # fmt: skip

    rich = fitted([*parameters, *extra], runs)
    wanted = [*parameters, *(p for p in extra if _is_told(rich, p))]
    best = rich if len(wanted) == len(rich.names) else fitted(wanted, runs, rich)
    raw = best.estimates
    predictions = predictions_of(runs, lambda some: partial(_mean_way, simulated, fitted(wanted, some, best)))
    return _result(config, built(dict(zip(best.names, best.values.tolist(), strict=True))), raw, share, predictions,
                   has_mass=has_mass, has_ground=has_ground)  # fmt: skip


def _mean_way(
    simulated: Callable[[Mapping[str, float], Run], tuple[FloatArray, FloatArray]], found: Fit, run: Run
) -> FloatArray:
    way: FloatArray = simulated(dict(zip(found.names, found.values.tolist(), strict=True)), run)[0].mean(axis=1)
    return way


def _is_told(found: Fit, parameter: Parameter) -> bool:
    """Return whether the data determine a parameter.

    The interval must be within the bounds and exclude 0, and the value must exceed the tolerance of the parameter.
    """
    low, high = found.estimates[parameter.name].low, found.estimates[parameter.name].high
    is_inside = parameter.lower < low and high < parameter.upper
    return is_inside and not low <= 0.0 <= high and abs(found[parameter.name]) > _TOLERANCES[parameter.name]


def _steps(runs: Sequence[Run]) -> bool:
    """Return whether any run has a voltage step above 0.5 V.

    A log of slow ramps alone does not separate the mass from kS.
    """
    return any(float(np.abs(np.diff(run.volts.mean(axis=1))).max()) > 0.5 for run in runs)


def predictions_of(
    runs: Sequence[Run],
    fitted: Callable[[Sequence[Run]], Callable[[Run], FloatArray]],
) -> list[Prediction]:
    """Predict each run by cross-validation, in up to 5 folds, or predict the last third of a single run.

    Args:
        runs: All runs of the fit.
        fitted: Function that fits a model to runs. The function returns a function that predicts the distance or angle
            in a run, shape (n,).
    """
    if len(runs) == 1:
        run, at = runs[0], 2 * len(runs[0].times) // 3
        way = fitted([run.rows(0, at)])(run)
        return [Prediction(run, way, at)]
    folds = min(_FOLDS, len(runs))
    found: dict[int, Prediction] = {}
    for fold in range(folds):
        out = [k for k in range(len(runs)) if k % folds == fold]
        predicted = fitted([run for k, run in enumerate(runs) if k not in out])
        found |= {k: Prediction(runs[k], predicted(runs[k])) for k in out}
    return [found[k] for k in range(len(runs))]


def _result(
    config: DriveConfig, best: DriveConfig, raw: Mapping[str, Estimate], share: float,
    predictions: Sequence[Prediction], *, has_mass: bool, has_ground: bool,
) -> DriveFit:  # fmt: skip
    efficiency = config.modules[0].drive_efficiency if isinstance(config, SwerveConfig) else config.efficiency
    found: dict[str, Estimate] = {"ks": raw["ks"]}
    unknown = []
    if has_mass:
        found["mass"] = raw["mass"].mapped(lambda x: config.mass * math.exp(x))
    else:
        unknown.append(
            f"mass: the voltage only ramps, and on a ramp a heavier robot looks like one with more kS ({config.mass:g} "
            "kg is assumed); log a step of 4 V or more"
        )
    if "sides" in raw:
        found["left_efficiency"] = raw["sides"].mapped(lambda x: min(1.0, efficiency * math.exp(-0.5 * x)))
        found["right_efficiency"] = raw["sides"].mapped(lambda x: min(1.0, efficiency * math.exp(0.5 * x)))
    if "speed" in raw:
        found["free_speed_share"] = raw["speed"].mapped(lambda x: share * math.exp(x))
    if has_ground:
        found["wheel_radius"] = raw["radius"].mapped(lambda x: config.wheel_radius * math.exp(x))
    else:
        unknown.append(
            "wheel radius: the distance is measured by the wheels themselves; log the distance over ground as well"
        )
    if "lag" in raw:
        found["lag"] = raw["lag"]
    unknown.append("grip of the treads: a slipping wheel keeps turning, and its encoder with it")
    unknown.append(
        "efficiency of the gears: it acts like mass; the log tells "
        + (
            f"only mass / efficiency, {found['mass'].value / efficiency:.3g} kg; weigh the robot"
            if has_mass
            else "neither"
        )
    )
    return DriveFit(found, best, predictions, unknown)


def fit_battery(runs: Sequence[Run]) -> Estimate | None:
    """Fit the resistance of battery and cables [ohm] to the logged voltages and currents of the battery.

    Return None if no run has both a voltage and a current that varies by more than 5 A.
    """
    pairs = [(run.bus, run.amps) for run in runs if run.bus is not None and run.amps is not None]
    with_both = [(bus, amps) for bus, amps in pairs if np.ptp(amps) > 5.0]
    if not with_both:
        return None

    def errors(x: FloatArray) -> list[FloatArray]:
        return [x[1 + k] - x[0] * amps - bus for k, (bus, amps) in enumerate(with_both)]

    volts = [Parameter(f"volts {k}", 12.0, 5.0, 15.0, 0.5) for k in range(len(with_both))]
    return fit(errors, [Parameter("resistance", 0.02, 0.0, 1.0, 0.01), *volts]).estimates["resistance"]

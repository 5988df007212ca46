"""Fit of the friction, the inertia or mass, and the weight of flywheels, rollers, arms and elevators to logs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np

from simcore.calibrate.drive_fit import Prediction, increments, predictions_of
from simcore.calibrate.fitting import Estimate, Fit, Parameter, fit
from simcore.calibrate.runs import Run
from simcore.robot.gearbox import friction_from_volts
from simcore.robot.mechanisms import ArmConfig, ElevatorConfig, FlywheelConfig, RollerConfig
from simcore.robot.robot_config import build_mechanism
from simcore.typing import FloatArray
from simcore.units import GRAVITY

__all__ = ["FittedMechanism", "MechanismFit", "fit_mechanism"]

FittedMechanism: TypeAlias = FlywheelConfig | RollerConfig | ArmConfig | ElevatorConfig
_BUS = 12.5  # [V], minimum bus voltage of the model
_WINDOW = 0.06  # [s], window over which angles are compared
_CREEPS = 0.05  # fraction of the top speed; slower data are ignored


@dataclass(frozen=True, slots=True, eq=False)
class MechanismFit:
    """Fitted parameters of a mechanism, predictions of held-out runs, and properties that remain unknown."""

    estimates: Mapping[str, Estimate]
    """Estimates by name: `friction_volts` [V]; `inertia` [kg m^2], except for an elevator; `mass` [kg] of an elevator,
    or of an arm with a known center of mass; `weight_torque` [N m] of another arm; `lag` [s] if significant."""
    predictions: Sequence[Prediction]
    unknown: Sequence[str]
    """Text for the user about each property that the data do not determine."""


def turned(config: FittedMechanism, run: Run, values: Mapping[str, float]) -> FloatArray:
    """Simulate a mechanism with new parameter values and the motor voltages of a run, and return the motion.

    Args:
        config: Mechanism to simulate.
        run: Run with sample times, voltages and start angle.
        values: `friction_volts` [V], `inertia` (logarithm of the factor on inertia or mass), and `weight_torque` [N m]
            for an arm.

    Returns:
        Angle from the start of the run [rad], shape (n,).
    """
    box = replace(config.gearbox, friction_torque=friction_from_volts(config.gearbox, values["friction_volts"]))
    factor = math.exp(values["inertia"])
    varied: FittedMechanism
    if isinstance(config, ElevatorConfig):
        varied = replace(config, gearbox=box, carriage_mass=config.carriage_mass * factor)
    else:
        varied = replace(config, gearbox=box, inertia=config.inertia * factor)
    shaft = build_mechanism(varied)
    if isinstance(config, ArmConfig):
        shaft.record["model"]["weight_torque"] = values["weight_torque"]
    top = max(_BUS, float(np.abs(run.volts).max()))
    shaft.reset(run.origin)
    angles = np.empty(len(run.times))
    for k, volts in enumerate(run.volts.mean(axis=1).tolist()):
        angles[k] = shaft.position
        shaft.set_volts(volts)
        if k + 1 < len(run.times):
            shaft.step(float(run.times[k + 1] - run.times[k]), top)
    moved: FloatArray = angles - angles[0]
    return moved


def fit_mechanism(config: FittedMechanism, runs: Sequence[Run]) -> MechanismFit:
    """Fit the parameters of a mechanism to runs, and predict each run by a fit to other runs.

    If there is only one run, a fit to the first two thirds predicts the last third.
    """
    start = config.gearbox.holding_volts(config.gearbox.friction_torque)
    parameters = [
        Parameter("friction_volts", max(start, 0.05), 0.0, 6.0, 0.1),
        Parameter("inertia", 0.0, -4.0, 4.0, 0.3),
    ]
    if isinstance(config, ArmConfig):
        torque = max(config.weight_torque, 0.05 * config.gearbox.stall_torque(_BUS))
        parameters.append(Parameter("weight_torque", torque, -20.0 * torque, 20.0 * torque, 0.3 * torque))
    lag = Parameter("lag", 0.0, -0.05, 0.1, 0.01)

    def simulated(values: Mapping[str, float], run: Run) -> FloatArray:
        way: FloatArray = np.interp(run.times - values.get("lag", 0.0), run.times, turned(config, run, values))
        return way

    def errors(run: Run, values: Mapping[str, float]) -> FloatArray:
        real = increments(run, run.way, _WINDOW)[:, 0]
        off = increments(run, simulated(values, run), _WINDOW)[:, 0] - real
        kept: FloatArray = off[np.abs(real) > _CREEPS * np.abs(real).max()]
        return kept

    def fitted(wanted: Sequence[Parameter], some: Sequence[Run], begin: Fit | None = None) -> Fit:
        names = [p.name for p in wanted]
        return fit(
            lambda x: [errors(run, dict(zip(names, x.tolist(), strict=True))) for run in some], wanted,
            values=None if begin is None else [begin[name] for name in names],
        )  # fmt: skip

    rich = fitted([*parameters, lag], runs)
    late = rich.estimates["lag"]
    wanted = [*parameters, *([lag] if abs(late.value) > 0.012 and not late.low <= 0.0 <= late.high else [])]
    best = rich if len(wanted) == len(rich.names) else fitted(wanted, runs, rich)

    def predictor(some: Sequence[Run]) -> partial[FloatArray]:
        found = fitted(wanted, some, best)
        return partial(simulated, dict(zip(found.names, found.values.tolist(), strict=True)))

    found = dict(best.estimates)
    factor = found.pop("inertia")
    if isinstance(config, ElevatorConfig):
        found["mass"] = factor.mapped(lambda x: config.carriage_mass * math.exp(x))
    else:
        found["inertia"] = factor.mapped(lambda x: config.inertia * math.exp(x))
    unknown = ["gearing and type of the motor: they are assumed to be as described"]
    if isinstance(config, ArmConfig) and (lever := GRAVITY * config.center_of_mass * (1.0 - config.spring_share)):
        found["mass"] = found.pop("weight_torque").mapped(lambda x: x / lever)
        unknown.append("an arm's mass and center of mass separately: the motor only feels their product")
    return MechanismFit(found, predictions_of(runs, predictor), unknown)

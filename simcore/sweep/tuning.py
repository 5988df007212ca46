"""Tuning: the values of factors with which a metric is least or most, found by Optuna on common seeds.

A study lives in a storage that many machines can share. Each trial draws by its own number, so that one worker finds
the same whether it is interrupted or not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from simcore.errors import ConfigError, OutputError, VendorError
from simcore.install_text import install_command
from simcore.quantities import Quantity, require
from simcore.sweep.api import sweep
from simcore.sweep.column_expressions import evaluate, names_in
from simcore.sweep.experiment import Experiment
from simcore.sweep.factors import Factor, FactorValue
from simcore.sweep.one_run import require_playable_runs
from simcore.sweep.run_metrics import METRICS

if TYPE_CHECKING:
    from optuna.study import Study
    from optuna.trial import Trial

__all__ = ["TunedTrial", "Tuning", "TuningResult", "tune"]

_TRIALS = Quantity("", 1, 1_000_000, is_whole=True)
_SETUP = "simcore"
"""Attribute of a study: the key of what it tunes."""
_AS_IT_IS = "as it is"
"""Attribute of a study: the value without any change."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tuning:
    """What is tuned: the runs, what may change in them, and what is to be least or most.

    Args:
        experiment: The runs: its seeds are played in every trial; without factors.
        factors: What may change, each between the ends of a `uniform` distribution, or one of listed values.
        metric: A metric or an expression of metrics, e.g. `shots - hits`; its mean over the seeds counts.
        direction: Whether it is to be least or most.
        sampler_seed: Of the draws.
    """

    experiment: Experiment
    factors: tuple[Factor, ...]
    metric: str
    direction: Literal["minimize", "maximize"] = "minimize"
    sampler_seed: int = 0

    def __post_init__(self) -> None:
        if self.experiment.factors:
            raise ConfigError("Tuning: give the factors to the tuning, not to its experiment")
        if not self.factors:
            raise ConfigError("Tuning: nothing to tune; give factors, e.g. shooter.exit_efficiency=uniform(0.3,0.5)")
        for factor in self.factors:
            if factor.distribution is not None and factor.distribution.kind != "uniform":
                raise ConfigError(
                    f"Tuning: factor {factor.name} needs ends, uniform(low,high), or a list; got {factor.distribution}"
                )
        if self.direction not in ("minimize", "maximize"):
            raise ConfigError(f"Tuning: direction must be 'minimize' or 'maximize', got {self.direction!r}")
        require("Tuning", "sampler_seed", self.sampler_seed, Quantity("", 0, 2**31, is_whole=True))

    @property
    def played(self) -> Experiment:
        """The runs of a trial, with the factors in the middle of what they may be."""
        middle = tuple(factor.at(0.5) for factor in self.factors)
        return replace(self.experiment, factors=self.factors, design="points", points=(middle,))

    @property
    def key(self) -> str:
        """Of all that a trial's value depends on, the code included."""
        return f"{self.played.key} {self.metric} {self.direction}"


@dataclass(frozen=True, slots=True)
class TunedTrial:
    """One trial of a study, this machine's or another's."""

    number: int
    values: dict[str, FactorValue]
    value: float
    """Mean of the metric over the seeds; NaN where the runs failed."""
    error: str = ""


@dataclass(frozen=True, slots=True)
class TuningResult:
    """What a study has come to."""

    tuning: Tuning
    trials: tuple[TunedTrial, ...]
    as_it_is: float
    """The metric with nothing changed."""

    @property
    def best(self) -> TunedTrial | None:
        """The trial with the best value, the first of equals; None: all have failed."""
        good = [trial for trial in self.trials if math.isfinite(trial.value)]
        sign = 1.0 if self.tuning.direction == "minimize" else -1.0
        return min(good, key=lambda trial: (sign * trial.value, trial.number), default=None)


def tune(
    tuning: Tuning,
    trials: int,
    *,
    storage: str | None = None,
    name: str = "tune",
    workers: int = 1,
    on_trial: Callable[[TunedTrial], object] = lambda trial: None,
) -> TuningResult:
    """Play trials until the study has so many, those of other machines and of earlier calls counted.

    Args:
        tuning: What is tuned.
        trials: Of the study in the end.
        storage: URL of a database, as SQLAlchemy wants it, e.g. `sqlite:///out/study.db`; None: in memory.
        name: Of the study in it.
        workers: Processes that play the seeds of a trial; 0: one for each core.
        on_trial: Called with each trial that was played here.

    Raises:
        SimcoreError: The runs cannot be, the metric is not there, or the storage cannot be used.
    """
    require("tune", "trials", trials, _TRIALS)
    require_playable_runs(tuning.played)
    for part in names_in(tuning.metric):
        if part not in METRICS and not part.startswith("breakdown.") and not tuning.experiment.metrics:
            raise ConfigError(f"no metric named {part!r} to {tuning.direction}; known: {', '.join(METRICS)}")
    study = _study(tuning, storage, name)
    if _AS_IT_IS not in study.user_attrs:
        study.set_user_attr(_AS_IT_IS, _mean(tuning, tuning.experiment, workers)[0])
    while _finished(study) < trials:
        on_trial(_play(tuning, study, workers))
    found = [_tuned(trial) for trial in study.get_trials(deepcopy=False) if trial.state.is_finished()]
    return TuningResult(tuning, tuple(found), float(study.user_attrs[_AS_IT_IS]))


def _play(tuning: Tuning, study: Study, workers: int) -> TunedTrial:
    """Ask for a trial, play its seeds, and tell what came of it."""
    from optuna.samplers import TPESampler
    from optuna.trial import TrialState

    trial = study.ask()
    # Each trial's draws come from its own number, so that a study goes on as if it had never been interrupted.
    rng = np.random.default_rng((tuning.sampler_seed, trial.number))
    study.sampler = TPESampler(seed=int(rng.integers(2**32)))
    try:
        values = {factor.name: _suggest(trial, factor) for factor in tuning.factors}
        point = tuple(values[factor.name] for factor in tuning.factors)
        value, error = _mean(tuning, replace(tuning.played, points=(point,)), workers)
    except BaseException:
        study.tell(trial, state=TrialState.FAIL)
        raise
    if error:
        trial.set_user_attr("error", error)
        study.tell(trial, state=TrialState.FAIL)
    else:
        study.tell(trial, value)
    return TunedTrial(trial.number, values, value, error)


def _suggest(trial: Trial, factor: Factor) -> FactorValue:
    if factor.distribution is None:
        chosen: FactorValue = trial.suggest_categorical(factor.name, list(factor.values))
        return chosen
    return float(trial.suggest_float(factor.name, factor.distribution.first, factor.distribution.second))


def _mean(tuning: Tuning, experiment: Experiment, workers: int) -> tuple[float, str]:
    """Mean of the metric over the seeds, or NaN and what has failed."""
    executor = "process" if workers == 1 else "joblib"
    table = sweep(experiment, executor=executor, workers=workers).table
    for error in table["error"]:
        if error:
            return math.nan, str(error)
    values = evaluate(table, tuning.metric).astype(float).to_numpy()
    if not np.isfinite(values).all():
        return math.nan, f"{tuning.metric} is no number in {int((~np.isfinite(values)).sum())} of {len(values)} runs"
    return float(values.mean()), ""


def _study(tuning: Tuning, storage: str | None, name: str) -> Study:
    try:
        import optuna
    except ImportError as error:
        raise VendorError(f"tuning needs Optuna: {install_command('sweep')}") from error
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    try:
        study = optuna.create_study(storage=storage, study_name=name, direction=tuning.direction, load_if_exists=True)
    except Exception as error:  # whatever the database behind SQLAlchemy raises
        text = " ".join(str(error).split())[:160]
        raise OutputError(
            f"the storage {storage!r} cannot be used ({text}); want a URL such as sqlite:///out/study.db"
        ) from error
    key = study.user_attrs.get(_SETUP)
    if key is None:
        study.set_user_attr(_SETUP, tuning.key)
    elif key != tuning.key:
        raise ConfigError(
            f"study {name!r} in {storage} is of other runs, another metric or another code, and its values cannot be "
            "compared; give another name or storage"
        )
    return study


def _finished(study: Study) -> int:
    return len([trial for trial in study.get_trials(deepcopy=False) if trial.state.is_finished()])


def _tuned(trial: Any) -> TunedTrial:
    value = math.nan if trial.value is None else float(trial.value)
    return TunedTrial(trial.number, dict(trial.params), value, str(trial.user_attrs.get("error", "")))

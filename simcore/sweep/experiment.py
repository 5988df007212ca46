"""Description of the runs of a sweep, in plain values, and the keys that identify the results of the runs."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from importlib.metadata import packages_distributions, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import numpy as np

from simcore.errors import ConfigError
from simcore.match.registry import find_game, game_point
from simcore.match.scatter import Scatter
from simcore.quantities import COUNT, DURATION, Quantity, require_fields
from simcore.sweep.code_version import code_version, files_digest, module_digest, project_digest
from simcore.sweep.factors import PROJECT, Factor, FactorValue
from simcore.sweep.run_metrics import metric_name, named_object
from simcore.world.engine_choice import ENGINES, engine_label

__all__ = ["Experiment", "PlannedRun", "programs_outside"]

_SEED = Quantity("", 0, 2**63 - 1, is_whole=True)
_MOST_RUNS = 10_000_000


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """Plan of one run of an experiment."""

    number: int
    """Number of the run in playing order, from 0."""
    point: int
    """Index of the combination of factor values in `Experiment.design_points`."""
    seed: int
    values: dict[str, FactorValue]
    """Factor values by name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """Set of runs, each with a scripted auto of a game or with a robot project.

    All fields are plain values, paths and names. `to_json` can therefore write an experiment as JSON, and any machine
    of a cluster can play the runs.

    Example:
        >>> experiment = Experiment(auto="left", factors=(Factor("robot.mass", (45.0, 60.0)),), seeds=range(3))
        >>> [(run.number, run.point, run.seed, run.values["robot.mass"]) for run in experiment.runs()][:3]
        [(0, 0, 0, 45.0), (1, 1, 0, 60.0), (2, 0, 1, 45.0)]
    """

    game: str | None = None
    """Name of an installed game, or `module:name` of any game; None for the project's game or the newest game."""
    auto: str | None = None
    """Name of an auto of the game, or of the project's auto chooser. None for the first auto of the game, or for the
    default of the chooser."""
    alliance: Literal["blue", "red"] = "blue"
    red: str = ""
    """Scripted players of the red alliance in a whole match, in the notation of `simcore.match.players.lineup.lineup`;
    the player `me` plays the auto."""
    blue: str = ""
    """Scripted players of the blue alliance, in the notation of `red`. If `red` and `blue` are empty and are not
    factors, a single robot plays the auto."""
    seconds: float | None = None
    """Simulated duration of a run [s]; None for the autonomous period, or for the whole match if the run has players
    (`red`, `blue`)."""
    options: tuple[str, ...] = ()
    """Names of the options of the game to switch on."""
    engine: str | None = None
    """Name of the physics engine; None for the engine that `engine_choice` selects."""
    robot: str | None = None
    """Robot config: `module:function` of a function that returns a `RobotConfig`, or the path of a `simcore.toml`; None
    for the game's robot."""
    project: str | None = None
    """Folder of a robot project; each run plays the project's code in a new process. None for scripted autos."""
    command: tuple[str, ...] = ()
    """Command that starts the project's robot program in any language; simcore steps the program over the bridge. Empty
    for a robot.py."""
    scatter: Scatter | None = None
    """Standard deviations of the random differences between seeds; None for no scatter, or for the scatter in the
    project's `simcore.toml`."""
    factors: tuple[Factor, ...] = ()
    samples: int = 0
    """Number of random combinations of factor values; 0 for every combination of the listed values."""
    seeds: tuple[int, ...] = (0,)
    """Seeds of the runs; every combination of factor values is played with every seed."""
    metrics: tuple[str, ...] = ()
    """Metrics to measure: names, or `module:function` of a function that computes a metric from the finished `Match`.
    Empty for all standard metrics and the game's breakdown."""
    timeout: float | None = None
    """Limit of the wall time of a run [s]; the sweep ends a longer run with an error. None for no limit."""

    def __post_init__(self) -> None:
        for name in ("robot", "project"):
            if isinstance(getattr(self, name), Path):
                object.__setattr__(self, name, str(getattr(self, name)))
        if isinstance(self.metrics, Sequence) and not isinstance(self.metrics, str):
            object.__setattr__(self, "metrics", tuple(metric_name(metric) for metric in self.metrics))
        require_fields(self, seconds=DURATION, timeout=DURATION, samples=COUNT, seeds=[_SEED])
        for name in ("options", "factors", "seeds", "command"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        if self.robot is not None and self.project is not None:
            raise ConfigError("Experiment: give a robot or a project; the project's own code describes its robot")
        if self.alliance != "blue" and (self.red or self.blue):
            raise ConfigError("Experiment: in a match red and blue say whose robots play, so leave alliance out")
        if self.project is not None and (self.red or self.blue):
            raise ConfigError("Experiment: who plays with a project's robot is set in its simcore.toml: match = '...'")
        if not self.seeds or len(set(self.seeds)) < len(self.seeds):
            raise ConfigError(f"Experiment: seeds must be different whole numbers, at least one, got {self.seeds}")
        names = [factor.name for factor in self.factors]
        if len(set(names)) < len(names):
            raise ConfigError(f"Experiment: factors must differ, got {names}")
        drawn = [factor.name for factor in self.factors if factor.distribution is not None]
        if drawn and not self.samples:
            raise ConfigError(f"Experiment: {', '.join(drawn)} is drawn from a distribution: say how many samples")
        if self.samples and not self.factors:
            raise ConfigError(f"Experiment: samples are drawn from factors, got {self.samples} samples and no factor")
        if self.count > _MOST_RUNS:
            raise ConfigError(f"Experiment: {self.count} runs are too many, at most {_MOST_RUNS} are")

    # --- the runs ---------------------------------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """Number of runs: combinations of factor values times seeds."""
        return (self.samples or math.prod(len(factor.values) for factor in self.factors)) * len(self.seeds)

    def design_points(self) -> list[tuple[FactorValue, ...]]:
        """Return the combinations of values, each with a value for every factor in the order of `factors`."""
        if not self.samples:
            return list(itertools.product(*(factor.values for factor in self.factors)))
        size = (self.samples, len(self.factors))
        shares = np.random.default_rng(0).uniform(1e-9, 1.0 - 1e-9, size).tolist()  # equal in every process
        return [tuple(factor.at(share) for factor, share in zip(self.factors, row, strict=True)) for row in shares]

    def runs(self) -> list[PlannedRun]:
        """Return all runs in playing order: the first seed at every point, then the second seed, and so on."""
        names = [factor.name for factor in self.factors]
        points = [dict(zip(names, point, strict=True)) for point in self.design_points()]
        rounds = enumerate(itertools.product(self.seeds, enumerate(points)))
        return [PlannedRun(number, point, seed, values) for number, (seed, (point, values)) in rounds]

    @property
    def common(self) -> Experiment:
        """Copy of the experiment without factors, without samples and with the single seed 0.

        The sweep sends the copy to the workers with each `PlannedRun`, which has the factor values and the seed.
        """
        return replace(self, factors=(), samples=0, seeds=(0,))

    # --- identity of results ----------------------------------------------------------------------------------------

    def run_keys(self, runs: list[PlannedRun]) -> list[str]:
        """Return a hash of everything that affects the result of each run, as a key of 20 hexadecimal digits."""
        apart: tuple[str, ...] = ("factors", "samples", "seeds", "timeout")
        if PROJECT in (factor.name for factor in self.factors):
            apart = (*apart, "project")
        common = {name: value for name, value in self.to_json().items() if name not in apart}
        common |= {"engine": engine_label(self.engine), "code": self._code()}
        base = _short_hash(common)
        return [_short_hash([base, run.seed, sorted(_known(run.values).items())], 20) for run in runs]

    def _code(self) -> dict[str, str]:
        """Return the digests and versions of all code and files that affect a result, by name."""
        found = {"simcore": code_version(), "game": module_digest(self._game_module())}
        engine = ENGINES.get(engine_label(self.engine), "")
        found |= {name: _version(name) for name in (engine, "numpy") if name}
        is_named = self.game is not None and ":" in self.game
        game = named_object(self.game or "", "game") if is_named else find_game(self.game, say=str)
        if game.field.mesh is not None:  # in a checkout, the mesh is outside the game's package
            found["mesh"] = files_digest([game.field.mesh], game.field.mesh.parent)
        for name in (*self.metrics, self.robot or ""):
            module, colon, _ = name.partition(":")
            if colon and not Path(name).exists():
                found[name] = module_digest(module)
        if self.robot and Path(self.robot).is_file():
            found["robot"] = files_digest([Path(self.robot)], Path(self.robot).parent)
        if self.project is not None and PROJECT not in (factor.name for factor in self.factors):
            found["project"] = project_digest(Path(self.project))
        return found

    def _game_module(self) -> str:
        if self.game is not None and ":" in self.game:
            return self.game.partition(":")[0]
        return game_point(find_game(self.game, say=str).name).module

    # --- as JSON ----------------------------------------------------------------------------------------------------

    def to_json(self) -> dict[str, Any]:
        """Return the experiment as a dictionary of types that JSON can represent, for `from_json`."""
        return {**asdict(self), "scatter": None if self.scatter is None else self.scatter.text}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Experiment:
        """Create an experiment from the result of `to_json`; lists in place of tuples are accepted."""
        values = dict(data)
        values["factors"] = tuple(Factor.from_json(factor) for factor in data["factors"])
        if data["scatter"] is not None:
            values["scatter"] = Scatter.parse(data["scatter"])
        return cls(**values)


def programs_outside(data: Mapping[str, Any], folder: Path) -> list[str]:
    """Return the paths of the programs outside a folder that an experiment would run.

    The function neither runs nor imports a program.

    Args:
        data: Description of the experiment from `to_json`.
        folder: Trusted folder, usually the current folder.
    """
    projects = [data["project"], *(v for f in data["factors"] if f["name"] == PROJECT for v in f["values"])]
    found = [Path(project, "robot.py").resolve() for project in projects if project is not None]
    found += [Path(shutil.which(word) or word).resolve() for word in data.get("command", ())[:1]]
    for name in (data["game"], data["robot"], *data["metrics"]):
        module = str(name).partition(":")[0].partition(".")[0]  # the package; finding a submodule would import it
        if name is not None and ":" in name and module.isidentifier() and (spec := find_spec(module)) is not None:
            found.append(Path(spec.origin or module).resolve())
    return [str(file) for file in dict.fromkeys(found) if folder.resolve() not in file.parents]


def _known(values: dict[str, FactorValue]) -> dict[str, FactorValue]:
    """Return the factor values with the digest of a project's files in place of the project's path."""
    return {name: project_digest(Path(str(v))) if name == PROJECT else v for name, v in values.items()}


@cache
def _version(module: str) -> str:
    """Return the names and versions of the installed packages that provide a module; empty if no package does."""
    names = packages_distributions().get(module, ())
    return ", ".join(f"{name} {version(name)}" for name in names)


def _short_hash(data: Any, digits: int = 16) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:digits]

"""A robot test that is run once for each of many seeds: `@pytest.mark.seeds(50)` and `sim.success(...)`.

Each run has a process of its own, as every robot test has, and its seed decides all of its scatter. The test passes if
enough runs were a success; what it leaves of a failure are the worst three runs.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from simcore.errors import ConfigError
from simcore.quantities import shown
from simcore.sweep.child_process import cores
from simcore.sweep.sweep_statistics import wilson_share

__all__ = [
    "RUN", "RunClaim", "SeededRun", "judge_runs", "judged_seeds", "play_seeds", "seeds_and_spreads", "seeds_of",
]  # fmt: skip

RUN = "run of one seed"
"""Name of the property in which a run's report carries what `SeededRun` reads."""
_WORST = 3  # runs of which log and page are left
_LISTED = 12  # seeds that a sentence lists


@dataclass(frozen=True, slots=True, kw_only=True)
class RunClaim:
    """What one call of `sim.success` has found."""

    what: str
    """In words; may be empty."""
    held: bool
    at_least: float
    """Share of the runs in which it should hold."""
    sure: bool
    """Whether the lower bound of the share is asked for, not the share itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeededRun:
    """What came of the test with one seed."""

    seed: int
    reports: Sequence[pytest.TestReport]
    claims: Sequence[RunClaim] = ()
    points: float = math.inf
    """Of the robot's own alliance."""
    summary: str = ""
    digest: str = ""
    is_refuted: bool = False
    """Whether an assertion of the test has failed: no success, and no error."""

    @classmethod
    def of(cls, seed: int, reports: Sequence[pytest.TestReport]) -> SeededRun:
        """From the reports of a run's phases."""
        said: dict[str, Any] = dict(
            next((value for r in reports for name, value in r.user_properties if name == RUN), {})  # type: ignore[call-overload]
        )
        claims = tuple(RunClaim(**claim) for claim in said.get("claims", ()))
        return cls(seed=seed, reports=reports, **{**said, "claims": claims})

    @property
    def is_error(self) -> bool:
        """Whether it has come to no end: an exception, a crash, or time ran out."""
        return not self.is_refuted and any(report.failed for report in self.reports)

    @property
    def is_skipped(self) -> bool:
        """Whether the test has skipped itself."""
        return any(report.skipped for report in self.reports)

    def claim(self, number: int) -> bool:
        """Whether its n-th claim held; a run that has not come to it has failed it."""
        return number < len(self.claims) and self.claims[number].held


def seeds_of(item: pytest.Item) -> tuple[int, ...]:
    """The seeds of a marked test, as many as `--seeds` leaves; none of a test without the mark.

    Raises:
        ConfigError: The mark makes no sense.
    """
    marker = item.get_closest_marker("seeds")
    if marker is None:
        return ()
    wanted = marker.args[0] if len(marker.args) == 1 else None
    if isinstance(wanted, int) and not isinstance(wanted, bool) and wanted > 0:
        seeds = tuple(range(wanted))
    elif isinstance(wanted, (list, tuple, range)) and wanted and all(type(s) is int and s >= 0 for s in wanted):
        seeds = tuple(dict.fromkeys(wanted))
    else:
        raise ConfigError(
            f"@pytest.mark.seeds wants how many, seeds(50), or which, seeds([3, 17]); got {shown(marker.args)}"
        )
    unknown = set(marker.kwargs) - {"scatter"}
    if unknown:
        raise ConfigError(f"@pytest.mark.seeds knows scatter='...' only, got {', '.join(sorted(unknown))}")
    most = item.config.getoption("seeds")
    return seeds if most is None else seeds[:most]


def seeds_and_spreads(item: pytest.Item, robot_file: Path) -> tuple[tuple[int, ...], list[str]]:
    """Seeds of a marked test, none where `--sim-seed` names one, and the option that turns scatter on.

    Raises:
        SimcoreError: The mark makes no sense, or simcore.toml cannot be read.
    """
    seeds = seeds_of(item)
    return () if item.config.getoption("sim_seed") is not None else seeds, _spreads(item, robot_file)


def _spreads(item: pytest.Item, robot_file: Path) -> list[str]:
    """The option that turns scatter on: as `--sim-scatter`, the mark or simcore.toml say, else all default spreads.

    Raises:
        SimcoreError: The mark's spreads cannot be, or simcore.toml cannot be read.
    """
    from simcore.match.scatter import Scatter
    from simcore.robot_file.reader import read_settings
    from simcore.robot_file.template import FILE_NAME

    marker = item.get_closest_marker("seeds")
    if item.config.getoption("sim_scatter") is not None or marker is None:
        return []  # which the child gets anyway
    text = marker.kwargs.get("scatter")
    if text is not None:
        Scatter.parse(str(text))
        return [f"--sim-scatter={text}"]
    settings = read_settings(robot_file.parent / FILE_NAME)
    return ["--sim-scatter=1"] if settings.scatter is None else []


def judged_seeds(
    item: pytest.Item, seeds: Sequence[int], play: Callable[[int], list[pytest.TestReport]], output: Path
) -> list[pytest.TestReport]:
    """Run a test once for each seed, and judge all runs together.

    Args:
        item: The test.
        seeds: All of them.
        play: Runs it with a seed, in a process of its own.
        output: Folder in which runs without success leave a folder each; of these the worst stay.

    Returns:
        The reports of the whole test.
    """
    return judge_runs(list(play_seeds(play, seeds, _workers(item.config))), item.nodeid, output)


def play_seeds(
    play: Callable[[int], list[pytest.TestReport]], seeds: Sequence[int], workers: int
) -> Iterator[SeededRun]:
    """Run the test once for each seed, several at a time; a first run that errs or skips is the only one.

    Args:
        play: Runs it with a seed, in a process of its own.
        seeds: All of them.
        workers: How many at a time.

    Returns:
        The runs, in the order of their seeds.
    """
    first = SeededRun.of(seeds[0], play(seeds[0]))
    yield first
    if first.is_error or first.is_skipped:
        return
    with ThreadPoolExecutor(max_workers=workers) as pool:
        yield from (SeededRun.of(s, reports) for s, reports in zip(seeds[1:], pool.map(play, seeds[1:]), strict=True))


def judge_runs(runs: Sequence[SeededRun], nodeid: str, output: Path) -> list[pytest.TestReport]:
    """The reports of the whole test, and of the files that runs have left those of the worst three.

    Args:
        runs: At least one.
        nodeid: Of the test.
        output: Folder with a folder for each seed that was no success.
    """
    broken = [run for run in runs if run.is_error or run.is_skipped]
    if broken:
        return _hand_on(broken, runs, output)
    calls = max(1, *(len(run.claims) for run in runs))
    sentences, failed = [], False
    lost: dict[int, SeededRun] = {}
    for number in range(calls):
        claim = next((run.claims[number] for run in runs if number < len(run.claims)), None)
        is_plain = claim is None
        held = [not run.is_refuted and (is_plain or run.claim(number)) for run in runs]
        lost |= {run.seed: run for run, success in zip(runs, held, strict=True) if not success}
        share = wilson_share(held.count(True), len(held))
        at_least, sure = (1.0, False) if claim is None else (claim.at_least, claim.sure)
        enough = (share.lower if sure else share.value) >= at_least
        failed = failed or not enough
        what = f": {claim.what}" if claim is not None and claim.what else ""
        sign = ">=" if enough else "<"
        sentences.append(f"{share.k} of {share.n} (lower bound {share.lower:.2f}) {sign} {at_least:g}{what}")
    worst = sorted(lost.values(), key=lambda run: (run.points, run.seed))[:_WORST] if failed else []
    for run in runs:
        if run not in worst:
            shutil.rmtree(output / f"seed_{run.seed}", ignore_errors=True)
    lines = [*sentences]
    if lost:
        seeds = sorted(lost)
        rest = f" and {len(seeds) - _LISTED} more" if len(seeds) > _LISTED else ""
        lines.append(f"without success: seed {', '.join(map(str, seeds[:_LISTED]))}{rest}")
    for run in worst:
        lines += ["", f"seed {run.seed}: {run.summary}", *_said(run)]
    if worst:
        lines += ["", f'alone: pytest "{nodeid}" --sim-seed={worst[0].seed}']
    return _reports_of(runs, "failed" if failed else "passed", "\n".join(lines))


def _hand_on(broken: Sequence[SeededRun], runs: Sequence[SeededRun], output: Path) -> list[pytest.TestReport]:
    """The reports of the first run that broke off, with its seed."""
    for run in runs:
        if run is not broken[0]:
            shutil.rmtree(output / f"seed_{run.seed}", ignore_errors=True)
    errors = [run for run in broken if run.is_error]
    if errors and len(runs) > 1:
        note = f"{len(errors)} of {len(runs)} runs ended with an error; this is seed {errors[0].seed}"
        for report in errors[0].reports:
            if report.failed:
                report.sections.append(("simcore", note))
    return list((errors or broken)[0].reports)


def _said(run: SeededRun) -> list[str]:
    """What its process has said: where its page is, and what failed."""
    left = [text for report in run.reports for name, text in report.sections if name == "simcore"]
    lines = [text.partition("\n")[0] for text in left]  # the rest is the summary again
    if run.is_refuted:
        failed = next(report for report in run.reports if report.failed)
        crash = getattr(failed.longrepr, "reprcrash", None)
        lines.insert(0, crash.message if crash is not None else str(failed.longrepr))
    return lines


def _reports_of(runs: Sequence[SeededRun], outcome: Any, text: str) -> list[pytest.TestReport]:
    """Of set-up, call and tear-down, as one test has them."""
    found = []
    first = {report.when: report for report in runs[0].reports}
    for when in ("setup", "call", "teardown"):
        report = first[when]  # type: ignore[index]
        if when == "call":
            report.outcome, report.longrepr = outcome, text if outcome == "failed" else None
            report.duration = math.fsum(r.duration for run in runs for r in run.reports if r.when == "call")
            report.sections = [] if outcome == "failed" else [("simcore", text)]
        report.user_properties = [("seeds", {str(run.seed): run.digest for run in runs})]
        found.append(report)
    return found


def _workers(config: pytest.Config) -> int:
    """How many runs at a time: as `--seed-workers` says, else one a core; one where xdist has shared the cores out."""
    asked: int | None = config.getoption("seed_workers")
    if asked is not None:
        return asked
    return 1 if hasattr(config, "workerinput") else cores()

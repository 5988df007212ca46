"""One run in a process of its own: for a run whose worker has died, so that it is known which one it was."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from simcore.errors import SimcoreError
from simcore.sweep.child_process import answer_task, ask_process, read_task
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.one_run import failed_row, play_run

__all__ = ["play_alone"]


def play_alone(experiment: Experiment, planned: PlannedRun) -> dict[str, Any]:
    """The row of a run that is played in a process of its own; if that dies, the row says how."""
    task = {"experiment": experiment.to_json(), "planned": asdict(planned)}
    try:
        row: dict[str, Any] = ask_process("simcore.sweep.lone_run", task, timeout=experiment.timeout)
    except SimcoreError as error:
        return failed_row(planned, str(error))
    return row


WARM = ()
"""Besides this module."""


def main() -> None:
    """Play the run that `sys.argv` names a file for."""
    task = read_task()
    answer_task(play_run(Experiment.from_json(task["experiment"]), PlannedRun(**task["planned"])))


if __name__ == "__main__":
    main()

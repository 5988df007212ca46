"""One run in a process of its own: for a run whose worker has died, so that it is known which one it was.

`python -m simcore.sweep.lone_run FILE` reads a task from a file of JSON, and writes its row to the file beside it.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from simcore.errors import SimcoreError
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.one_run import failed_row, play_run
from simcore.sweep.time_limit import GRACE

__all__ = ["ask_process", "play_alone"]

_LAST_WORDS = 300  # characters of what a dead process has said


def play_alone(experiment: Experiment, planned: PlannedRun) -> dict[str, Any]:
    """The row of a run that is played in a process of its own; if that dies, the row says how."""
    task = {"experiment": experiment.to_json(), "planned": asdict(planned)}
    try:
        return ask_process("simcore.sweep.lone_run", task, timeout=experiment.timeout)
    except SimcoreError as error:
        return failed_row(planned, str(error))


def ask_process(module: str, task: Any, *, timeout: float | None) -> Any:
    """Let a new Python process answer a question.

    Args:
        module: Which it runs, with a file as the argument: the task in JSON. It writes the answer, JSON too, to the
            file of the same name with `.out` behind it.
        task: For it.
        timeout: Wall time in which it should answer by itself [s]; `GRACE` later it is ended. None: no limit.

    Returns:
        The answer.

    Raises:
        SimcoreError: The process has ended without one; the text has its last words.
    """
    with tempfile.TemporaryDirectory(prefix="simcore-run-", ignore_cleanup_errors=True) as name:
        file, said = Path(name, "task"), Path(name, "said")
        file.write_text(json.dumps(task), encoding="utf-8")
        with said.open("wb") as stream:
            process = subprocess.Popen(
                [sys.executable, "-m", module, str(file)],
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(part for part in sys.path if part)},
            )
            try:
                code = process.wait(None if timeout is None else timeout + GRACE)
            except subprocess.TimeoutExpired:
                raise SimcoreError(f"took longer than {timeout:g} s of wall time, and its process was ended") from None
            finally:
                process.kill()
                process.wait()
        answer = Path(f"{file}.out")
        if answer.exists():
            return json.loads(answer.read_text(encoding="utf-8"))
        words = " ".join(said.read_text("utf-8", "replace")[-_LAST_WORDS:].split())
        raise SimcoreError(f"its process died ({_how(code)})" + (f"; its last words: {words}" if words else ""))


def _how(code: int) -> str:
    if code >= 0:
        return f"exit {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"


def answer_task(answer: Any) -> None:
    """Write the answer of `ask_process` in its process; a half-written one cannot be seen."""
    half = Path(f"{sys.argv[1]}.half")
    half.write_text(json.dumps(answer), encoding="utf-8")
    half.rename(f"{sys.argv[1]}.out")


def _main() -> None:
    task = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    answer_task(play_run(Experiment.from_json(task["experiment"]), PlannedRun(**task["planned"])))


if __name__ == "__main__":
    _main()

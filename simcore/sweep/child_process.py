"""A Python process for what may crash, hang, or wants one to itself, and its answer."""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import Any

from simcore.errors import SimcoreError
from simcore.sweep.time_limit import GRACE
from simcore.sweep.warm_process import CAN_FORK, PARENT, WarmParent

__all__ = ["answer_task", "ask_process", "cores", "end_with_parent", "read_task", "run_process"]

_START = 60.0  # [s]; all imports, on a busy machine
_LOOKS = 0.5  # [s] between two looks whether the parent lives
_LAST_WORDS = 300  # characters of what a dead process has said


def ask_process(module: str, task: Any, *, timeout: float | None, folder: Path | None = None) -> Any:
    """Let a new process answer.

    Args:
        module: Which it runs; it calls `read_task` and `answer_task`.
        task: For it, in types that JSON knows.
        timeout: Wall time in which it should answer [s], once it has started; it is ended some time later. None: no
            limit.
        folder: Where it runs; None: where this process does.

    Returns:
        The answer.

    Raises:
        SimcoreError: The process has ended without one; the text has its last words.
    """
    with tempfile.TemporaryDirectory(prefix="simcore-run-", ignore_cleanup_errors=True) as name:
        file, said = Path(name, "task"), Path(name, "said")
        file.write_text(json.dumps(task), encoding="utf-8")
        most = None if timeout is None else _START + timeout + GRACE
        code = run_process(module, str(file), said=said, timeout=most, folder=folder, PYTHONHASHSEED="0")
        if code is None:
            raise SimcoreError(f"took longer than {timeout:g} s of wall time, and its process was ended")
        answer = Path(f"{file}.out")
        if answer.exists():
            return json.loads(answer.read_text(encoding="utf-8"))
        words = " ".join(said.read_text("utf-8", "replace")[-_LAST_WORDS:].split())
        raise SimcoreError(f"its process died ({_how(code)})" + (f"; its last words: {words}" if words else ""))


def run_process(
    module: str, argument: str, *, said: Path, timeout: float | None, folder: Path | None, **environment: str
) -> int | None:
    """Run a module in a process of its own, which imports from where this one does; on Linux it begins warm.

    Args:
        module: Its `main` is called, `WARM` names what it will import.
        argument: For it.
        said: File for all that it says.
        timeout: Wall time after which it is ended [s]; None: no limit.
        folder: Where it runs; None: where this process does.
        environment: Variables that it has otherwise than this process.

    Returns:
        Its exit code; None: it was ended, for it took too long.
    """
    variables = {**os.environ, **environment, "PYTHONPATH": _python_path(), PARENT: str(os.getpid())}
    if CAN_FORK:
        where = Path.cwd() if folder is None else folder
        return _warm_parent(module, variables).run(
            [argument], said=said, timeout=timeout, folder=where, environment=variables
        )
    with said.open("wb") as stream:
        process = subprocess.Popen(
            [sys.executable, "-m", module, argument],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            env=variables,
        )
        try:
            return process.wait(timeout)
        except subprocess.TimeoutExpired:
            return None
        finally:
            process.kill()
            process.wait()


def _warm_parent(module: str, variables: dict[str, str]) -> WarmParent:
    """The one of a module in this process, which is started when it is first needed."""
    with _starting:
        owner, parent = _parents.get(module, (0, None))
        if parent is None or owner != os.getpid() or parent.has_ended:
            parent = WarmParent(module, variables)
            atexit.register(parent.close)
            _parents[module] = os.getpid(), parent
        return parent


_starting = threading.Lock()
_parents: dict[str, tuple[int, WarmParent]] = {}


def end_with_parent(parent: int) -> None:
    """End this process soon after the one that has started it, however and whenever that ends; not on Windows.

    Args:
        parent: Its process id, as it says itself: it may have ended by now.
    """
    never = threading.Event()

    def watch() -> None:
        while os.getppid() == parent:
            never.wait(_LOOKS)
        os._exit(1)

    if os.name == "posix":
        threading.Thread(target=watch, name="end with parent", daemon=True).start()


def read_task() -> Any:
    """What `ask_process` asks this process, which ends with the asker."""
    end_with_parent(int(os.environ[PARENT]))
    return json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))


def answer_task(answer: Any) -> None:
    """Answer `ask_process`; half an answer cannot be seen."""
    half = Path(f"{sys.argv[1]}.half")
    half.write_text(json.dumps(answer), encoding="utf-8")
    half.rename(f"{sys.argv[1]}.out")


def cores() -> int:
    """How many of this machine's this process may use: so many processes are worth starting."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _python_path() -> str:
    """What this process imports from, the folder that it was started in as well."""
    return os.pathsep.join(os.path.abspath(part) for part in sys.path)


def _how(code: int) -> str:
    if code >= 0:
        return f"exit {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"

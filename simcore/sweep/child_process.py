"""A Python process for what may crash, hang, or wants one to itself.

On Linux it is forked from one that has imported what robot code needs (`_PRELOADED`, by the fork server of
`multiprocessing`), so that it begins at once. macOS and Windows cannot fork what has loaded libraries: there each
process imports anew.
"""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

__all__ = ["cores", "death_text", "kill_processes", "run_process"]

_PRELOADED = "simcore.robotpy.preloaded"
_CONTEXT: Any = multiprocessing.get_context("forkserver" if sys.platform == "linux" else "spawn")
_FROM_START = {"PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""Environment that a process has from its first instruction: sets have one order, and libraries of linear algebra start
no threads, with which a process must not fork."""
_LAST_WORDS = 300  # characters of what a dead process has said

_lock = threading.Lock()  # two threads that ask for one process's end at once can lose its exit code
_running: set[Any] = set()


def run_process(function: str, *arguments: Any, said: Path, timeout: float | None, folder: Path) -> int | None:
    """Call a function in a process of its own, which has this one's environment and ends with it.

    Args:
        function: As `module:name`.
        arguments: For it.
        said: File for all that it says.
        timeout: Wall time after which it is ended [s]; None: no limit.
        folder: Where it runs; modules are found there first.

    Returns:
        Its exit code, less than 0 that of a signal; None: it was ended, for it took too long.
    """
    said.touch()
    with _lock:
        environment = dict(os.environ)
        task = (function, arguments, str(said), str(folder), environment)
        process = _CONTEXT.Process(target=_begin, args=task, daemon=True)
        if sys.platform == "linux":
            _CONTEXT.set_forkserver_preload([_PRELOADED])
        # Dask's workers are daemons, which may start no process; that of a run ends with them
        multiprocessing.current_process().daemon = False
        os.environ.update(_FROM_START, PYTHONPATH=os.pathsep.join(os.path.abspath(part) for part in sys.path))
        try:
            process.start()
        finally:
            os.environ.clear()
            os.environ.update(environment)
        _running.add(process)
    try:
        has_ended = bool(multiprocessing.connection.wait([process.sentinel], timeout))
    finally:
        with _lock:
            if process.is_alive():
                process.kill()
            process.join()
            _running.discard(process)
    return process.exitcode if has_ended else None


def kill_processes() -> None:
    """End all processes that `run_process` waits for in other threads."""
    with _lock:
        for process in _running:
            process.kill()


def death_text(code: int, said: Path) -> str:
    """How a process has died, with its last words.

    Args:
        code: Its exit code.
        said: File with all that it has said.
    """
    text = said.read_text("utf-8", "replace")
    at = text.rfind("Current thread ")  # of faulthandler's last dump, in which the place comes first
    words = " ".join((text[-_LAST_WORDS:] if at < 0 else text[at:][:_LAST_WORDS]).split())
    try:
        how = f"exit {code}" if code >= 0 else signal.Signals(-code).name
    except ValueError:
        how = f"signal {-code}"
    return f"its process died ({how})" + (f"; its last words: {words}" if words else "")


def cores() -> int:
    """How many of this machine's this process may use: so many processes are worth starting."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin(function: str, arguments: tuple[Any, ...], said: str, folder: str, environment: dict[str, str]) -> None:
    """Be the new process."""
    threading.Thread(target=_end_with_parent, name="end with parent", daemon=True).start()
    if hasattr(os, "setsid"):
        os.setsid()  # Ctrl-C is the parent's
    words = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for descriptor, target in ((0, os.open(os.devnull, os.O_RDONLY)), (1, words), (2, words)):
        os.dup2(target, descriptor)
    multiprocessing.current_process().daemon = False  # robot code may start processes
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.path.insert(0, folder)
    del sys.argv[1:]
    module, _, name = function.partition(":")
    sys.exit(getattr(import_module(module), name)(*arguments))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)

"""Processes that begin with their imports done: on Linux, where a parent imports once and forks for each task.

`python -m simcore.sweep.warm_process MODULE` imports a module and what its `WARM` names, has the loop of the physics
compiled, and nothing else: nothing is built, and no thread runs. Each line that it reads asks for one child, which
calls the `main` of the module; when a child ends, the parent writes its number and its exit code. macOS and Windows
cannot fork what has loaded libraries.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import subprocess
import sys
import threading
import traceback
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from simcore.errors import SimcoreError

__all__ = ["CAN_FORK", "PARENT", "WarmParent"]

CAN_FORK = sys.platform == "linux"
"""Whether processes can begin warm here."""
PARENT = "SIMCORE_PARENT_PROCESS"
"""Environment variable with the process id of who has started a process."""
_PATIENCE = 30.0  # [s] in which what was ended is gone
_CHUNK = 1 << 16


class WarmParent:
    """The parent of warm processes, as its asker sees it, with whom it ends; may be asked by several threads.

    Args:
        module: What the processes run.
        environment: Variables of the parent.
    """

    def __init__(self, module: str, environment: dict[str, str]) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            # libraries of linear algebra start threads when they are loaded, and what has threads must not fork
            env={**environment, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            text=True,
            start_new_session=True,  # Ctrl-C is its asker's
        )
        self._news = threading.Condition()
        self._asked = 0
        self._pids: dict[int, int] = {}
        self._codes: dict[int, int] = {}
        threading.Thread(target=self._listen, name="warm processes", daemon=True).start()

    def run(
        self, arguments: list[str], *, said: Path, timeout: float | None, folder: Path, environment: dict[str, str]
    ) -> int | None:
        """Run `main` of the module in a process of its own.

        Args:
            arguments: Its `sys.argv[1:]`.
            said: File for all that it says.
            timeout: Wall time after which it is ended [s]; None: no limit.
            folder: Where it runs.
            environment: All of its variables.

        Returns:
            Its exit code; None: it was ended, for it took too long.

        Raises:
            SimcoreError: The parent itself has ended.
        """
        said.touch()  # also of one that is ended before it says anything
        with self._news:
            self._asked += 1
            number = self._asked
            try:
                self._ask(number, arguments, str(said), str(folder), environment, [str(folder), *sys.path])
                self._news.wait_for(lambda: number in self._codes or self.has_ended, timeout)
            finally:
                ended = number in self._codes
                if not ended and not self.has_ended:
                    self._news.wait_for(lambda: number in self._pids or self.has_ended, _PATIENCE)
                if not ended and number in self._pids and not self.has_ended:
                    os.kill(self._pids[number], signal.SIGKILL)
                    self._news.wait_for(lambda: number in self._codes, _PATIENCE)
                code, _ = self._codes.pop(number, None), self._pids.pop(number, None)
            if self.has_ended and not ended:
                raise SimcoreError(f"the parent of this run's process has ended (exit {self._process.poll()})")
            return code if ended else None

    def _ask(self, *task: Any) -> None:
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(json.dumps(task) + "\n")
            self._process.stdin.flush()

    @property
    def has_ended(self) -> bool:
        """Whether it takes no more tasks."""
        return self._process.poll() is not None

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            kind, number, value = json.loads(line)
            with self._news:
                (self._pids if kind == "pid" else self._codes)[number] = value
                self._news.notify_all()
        self._process.wait()
        with self._news:
            self._news.notify_all()

    def close(self) -> None:
        """End it with all of its processes; may be called twice."""
        assert self._process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.wait(_PATIENCE)


# --- in the parent ------------------------------------------------------------------------------------------------


def _serve(module: str) -> None:
    """Fork for whoever asks, until nobody can any more."""
    answers, quiet = os.dup(1), os.open(os.devnull, os.O_RDWR)
    for descriptor in (1, 2):  # engines greet as they are imported
        os.dup2(quiet, descriptor)
    main = import_module(module)
    for name in main.WARM:
        with contextlib.suppress(ImportError):  # an extra that this project does without
            import_module(name)
    from simcore.physics.world import prepare_loop  # here: who asks for a process needs no physics

    prepare_loop()  # compiled or loaded once for all children
    is_single = len(os.listdir("/proc/self/task")) == 1  # WPILib of 2027 starts a thread as it is imported
    gc.collect()
    gc.freeze()  # children copy no page because something in it was counted
    news, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
    rest, children = b"", dict[int, int]()
    while True:
        ready, _, _ = select.select([0, news], [], [])
        if news in ready:
            os.read(news, _CHUNK)
            while children:
                pid, status = os.waitpid(-1, os.WNOHANG)
                if not pid:
                    break
                _tell(answers, "code", children.pop(pid), os.waitstatus_to_exitcode(status))
        if 0 in ready:
            data = os.read(0, _CHUNK)
            if not data:
                for pid in children:
                    os.kill(pid, signal.SIGKILL)
                return
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                number, *task = json.loads(line)
                pid = os.fork()
                if not pid:
                    os.close(answers)
                    _begin(main, is_single, *task)
                children[pid] = number
                _tell(answers, "pid", number, pid)


def _tell(answers: int, kind: str, number: int, value: int) -> None:
    os.write(answers, f"{json.dumps([kind, number, value])}\n".encode())


def _begin(
    main: Any,
    is_single: bool,
    arguments: list[str],
    said: str,
    folder: str,
    environment: dict[str, str],
    path: list[str],
) -> NoReturn:
    """Be the process that a task asks for: as a copy of the parent, or afresh where that had other threads."""
    code = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        words = os.open(said, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        for descriptor, target in ((0, os.open(os.devnull, os.O_RDONLY)), (1, words), (2, words)):
            os.dup2(target, descriptor)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        os.environ[PARENT] = str(os.getppid())
        if not is_single:
            os.execve(sys.executable, [sys.executable, "-m", main.__name__, *arguments], dict(os.environ))
        sys.path[:], sys.argv[:] = path, [str(main.__file__), *arguments]
        code = int(main.main() or 0)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    _serve(sys.argv[1])

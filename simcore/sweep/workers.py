"""Worker processes that play runs on this machine or on a Dask cluster, with bit-identical results.

Each process is a joblib loky pool with a single worker. The waiting thread can therefore identify a process that died,
and can end a process that takes too long. The process of a robot project plays only one run; other processes play
further runs. On a cluster, each Dask worker starts processes on the worker's machine. (`joblib.Parallel` with Dask
would wait forever for the task of a lost worker, because Dask does not call the callbacks of the backend.)
"""

from __future__ import annotations

import faulthandler
import logging
import multiprocessing
import os
import re
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, TimeoutError, wait
from contextlib import contextmanager, suppress
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

import joblib
from joblib.externals.loky import BrokenProcessPool, ProcessPoolExecutor

from simcore.errors import ConfigError, SimcoreError, VendorError
from simcore.install_text import install_command
from simcore.sweep.code_version import code_version
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.one_run import failed_row, play_run

__all__ = ["Crew", "play_all"]

_CONNECT = 10.0  # [s]; time limit for the connection to a scheduler with a worker
_LOOKS = 0.5  # [s]; time between two checks of the parent process
_IDLE = 60.0  # [s]; time after which an idle process ends
_LAST_WORDS = 300  # number of characters of a dead process's output in the error of the row
_FROM_START = {"PYTHONHASHSEED": "0", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Environment variables of a worker process.

The variables fix the iteration order of sets in robot code, and keep numpy from starting a thread per core.
"""

Row = dict[str, Any]


def play_all(
    experiment: Experiment, runs: Sequence[PlannedRun], *, workers: int | None = None, cluster: str | None = None
) -> Iterator[Row]:
    """Play runs, and yield the row of each run at the end of the run.

    Closing the iterator ends the processes.

    Args:
        experiment: Experiment of the runs.
        runs: Runs to start, in this order.
        workers: Number of processes on this machine; None for one process per core; 0 to play in this process. A run of
            a robot project always plays in a separate process.
        cluster: Address of a Dask scheduler, e.g. `tcp://10.0.0.5:8786`; the workers of the cluster play the runs. None
            to play on this machine.

    Raises:
        ConfigError: If the scheduler cannot be reached, or if a worker of the cluster has another version of simcore.
        VendorError: If Dask is not installed.
        SimcoreError: If the connection to the scheduler is lost during the sweep.
    """
    common = experiment.common
    if workers == 0 and cluster is None and experiment.project is None:
        yield from (play_run(common, planned) for planned in runs)
        return
    count = min(workers or joblib.cpu_count(), len(runs))
    rest, under_way = iter(runs), dict[Future[Row], PlannedRun]()
    with _dask(cluster) if cluster is not None else _threads(count) as (submit, width):
        while True:
            for planned in islice(rest, width - len(under_way)):
                under_way[submit(common, planned)] = planned
            if not under_way:
                return
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                planned = under_way.pop(future)
                try:
                    yield future.result()
                except CancelledError as error:
                    raise SimcoreError(
                        "the Dask scheduler is lost; runs that were stored are kept, and the same sweep goes on with "
                        "them"
                    ) from error
                except Exception as error:
                    yield failed_row(planned, f"its worker failed: {' '.join(str(error).split())}")


class Crew:
    """Pool of processes on this machine, one process for each simultaneous run.

    Args:
        is_quiet: Whether to hide the console output of runs. If a process then dies, the error in the row of the run
            quotes the last output of the process.
    """

    def __init__(self, *, is_quiet: bool = True) -> None:
        self._is_quiet = is_quiet
        self._lock = threading.Lock()
        self._outputs: dict[ProcessPoolExecutor, str] = {}  # file with the output of each process
        self._idle: list[ProcessPoolExecutor] = []
        self._is_closed = False

    def play(self, common: Experiment, planned: PlannedRun, log: Path | None = None) -> Row:
        """Play a run in a process of the pool, and return the row of the run.

        If the process dies, play the run once more in another process. If the run takes longer than the experiment's
        timeout, end the process and return a row with an error.

        Args:
            common: Experiment without factors and seeds, from `Experiment.common`.
            planned: Run to play.
            log: File for the telemetry of the run; None for no file.
        """
        for is_last in (False, True):
            process, can_go_on = self._take(), False
            try:
                process.submit(_prepare, common.project is not None).result()
                row: Row = process.submit(play_run, common, planned, log).result(common.timeout)
                can_go_on = common.project is None
                return row
            except TimeoutError:
                return failed_row(planned, f"took longer than {common.timeout:g} s of wall time, and was stopped")
            except BrokenProcessPool as error:
                if is_last or self._is_closed:
                    return failed_row(planned, self._death(process, error))
            finally:
                if can_go_on:
                    self._idle.append(process)
                else:
                    self._end(process)
        raise AssertionError

    def close(self) -> None:
        """End all processes, including busy ones."""
        self._is_closed = True
        for process in list(self._outputs):
            self._end(process)

    def _take(self) -> ProcessPoolExecutor:
        with self._lock:
            if self._is_closed:
                raise SimcoreError("the sweep is over")
            if self._idle:
                return self._idle.pop()
            output = ""
            if self._is_quiet:
                descriptor, output = tempfile.mkstemp(prefix="simcore-run-")
                os.close(descriptor)
            # loky starts the process with the first task
            process = ProcessPoolExecutor(
                1, timeout=_IDLE, initializer=_begin, initargs=(os.getpid(), output), env=_FROM_START
            )
            self._outputs[process] = output
            return process

    def _end(self, process: ProcessPoolExecutor) -> None:
        process.shutdown(wait=True, kill_workers=True)
        if output := self._outputs.pop(process, ""):
            with suppress(OSError):
                os.unlink(output)

    def _death(self, process: ProcessPoolExecutor, error: BaseException) -> str:
        """Return the error text for a process that died, with the exit code and the last output of the process."""
        found = re.search(r"exit codes of the workers are \{(.+?)\}", str(error))
        text = ""
        with suppress(OSError, KeyError):
            text = Path(self._outputs[process]).read_text("utf-8", "replace")
        at = text.rfind("Current thread ")  # start of faulthandler's last dump, which has the place
        words = " ".join((text[-_LAST_WORDS:] if at < 0 else text[at:][:_LAST_WORDS]).split())
        return f"its process died{f' ({found[1]})' if found else ''}" + (f"; its last output: {words}" if words else "")


# --- in the process of a run ----------------------------------------------------------------------------------------


def _begin(parent: int, output: str) -> None:
    """Prepare a worker process: ignore Ctrl-C, and redirect all output to the file `output` (empty for no redirection).

    On Linux and macOS, also start a thread that ends the process within 0.5 s of the end of the parent process.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    never = threading.Event()

    def watch() -> None:
        while os.getppid() == parent:
            never.wait(_LOOKS)
        os._exit(1)

    if os.name == "posix":
        threading.Thread(target=watch, name="end with parent", daemon=True).start()
    if output:
        words, nothing = os.open(output, os.O_WRONLY | os.O_APPEND), os.open(os.devnull, os.O_RDONLY)
        for descriptor, target in ((0, nothing), (1, words), (2, words)):
            os.dup2(target, descriptor)
    faulthandler.enable()


def _prepare(is_project: bool) -> None:
    """Import the modules that play runs, because the time limit of a run must not include imports."""
    import_module("simcore.robotcode.sim.project_run" if is_project else "simcore.match.runner")


# --- sources of processes -------------------------------------------------------------------------------------------

Submit = Callable[[Experiment, PlannedRun], "Future[Row]"]


@contextmanager
def _threads(count: int) -> Iterator[tuple[Submit, int]]:
    crew = Crew()
    with ThreadPoolExecutor(max(1, count)) as pool:
        try:
            yield lambda common, planned: pool.submit(crew.play, common, planned), count
        finally:
            crew.close()


_crew = Crew()
"""Pool of processes for the runs that a Dask worker plays in this process."""


def _play_on_cluster(common: Experiment, planned: PlannedRun, version: str) -> Row:
    if version != code_version():
        return failed_row(planned, f"a worker has simcore {code_version()}, the sweep was started with {version}")
    multiprocessing.current_process().daemon = False  # Dask's workers are daemons, which may start no process
    return _crew.play(common, planned)


@contextmanager
def _dask(address: str) -> Iterator[tuple[Submit, int]]:
    """Connect to a Dask scheduler, and yield a function that submits a run and the number of runs to submit at once.

    Raises:
        ConfigError: If no scheduler with a worker answers, or a worker has another version of simcore.
        VendorError: If Dask is not installed.
    """
    try:
        distributed = import_module("distributed")
    except ImportError as error:
        raise VendorError(f"a cluster needs Dask: {install_command('cluster')}") from error
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # lost connections are reported below
    try:
        client = distributed.Client(address, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:  # TimeoutError is an OSError
        raise _no_scheduler(address) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_CONNECT)
        except OSError as error:
            raise _no_scheduler(address) from error
        for worker, version in client.run(code_version).items():
            if version != code_version():
                raise ConfigError(
                    f"worker {worker} has simcore {version}, but the sweep is started with {code_version()}: install "
                    "the same on all machines"
                )
        pool = client.get_executor(pure=False)
        width = 2 * sum(client.nthreads().values())  # two runs per thread, so no worker has to wait for a run
        yield lambda common, planned: pool.submit(_play_on_cluster, common, planned, code_version()), width


def _no_scheduler(address: str) -> ConfigError:
    return ConfigError(
        f"no Dask scheduler with a worker answers at {address} within {_CONNECT:g} s; start one with `dask scheduler`, "
        "and workers with `dask worker ADDRESS --nthreads 1`"
    )

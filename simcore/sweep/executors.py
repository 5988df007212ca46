"""Who plays the runs: this process, all cores of this machine, or a cluster. All give the same rows to the bit.

Each is an `Executor` of the standard library: joblib's loky here, Dask's on a cluster, and threads where each run has a
process of its own anyway. (`joblib.Parallel` waits for ever for a run whose Dask worker has died.)
"""

from __future__ import annotations

import logging
import os
import re
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from importlib import import_module
from typing import Any

from joblib.externals.loky import BrokenProcessPool, ProcessPoolExecutor

from simcore.errors import ConfigError, SimcoreError, UnknownNameError, VendorError
from simcore.install_text import install_command
from simcore.quantities import Quantity, require
from simcore.sweep.child_process import cores, kill_processes
from simcore.sweep.code_version import code_version
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.one_run import be_worker, failed_row, play_run

__all__ = ["EXECUTORS", "play_all"]

EXECUTORS = ("process", "joblib", "dask")
"""This process; processes on this machine (loky); a Dask cluster, or a local one where no scheduler is named."""

_CONNECT = 10.0  # [s] in which a scheduler must answer and have a worker
_LOOKS = 0.5  # [s] between two looks whether the parent lives
_ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of a worker: numpy would start a thread a core in each of them. Dask's workers have the same."""
_WORKERS = Quantity("", -1, 100_000, is_whole=True)

Row = dict[str, Any]
Suspect = tuple[PlannedRun, BaseException]
"""A run that was under way as a worker died, and the error that says so."""
Pools = Callable[[int], AbstractContextManager[Executor]]
"""Opens an executor with so many workers."""


def play_all(
    experiment: Experiment,
    runs: Sequence[PlannedRun],
    *,
    executor: str = "joblib",
    workers: int = -1,
    scheduler: str | None = None,
) -> Iterator[Row]:
    """Play runs, and give each one's row as soon as it is there; closing the iterator ends the workers.

    Nobody knows which run has ended a worker: those that were under way are played again, each in a worker of its own.

    Args:
        experiment: Whose runs they are; what they do not share is left out of what goes to workers.
        runs: In the order in which they begin.
        executor: One of `EXECUTORS`.
        workers: Processes on this machine; 0 or -1: one for each core.
        scheduler: Address of a Dask scheduler, e.g. `tcp://10.0.0.5:8786`; None: with `dask`, a cluster of its own.

    Raises:
        ConfigError: The scheduler cannot be reached, or its workers have another simcore.
        UnknownNameError: There is no such executor.
        VendorError: Dask is not installed.
    """
    if executor not in EXECUTORS:
        raise UnknownNameError("executor", executor, EXECUTORS)
    require("sweep", "workers", workers, _WORKERS)
    return _play(experiment, list(runs), executor, workers if workers > 0 else cores(), scheduler)


def _play(
    experiment: Experiment, rest: list[PlannedRun], executor: str, count: int, scheduler: str | None
) -> Iterator[Row]:
    common = experiment.common
    if executor == "process":
        yield from (play_run(common, planned) for planned in rest)
        return
    with ExitStack() as stack:
        pools: Pools = _threads if experiment.project is not None else _loky
        if executor == "dask":
            client = stack.enter_context(_dask_client(count, scheduler))
            count = 2 * sum(client.nthreads().values())  # so that no worker waits for its next run
            pools = lambda width: nullcontext(client.get_executor(pure=False))  # noqa: E731
        while rest:
            count = min(count, len(rest))
            with pools(count) as pool:
                rest, suspects = yield from _play_in(pool, common, rest, count)
            for planned, _ in suspects:
                with pools(1) as pool:
                    _, died = yield from _play_in(pool, common, [planned], 1)
                for _, error in died:
                    yield failed_row(planned, f"its process died{_exit_codes(error)}")


def _play_in(
    pool: Executor, common: Experiment, runs: list[PlannedRun], count: int
) -> Generator[Row, None, tuple[list[PlannedRun], list[Suspect]]]:
    """Play runs until a worker dies; returns those that have not begun, and those that were under way."""
    rest, under_way = list(reversed(runs)), dict[Future[Row], PlannedRun]()
    suspects: list[Suspect] = []
    while True:
        while rest and len(under_way) < count and not suspects:
            planned = rest.pop()
            try:
                under_way[pool.submit(_play_on_worker, common, planned, code_version())] = planned
            except BrokenProcessPool as error:  # between two runs
                suspects.append((planned, error))
        if not under_way:
            return rest[::-1], suspects
        done, _ = wait(under_way, return_when=FIRST_COMPLETED)
        for future in done:
            planned = under_way.pop(future)
            try:
                yield future.result()
            except CancelledError as error:
                raise SimcoreError(
                    "the Dask scheduler is lost; runs that were stored are kept, and the same sweep goes on with them"
                ) from error
            except Exception as error:
                if not isinstance(error, BrokenProcessPool) and type(error).__name__ != "KilledWorker":
                    yield failed_row(planned, f"its worker failed: {' '.join(str(error).split())}")
                else:
                    suspects.append((planned, error))


def _play_on_worker(common: Experiment, planned: PlannedRun, version: str) -> Row:
    if version != code_version():
        return failed_row(planned, f"a worker has simcore {code_version()}, the sweep was started with {version}")
    if common.project is None:
        logging.getLogger("simcore").setLevel(logging.ERROR)  # what is only worth a warning would be said once a run
        be_worker()
    return play_run(common, planned)


def _exit_codes(error: BaseException) -> str:
    """Of what loky says of a worker that has died: `SIGKILL(-9)`."""
    found = re.search(r"exit codes of the workers are \{(.+?)\}", str(error))
    return f" ({found[1]})" if found else ""


# --- executors ----------------------------------------------------------------------------------------------------


@contextmanager
def _loky(count: int) -> Iterator[Executor]:
    pool = ProcessPoolExecutor(count, initializer=_start_worker, initargs=(os.getpid(),), env=_ONE_THREAD)
    try:
        yield pool
    finally:
        pool.shutdown(wait=True, kill_workers=True)


def _start_worker(parent: int) -> None:
    """Ctrl-C is the parent's affair; and end soon after it, however it ends (not on Windows)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    never = threading.Event()

    def watch() -> None:
        while os.getppid() == parent:
            never.wait(_LOOKS)
        os._exit(1)

    if os.name == "posix":
        threading.Thread(target=watch, name="end with parent", daemon=True).start()


@contextmanager
def _threads(count: int) -> Iterator[Executor]:
    with ThreadPoolExecutor(count) as pool:
        try:
            yield pool
        finally:
            kill_processes()


@contextmanager
def _dask_client(count: int, scheduler: str | None) -> Iterator[Any]:
    """Of a scheduler, or of a cluster on this machine.

    Raises:
        ConfigError: No scheduler answers, or its workers have another simcore.
        VendorError: Dask is not installed.
    """
    try:
        dask, distributed = (import_module(name) for name in ("dask", "distributed"))
    except ImportError as error:
        raise VendorError(f"a cluster needs Dask: {install_command('cluster')}") from error
    with ExitStack() as stack:
        address: Any = scheduler
        if scheduler is None:
            # a run that ends its worker is not worth three more workers
            stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": 0}))
            address = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    host="127.0.0.1",
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            )
        try:
            client = stack.enter_context(distributed.Client(address, timeout=_CONNECT, set_as_default=False))
            client.wait_for_workers(1, timeout=_CONNECT)
        except (OSError, ValueError) as error:  # a TimeoutError is one
            raise ConfigError(
                f"no Dask scheduler with a worker answers at {scheduler} within {_CONNECT:g} s; start one with "
                "`dask scheduler`, and workers with `dask worker ADDRESS --nthreads 1`"
            ) from error
        for worker, version in client.run(code_version).items():
            if version != code_version():
                raise ConfigError(
                    f"worker {worker} has simcore {version}, but the sweep is started with {code_version()}: install "
                    "the same on all machines"
                )
        yield client

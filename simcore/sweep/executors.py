"""Who plays the runs: this process, all cores of this machine, or a cluster. All give the same rows to the bit."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ThreadPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from importlib import import_module
from typing import Any, TypeAlias

from simcore.errors import ConfigError, SimcoreError, UnknownNameError, VendorError
from simcore.install_text import install_command
from simcore.quantities import Quantity, require
from simcore.sweep.child_process import cores, end_with_parent
from simcore.sweep.code_version import code_version
from simcore.sweep.experiment import Experiment, PlannedRun
from simcore.sweep.lone_run import play_alone
from simcore.sweep.one_run import failed_row, play_run
from simcore.sweep.time_limit import be_worker

__all__ = ["EXECUTORS", "play_all"]

EXECUTORS = ("process", "joblib", "dask")
"""This process; processes on this machine (loky); a Dask cluster, or a local one where no scheduler is named."""

Row: TypeAlias = "dict[str, Any]"
_ANSWER = 1.0  # [s] in which a scheduler says what it is
_CONNECT = 10.0  # [s] in which it must have a worker
_ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of a worker: numpy would start a thread a core in each of them. Dask's workers have the same."""
_WORKERS = Quantity("", -1, 100_000, is_whole=True)


def play_all(
    experiment: Experiment,
    runs: Sequence[PlannedRun],
    *,
    executor: str = "joblib",
    workers: int = -1,
    scheduler: str | None = None,
) -> Iterator[Row]:
    """Play runs, and give each one's row as soon as it is there; closing the iterator ends the workers.

    Args:
        experiment: Whose runs they are; what they do not share is left out of what goes to workers.
        runs: In the order in which they begin.
        executor: One of `EXECUTORS`.
        workers: Processes on this machine; 0 or -1: one for each core.
        scheduler: Address of a Dask scheduler, e.g. `tcp://10.0.0.5:8786`; None: with `dask`, a cluster of its own.

    Raises:
        ConfigError: The scheduler cannot be reached, or its workers have another simcore.
        UnknownNameError: There is no such executor.
        VendorError: joblib or Dask are not installed.
    """
    if executor not in EXECUTORS:
        raise UnknownNameError("executor", executor, EXECUTORS)
    require("sweep", "workers", workers, _WORKERS)
    common, count = experiment.common, workers if workers > 0 else cores()
    if executor == "process":
        return (play_run(common, planned) for planned in runs)
    if executor == "dask":
        return _play_on_dask(common, runs, count, scheduler)
    return _play_on_cores(common, runs, count)


# --- processes on this machine ------------------------------------------------------------------------------------


def _play_on_cores(common: Experiment, runs: Sequence[PlannedRun], count: int) -> Iterator[Row]:
    """As many processes as asked for, which start once.

    One that dies takes the pool with it, and nobody knows which run it was: those that were under way are played again,
    each in a process of its own, and the others go on in a new pool.
    """
    try:
        from joblib.externals.loky import ProcessPoolExecutor
    except ImportError as error:
        raise VendorError(f"many processes need joblib: {install_command('sweep')}") from error

    rest = list(reversed(runs))
    while rest:
        count = min(count, len(rest))
        pool = ProcessPoolExecutor(count, initializer=_start_worker, initargs=(os.getpid(),), env=_ONE_THREAD)
        suspects = yield from _play_in_pool(pool, common, rest, count)
        with ThreadPoolExecutor(count) as threads:
            for alone in as_completed([threads.submit(play_alone, common, planned) for planned in suspects]):
                yield alone.result()


def _play_in_pool(
    pool: Executor, common: Experiment, rest: list[PlannedRun], count: int
) -> Generator[Row, None, list[PlannedRun]]:
    """Play the last of `rest` first, and take it out; returns those that were under way as a worker died."""
    under_way: dict[Future[Row], PlannedRun] = {}
    suspects: list[PlannedRun] = []

    def begin() -> None:
        while rest and len(under_way) < count and not suspects:
            planned = rest.pop()
            try:
                under_way[pool.submit(play_run, common, planned)] = planned
            except BrokenProcessPool:  # between two runs
                suspects.append(planned)

    try:
        begin()
        while under_way:
            done, _ = wait(under_way, return_when=FIRST_COMPLETED)
            finished = [(future, under_way.pop(future)) for future in done]
            suspects += [planned for future, planned in finished if isinstance(future.exception(), BrokenProcessPool)]
            begin()  # before rows are worked on, so that no worker waits
            for future, planned in finished:
                if planned not in suspects:
                    yield _row_of(future, planned)
    finally:
        pool.shutdown(wait=True, kill_workers=True)  # type: ignore[call-arg]  # loky's own argument
    return suspects


def _row_of(future: Future[Row], planned: PlannedRun) -> Row:
    """What a worker has returned, or why it has not."""
    error = future.exception()
    return (
        future.result() if error is None else failed_row(planned, f"its worker failed: {' '.join(str(error).split())}")
    )


def _start_worker(parent: int) -> None:
    """Ctrl-C is the parent's affair, and what is only worth a warning would be said once a run."""
    end_with_parent(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("simcore").setLevel(logging.ERROR)
    be_worker()


# --- a cluster ----------------------------------------------------------------------------------------------------


def _play_on_dask(common: Experiment, runs: Sequence[PlannedRun], count: int, scheduler: str | None) -> Iterator[Row]:
    try:
        dask, distributed = (import_module(name) for name in ("dask", "distributed"))
    except ImportError as error:
        raise VendorError(f"a cluster needs Dask: {install_command('sweep')}") from error

    with ExitStack() as stack:
        if scheduler is None:
            # a run that ends its worker is not worth three more workers
            stack.enter_context(dask.config.set({"distributed.scheduler.allowed-failures": 0}))
            address: Any = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    host="127.0.0.1",
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
            )
        else:
            address = scheduler
        try:
            if scheduler is not None:
                with ThreadPoolExecutor(1) as thread:  # a notebook has an event loop in this one
                    thread.submit(asyncio.run, _require_answer(distributed, scheduler)).result()
            client = stack.enter_context(distributed.Client(address, timeout=_CONNECT, set_as_default=False))
            client.wait_for_workers(1, timeout=_CONNECT)
        except (OSError, ValueError) as error:  # a TimeoutError is one
            raise ConfigError(
                f"no Dask scheduler with a worker answers at {scheduler} within {_CONNECT:g} s; start one with "
                "`dask scheduler`, and workers with `dask worker ADDRESS --nthreads 1`"
            ) from error
        _require_same_code(client.run(code_version))
        yield from _play_on_client(client, distributed.as_completed, common, runs)


async def _require_answer(distributed: Any, address: str) -> None:
    """Fail where no scheduler listens: a client waits long for anything else, and takes its answers for lengths.

    Raises:
        OSError: No scheduler answers there.
        ValueError: It is no address.
    """
    arguments = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, connection_args=arguments) as server:
        try:
            told = await asyncio.wait_for(server.identity(), _ANSWER)
        except Exception as error:  # a reply of another protocol can raise anything, a MemoryError as well
            raise OSError(f"no scheduler: {error}") from error
    if told.get("type") != "Scheduler":
        raise OSError(f"a {told.get('type')}, no scheduler")


def _require_same_code(versions: dict[str, str]) -> None:
    for worker, version in versions.items():
        if version != code_version():
            raise ConfigError(
                f"worker {worker} has simcore {version}, but the sweep is started with {code_version()}: install the "
                "same on all machines"
            )


def _play_on_client(
    client: Any, as_completed: Callable[..., Any], common: Experiment, runs: Sequence[PlannedRun]
) -> Iterator[Row]:
    """Twice as many runs under way as there are workers, so that none of them waits for the next one."""
    rest = iter(runs)
    under_way: dict[str, PlannedRun] = {}

    def begin(planned: PlannedRun | None, *, alone: bool = False) -> Any:
        if planned is None:
            return None
        future = client.submit(_play_on_worker, common, planned, code_version(), alone=alone, pure=False)
        under_way[future.key] = planned
        return future

    width = max(4, 2 * sum(int(threads) for threads in client.nthreads().values()))
    first = [future for _ in range(width) if (future := begin(next(rest, None))) is not None]
    results = as_completed(first, loop=client.loop)
    suspects: set[int] = set()
    for future in results:
        if future.cancelled():
            raise SimcoreError(
                "the Dask scheduler is lost; runs that were stored are kept, and the same sweep goes on with them"
            )
        planned = under_way.pop(future.key)
        error = future.exception()
        is_suspect = type(error).__name__ == "KilledWorker" and planned.number not in suspects
        if is_suspect:  # or it was only waiting at a worker that another run has ended
            suspects.add(planned.number)
        following = begin(planned, alone=True) if is_suspect else begin(next(rest, None))
        if following is not None:
            results.add(following)
        if not is_suspect:
            yield _row_of(future, planned)
        future.release()


def _play_on_worker(common: Experiment, planned: PlannedRun, version: str, *, alone: bool) -> Row:
    logging.getLogger("simcore").setLevel(logging.ERROR)
    be_worker()
    if version != code_version():
        return failed_row(planned, f"a worker has simcore {code_version()}, the sweep was started with {version}")
    return play_alone(common, planned) if alone else play_run(common, planned)

"""Jobs run one after another, or on Dask distributed."""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import importlib
import logging
import os
import signal
import time
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

from .jobs import BadInput, Job
from .work import Row, alone, execute, unsuccessful, version

#: How often a task is tried again that failed for what is not in its files: memory, a disk. Dask itself runs anew what
#: a worker had that went away.
RETRIES = 2
#: Tasks under way for each thread, so that none waits, and fewest of all.
AHEAD, FEWEST = 4, 8
#: Seconds after which the threads are counted again: workers come and go.
RECOUNT = 5.0
#: Seconds in which a scheduler has to answer.
TIMEOUT = 10.0

#: Of the package `distributed`, which is optional.
Client = Any


def sequential(jobs: Sequence[Job]) -> Iterator[tuple[Job, Row]]:
    """Jobs one after another in this process."""
    for job in jobs:
        try:
            row = execute(job)
        except (OSError, MemoryError) as error:
            row = lost(job, error)
        yield job, row


def lost(job: Job, error: BaseException | None) -> Row:
    """The row of a job that could not be run; the next run tries it again."""
    words = f"{type(error).__name__}: {error}"
    return unsuccessful(job, "lost", words, []) | {"version": version()}


@contextlib.contextmanager
def connected(address: str | None, workers: int) -> Iterator[Client]:
    """A client of the scheduler at an address (or of a scheduler file), or of processes of this machine.

    :raises BadInput: where no scheduler answers
    """
    dask = importlib.import_module("distributed")
    for name in [each for each in logging.root.manager.loggerDict if each.startswith("distributed")]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what goes wrong is said in the rows, or at the end
    with contextlib.ExitStack() as stack:
        if address is None:
            os.environ.setdefault("RAYON_NUM_THREADS", "1")  # heeded by the processes that are started now
            quiet = {"dashboard_address": "127.0.0.1:0", "silence_logs": logging.CRITICAL, "memory_limit": 0}
            # Ctrl-C in a terminal goes to all processes; those that are started now pass it over, this one heeds it.
            before = signal.signal(signal.SIGINT, signal.SIG_IGN)
            try:
                cluster = dask.LocalCluster(n_workers=workers, threads_per_worker=1, processes=True, **quiet)
            finally:
                signal.signal(signal.SIGINT, before)
            stack.enter_context(cluster)
            yield stack.enter_context(dask.Client(cluster))
            return
        try:
            where = {"scheduler_file": address} if address.endswith(".json") else {"address": address}
            if address.endswith(".json") and not os.path.isfile(address):
                raise FileNotFoundError("there is no such file")
            client = stack.enter_context(dask.Client(timeout=TIMEOUT, **where))
        except (OSError, ValueError, TypeError, KeyError, asyncio.TimeoutError) as error:
            raise BadInput(f"no scheduler answers at `{address}`: {error}") from None
        yield client


def check_workers(client: Client) -> None:
    """Waits for a worker.

    :raises BadInput: where workers have another version of the program, or none
    """
    client.wait_for_workers(1)
    try:
        found = client.run(version)
    except Exception as error:  # whatever their installation raises
        raise BadInput(f"the workers cannot run elastogeo ({error}): install elastogeo {version()} there") from None
    for worker, theirs in sorted(found.items()):
        if theirs != version():
            raise BadInput(f"the worker {worker} has elastogeo {theirs}, here is {version()}: install the same")


def distributed(jobs: Sequence[Job], client: Client) -> Iterator[tuple[Job, Row]]:
    """Jobs as tasks, each yielded once as it is done."""
    waiting = iter(jobs)
    of_key: dict[Any, Job] = {}
    counted, room = time.monotonic(), _room(client)

    def more() -> list[Any]:
        futures = []
        for job in islice(waiting, max(0, room - len(of_key))):
            future = client.submit(alone, job, retries=RETRIES)
            of_key[future.key] = job
            futures.append(future)
        return futures

    done = importlib.import_module("distributed").as_completed(more(), with_results=True, raise_errors=False)
    for future, result in done:
        found: Row | None = result if isinstance(result, dict) else None
        error: Any = result[1] if isinstance(result, tuple) else result
        if isinstance(error, (concurrent.futures.CancelledError, asyncio.CancelledError)):
            raise ConnectionError("the scheduler went away")
        job = of_key.pop(future.key)
        if time.monotonic() - counted > RECOUNT:
            counted, room = time.monotonic(), _room(client)
        for each in more():
            done.add(each)
        yield job, lost(job, error) if found is None else found


def _room(client: Client) -> int:
    """How many tasks are to be under way."""
    threads: int = sum(client.ncores().values())
    return max(FEWEST, AHEAD * threads)

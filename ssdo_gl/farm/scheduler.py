"""Gives chunks of work to the workers of a Dask scheduler and takes their results in order."""

from __future__ import annotations

import logging
import os
import pickle
import re
import uuid
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from ssdo_gl import __version__
from ssdo_gl.farm.kept_maker import Maker, results

# How long a scheduler may take to answer, and its workers to come.
CONNECT_S, WORKERS_S = 10, 60
# Chunks for each worker: those that are at work and as many that wait, so that nobody idles
# while results travel. What has come early is held in memory until its turn.
CHUNKS_AHEAD = 3
# A chunk costs some milliseconds to hand out; a lost one is made anew whole.
MAX_CHUNK = 16
_LOCAL = re.compile(r"local(?::([1-9]\d{0,2}))?")
_REMOTE = re.compile(r"(tcp|tls|ws|wss|ucx)://\S+:\d+")


class FarmError(ValueError):
    """Work that workers cannot do: one line with the reason."""


def check_scheduler(address: str) -> None:
    """Raise FarmError unless `address` names a scheduler, and Dask is installed."""
    if not (_LOCAL.fullmatch(address) or _REMOTE.fullmatch(address)):
        raise FarmError(
            f"--scheduler {address!r}: expected local, local:N (workers) or tcp://HOST:PORT"
        )
    _library()


def mapped(
    scheduler: str, open_maker: Callable[[Any], Maker], task: object, items: Sequence[Any]
) -> Generator[Any, None, None]:
    """Yield the result of each item, in their order, as workers make them.

    Parameters
    ----------
    scheduler : str
        ``local``, ``local:N`` or the address of a Dask scheduler.
    open_maker : callable
        A function of a module: makes on each worker, once, what makes the results.
    task : object
        What `open_maker` is called with; pickled.
    items : sequence
        Pickled, in chunks.

    A chunk whose worker is lost is made by another one.

    Raises
    ------
    FarmError
        If there is no scheduler or no worker, or a chunk has taken several workers with it.
    Exception
        What a worker raises.
    """
    distributed = _library()
    with _connected(distributed, scheduler) as client:
        workers = max(len(client.nthreads()), 1)
        size = min(max(len(items) // (8 * workers), 1), MAX_CHUNK)
        # As a result of its own: a worker that comes later gets it from another worker, and
        # it is not lost with the worker that holds it.
        data = client.submit(bytes, pickle.dumps(task), pure=False)
        job = uuid.uuid4().hex
        running: deque[Any] = deque()
        for start in range(0, len(items), size):
            chunk = items[start : start + size]
            running.append(
                client.submit(results, job, __version__, open_maker, data, chunk, pure=False)
            )
            if len(running) >= CHUNKS_AHEAD * workers:
                yield from _result(distributed, running.popleft())
        while running:
            yield from _result(distributed, running.popleft())


def _result(distributed: ModuleType, future: Any) -> list[Any]:
    try:
        made: list[Any] = future.result()
    except distributed.KilledWorker as error:
        raise FarmError(f"a part of the work has ended several workers: {error}") from None
    except RuntimeError as error:
        raise FarmError(str(error)) from None
    return made


@contextmanager
def _connected(distributed: ModuleType, scheduler: str) -> Iterator[Any]:
    """Yield a client of the scheduler, with at least one worker; ends what it has begun."""
    local = _LOCAL.fullmatch(scheduler)
    if local is None:
        try:
            client = distributed.Client(scheduler, timeout=CONNECT_S)
        except (OSError, ValueError) as error:
            raise FarmError(f"{scheduler}: no scheduler answers: {error}") from None
        with client:
            try:
                client.wait_for_workers(1, timeout=WORKERS_S)
            except TimeoutError:
                raise FarmError(
                    f"{scheduler}: no worker within {WORKERS_S} s; start some:"
                    f" dask worker {scheduler} --nthreads 1"
                ) from None
            yield client
        return
    count = int(local[1] or max((os.cpu_count() or 2) // 2, 1))
    with (
        distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            dashboard_address=":0",
            memory_limit=None,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def _library() -> ModuleType:
    try:
        import distributed
    except ImportError:
        raise FarmError("--scheduler needs Dask: pip install 'ssdo_gl[farm]'") from None
    return distributed

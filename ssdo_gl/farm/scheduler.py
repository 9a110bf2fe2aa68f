"""Gives chunks of work to the workers of a Dask scheduler and takes their results in order."""

from __future__ import annotations

import logging
import os
import pickle
import platform
import re
import signal
import sys
import time
import uuid
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import resource_tracker
from types import ModuleType
from typing import Any

from ssdo_gl.farm import local_worker
from ssdo_gl.farm.kept_maker import Maker, idle, results
from ssdo_gl.gpu.context import DEVICE_INDEX
from ssdo_gl.gpu.egl_devices import gpu_numbers
from ssdo_gl.gpu.held_signals import held_signals
from ssdo_gl.user_error import UserError
from ssdo_gl.version import __version__

# How long a scheduler may take to answer, and its workers to come.
CONNECT_S, WORKERS_S = 10, 60
# Between two looks whether workers are at rest, and whether there are any.
SETTLE_SECONDS = 0.05
LOOK_S = 1.0
# How long all may be gone: under load one that was killed takes half a minute to come back.
ABSENT_S = 120
# Chunks for each worker: those that are at work and as many that wait, so that nobody idles
# while results travel. What has come early is held in memory until its turn.
CHUNKS_AHEAD = 3
# A chunk costs some milliseconds to hand out; a lost one is made anew whole.
MAX_CHUNK = 16
_GONE = "the scheduler answers no more"
_LOCAL = re.compile(r"local(?::([1-9]\d{0,2}))?")
_REMOTE = re.compile(r"(tcp|tls|wss?)://\S+:\d+")


class FarmError(UserError, ValueError):
    """Work that workers cannot do: one line with the reason."""


def check_scheduler(address: str) -> None:
    """Raise FarmError unless `address` names a scheduler, and Dask is installed."""
    if not (_LOCAL.fullmatch(address) or _REMOTE.fullmatch(address)):
        raise FarmError(
            f"--scheduler {address!r}: expected local, local:N (workers) or tcp://HOST:PORT"
        )
    _library()


def silence_library() -> None:
    """Let Dask log nothing: what goes wrong is said in one line, by who asked for it."""
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)


class FarmJob:
    """Work for makers of one kind; workers keep theirs open as long as it lasts.

    Parameters
    ----------
    open_maker : callable
        A function of a module: makes on each worker, once, what makes the results.
    task : object
        What `open_maker` is called with; pickled.
    """

    def __init__(
        self, client: Any, library: ModuleType, open_maker: Callable[[Any], Maker], task: object
    ) -> None:
        self._client = client
        self._library = library
        self._open_maker = open_maker
        self._task = self._sent(task)
        self._name = uuid.uuid4().hex

    def results(
        self,
        items: Sequence[Any],
        *,
        shared: object = None,
        chunk: int | None = None,
        lost: Callable[[Any], Any] | None = None,
    ) -> Generator[Any, None, None]:
        """Yield the result of each item, in their order, as workers make them.

        What a worker that is lost had at work is made by another one.

        Parameters
        ----------
        items : sequence
            Pickled, in chunks; read no further than workers can take.
        shared : object
            Sent to each worker once, and given to makers beside every item.
        chunk : int or None
            Items that a worker takes at a time; by default an eighth of its share.
        lost : callable or None
            Returns the result of an item that has ended several workers; None: that is an
            error.

        Raises
        ------
        FarmError
            If a part of the work has taken several workers with it, none has been there for
            two minutes, or the scheduler is gone.
        Exception
            What a worker raises.
        """
        workers = max(self._worker_count(), 1)
        size = chunk or min(max(len(items) // (8 * workers), 1), MAX_CHUNK)
        data = None if shared is None else self._sent(shared)
        running: deque[tuple[Sequence[Any], Any]] = deque()
        try:
            for start in range(0, len(items), size):
                part = items[start : start + size]
                running.append((part, self._submitted(part, data)))
                if len(running) >= CHUNKS_AHEAD * workers:
                    yield from self._made(*running.popleft(), data, lost)
            while running:
                yield from self._made(*running.popleft(), data, lost)
        finally:
            self._client.cancel([future for _, future in running])

    def _sent(self, content: object) -> Any:
        # As a result of its own: a worker that comes later gets it from another worker, and
        # it is not lost with the worker that holds it.
        return self._client.submit(bytes, pickle.dumps(content), pure=False)

    def _submitted(self, part: Sequence[Any], data: Any) -> Any:
        work = self._name, __version__, self._open_maker, self._task, part, data
        return self._client.submit(results, *work, pure=False)

    def _made(
        self, part: Sequence[Any], future: Any, data: Any, lost: Callable[[Any], Any] | None
    ) -> Iterator[Any]:
        try:
            made: list[Any] = self._awaited(future)
        except self._library.KilledWorker as error:
            if lost is None:
                raise FarmError(f"a part of the work has ended several workers: {error}") from None
            if len(part) == 1:
                made = [lost(part[0])]
            else:
                # One of them did; each has its chance alone.
                alone = [part[n : n + 1] for n in range(len(part))]
                made = [
                    result
                    for one in alone
                    for result in self._made(one, self._submitted(one, data), data, lost)
                ]
        except RuntimeError as error:
            raise FarmError(str(error)) from None
        yield from made

    def _awaited(self, future: Any) -> Any:
        """Return what workers make of a chunk; raise FarmError if none is there any more."""
        seen = time.monotonic()
        try:
            while not future.done():
                try:
                    self._library.wait([future], timeout=LOOK_S)
                except TimeoutError:
                    if self._worker_count():
                        seen = time.monotonic()
                    elif time.monotonic() - seen > ABSENT_S:
                        raise FarmError(f"no worker is left, for {ABSENT_S} s now") from None
            if future.status != "cancelled":
                return future.result()
        except CancelledError:
            pass
        raise FarmError(_GONE)

    def _worker_count(self) -> int:
        try:
            return len(self._client.nthreads())
        except OSError:
            raise FarmError(_GONE) from None


class Farm:
    """The workers of a scheduler."""

    def __init__(self, client: Any, library: ModuleType) -> None:
        self._client = client
        self._library = library

    def job(self, open_maker: Callable[[Any], Maker], task: object) -> FarmJob:
        """Return a job for these workers."""
        return FarmJob(self._client, self._library, open_maker, task)

    def machines(self) -> Counter[str]:
        """Return how many workers each machine has, by its name."""
        return Counter(self._client.run(platform.node).values())

    def settle(self) -> None:
        """Wait until no worker is at work for this process."""
        # What was cancelled may still run, and the scheduler does not say so. A worker that is
        # lost meanwhile never answers.
        submit = self._client.submit
        waiting = {a: submit(idle, workers=[a], pure=False) for a in self._client.nthreads()}
        while any(a in self._client.nthreads() and not f.done() for a, f in waiting.items()):
            time.sleep(SETTLE_SECONDS)
        self._client.cancel(list(waiting.values()))


def mapped(
    scheduler: str,
    open_maker: Callable[[Any], Maker],
    task: object,
    items: Sequence[Any],
    lost: Callable[[Any], Any] | None = None,
) -> Generator[Any, None, None]:
    """Yield the results of a job of its own (`connected`, `FarmJob.results`)."""
    with connected(scheduler) as farm:
        yield from farm.job(open_maker, task).results(items, lost=lost)


@contextmanager
def connected(scheduler: str) -> Iterator[Farm]:
    """Yield the workers of a scheduler, at least one; end those that were begun for it.

    Parameters
    ----------
    scheduler : str
        ``local``, ``local:N`` or the address of a Dask scheduler.

    Raises
    ------
    FarmError
        If there is no scheduler or no worker.
    """
    library = _library()
    with _clients(library, scheduler) as client:
        yield Farm(client, library)


@contextmanager
def _clients(distributed: ModuleType, scheduler: str) -> Iterator[Any]:
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
    import dask

    # After 15 s a cluster ends what restarts a worker; under load that takes longer.
    with (
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1 day"}),
        ExitStack() as stack,
    ):
        # One that is interrupted while it starts leaves its workers, and tracebacks of theirs.
        with held_signals(), _away_from_ctrl_c():
            cluster = _local_cluster(distributed, int(local[1] or 0))
            stack.callback(_end, cluster)
        yield stack.enter_context(distributed.Client(cluster))


def _end(cluster: Any) -> None:
    # Under load a worker may take longer to end than Dask waits. What the work has come to
    # counts all the same, and the worker ends with this process at the latest.
    with suppress(TimeoutError):
        cluster.close()


@contextmanager
def _away_from_ctrl_c() -> Iterator[None]:
    """Let processes that are begun here not hear Ctrl-C, from their first moment on."""
    if sys.platform == "win32":
        yield
        return
    # It unblocks signals where it is begun.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _local_cluster(distributed: ModuleType, count: int) -> Any:
    """Return a cluster of `count` processes, 0: one for each GPU or every two processors.

    GPUs go round among them, unless one is chosen already.
    """
    gpus = [] if DEVICE_INDEX in os.environ else gpu_numbers()
    count = count or len(gpus) or max((os.cpu_count() or 2) // 2, 1)
    here = {"host": "127.0.0.1", "dashboard": False}
    options = {**here, "nthreads": 1, "memory_limit": None, "silence_logs": logging.CRITICAL}
    workers = {}
    for number in range(count):
        own = {DEVICE_INDEX: str(gpus[number % len(gpus)])} if gpus else {}
        pinned = {**options, "env": own, "preload": [local_worker.__name__]}
        workers[number] = {"cls": distributed.Nanny, "options": pinned}
    scheduler = {
        "cls": distributed.Scheduler,
        "options": {**here, "port": 0, "dashboard_address": ":0"},
    }
    return distributed.SpecCluster(workers, scheduler, silence_logs=logging.CRITICAL)


def _library() -> ModuleType:
    try:
        import distributed
    except ImportError:
        raise FarmError("--scheduler needs Dask: pip install 'ssdo_gl[farm]'") from None
    return distributed

"""What runs on a worker: one thread that owns OpenGL, and one maker kept warm in it."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any, Protocol

from ssdo_gl.version import __version__


class Maker(Protocol):
    """Makes one result of each item; holds what is costly to make, such as a renderer."""

    def make(self, item: Any) -> Any:
        """Return the result of an item."""

    def close(self) -> None:
        """Free what is held."""


_kept: dict[str, Maker] = {}


@cache
def _thread() -> ThreadPoolExecutor:
    """Return the one thread that work is done in: a context belongs to a thread."""
    return ThreadPoolExecutor(1, thread_name_prefix="farm")


def results(
    job: str,
    version: str,
    open_maker: Callable[[Any], Maker],
    task: bytes,
    items: Sequence[Any],
    shared: bytes | None = None,
) -> list[Any]:
    """Return the results of `items`, in their order.

    Parameters
    ----------
    job : str
        Chunks of one job share a maker.
    version : str
        Of this package, where the job comes from.
    open_maker : callable
        Makes the maker of a task.
    task : bytes
        The pickled argument of `open_maker`.
    shared : bytes or None
        Pickled; makes each item a pair of it and the item.

    Raises
    ------
    RuntimeError
        If this worker has another version of the package: images would differ.
    """
    if version != __version__:
        raise RuntimeError(f"a worker has ssdo_gl {__version__}, this command is {version}")
    return _thread().submit(_results, job, open_maker, task, items, shared).result()


def idle() -> None:
    """Return when this worker has nothing more to do."""
    _thread().submit(int).result()


def _results(
    job: str,
    open_maker: Callable[[Any], Maker],
    task: bytes,
    items: Sequence[Any],
    shared: bytes | None,
) -> list[Any]:
    if job not in _kept:
        for name in list(_kept):
            _kept.pop(name).close()
        _kept[job] = open_maker(pickle.loads(task))
    if shared is not None:
        beside = pickle.loads(shared)
        items = [(beside, item) for item in items]
    return [_kept[job].make(item) for item in items]

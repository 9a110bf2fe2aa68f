"""The Pareto front of error against time, and how sure each membership is."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def pareto_front(times: ArrayLike, errors: ArrayLike) -> NDArray[np.int64]:
    """Return the indices of the settings that no other one beats, fastest first.

    A setting is beaten if another is at least as fast and at least as accurate and
    better in one of the two. Of exact ties the first stays. Settings with a time or
    error that is not finite are never members.

    Parameters
    ----------
    times, errors : array_like, shape (points,)
        Both >= 0, smaller is better.
    """
    time = np.asarray(times, dtype=np.float64)
    error = np.asarray(errors, dtype=np.float64)
    usable = np.flatnonzero(np.isfinite(time) & np.isfinite(error))
    # By time, then error, then position: a sweep keeps what improves on all before.
    order = usable[np.lexsort((usable, error[usable], time[usable]))]
    members: list[int] = []
    best = np.inf
    for index in order:
        if error[index] < best:
            members.append(int(index))
            best = error[index]
    return np.asarray(members, dtype=np.int64)


def membership(time_replicas: ArrayLike, error_replicas: ArrayLike) -> NDArray[np.float64]:
    """Return in which share of the replicas each setting is on the front.

    Parameters
    ----------
    time_replicas, error_replicas : array_like, shape (replicas, points)
        Joint bootstrap replicas: row r of both belongs to the same draw.

    Returns
    -------
    ndarray, shape (points,)
        In [0, 1].
    """
    time = np.asarray(time_replicas, dtype=np.float64)
    error = np.asarray(error_replicas, dtype=np.float64)
    hits = np.zeros(time.shape[1])
    for times, errors in zip(time, error, strict=True):
        hits[pareto_front(times, errors)] += 1.0
    return np.asarray(hits / max(len(time), 1))

"""Times what the renderer draws, by the clock that can be trusted on its device."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Literal, Self

from ssdo_gl.gpu.context import Device

TimerKind = Literal["gl_query", "finish_wall"]


class Timer:
    """A context manager that measures the OpenGL commands issued inside it.

    On a GPU it asks OpenGL (time queries). On a software rasterizer it waits for all
    earlier work, runs the block, waits again and reads the wall clock: there, time
    queries measure 0.14 to 0.39 of what a pass really takes, because the work is done
    by other threads after the query has closed.

    One timer measures one block at a time; it may be used again and again.

    Attributes
    ----------
    kind : str
        ``gl_query`` or ``finish_wall``: which clock the numbers come from.
    clock : callable
        Seconds, where work is waited for: the wall clock; ``time.process_time``, the
        processor time of all threads, does not count what other programs do meanwhile.
    """

    kind: TimerKind

    def __init__(self, device: Device) -> None:
        self._gl = device.gl
        self.kind = "finish_wall" if device.is_software else "gl_query"
        # Any: the stubs leave the context manager of a query untyped.
        self._query: Any = None if device.is_software else self._gl.query(time=True)
        self.clock: Callable[[], float] = time.perf_counter
        self._start = 0.0
        self._elapsed_s = 0.0

    def __enter__(self) -> Self:
        if self._query is not None:
            self._query.__enter__()
        else:
            self._gl.finish()
            self._start = self.clock()
        return self

    def __exit__(self, *fault: object) -> None:
        if self._query is not None:
            self._query.__exit__(*fault)
        else:
            self._gl.finish()
            self._elapsed_s = self.clock() - self._start

    @property
    def elapsed_ms(self) -> float:
        """Milliseconds of the last block; with ``gl_query`` this waits for its end."""
        return self._elapsed_s * 1e3 if self._query is None else float(self._query.elapsed) * 1e-6

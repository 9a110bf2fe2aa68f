"""Cuts full-screen draws into bands, each as long as a slice of time.

A draw cannot be interrupted, and one of many samples takes seconds on a software
rasterizer. Bands of it give the same bytes, and somebody may be answered in between.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from weakref import WeakKeyDictionary

import moderngl

from ssdo_gl.gpu.program import Program
from ssdo_gl.math3d import Region

# With a picture in motion after it, input is still answered within two frames of 60 Hz.
SLICE_MS = 8.0
# The first band of a program whose time nobody knows, in pixels.
FIRST_PIXELS = 16_384
# A band has at most this many times the rows of the one before: cost differs across a picture.
LARGEST_GROWTH = 2.0


class DrawBands:
    """How long programs take per pixel, as far as it was seen."""

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._pause: Callable[[], None] | None = None
        self._pixels: WeakKeyDictionary[Program, float] = WeakKeyDictionary()

    @contextmanager
    def pausing(self, pause: Callable[[], None]) -> Iterator[None]:
        """Cut all draws of the context into bands and call `pause` after each.

        It may draw other things, and raise to give the frame up.
        """
        self._pause = pause
        self._gl.extra = self
        try:
            yield
        finally:
            self._gl.extra = self._pause = None

    def cut(self, program: Program, region: Region) -> Iterator[Region]:
        """Yield bands of `region`, bottom up; the caller draws each with `program`."""
        x, y, width, height = region
        done = 0
        while done < height:
            pixels = self._pixels.get(program, FIRST_PIXELS)
            # Quads of 2x2 pixels are shaded together, for their derivatives.
            rows = min(max(2, int(pixels / width) // 2 * 2), height - done)
            start = time.perf_counter()
            yield x, y + done, width, rows
            # The work of a software renderer is done while one waits for it.
            self._gl.finish()
            milliseconds = (time.perf_counter() - start) * 1e3
            fitting = width * rows * SLICE_MS / max(milliseconds, 1e-3)
            self._pixels[program] = min(fitting, LARGEST_GROWTH * max(pixels, width * rows))
            done += rows
            if self._pause is not None:
                self._pause()


def bands(gl: moderngl.Context, program: Program, region: Region) -> Iterator[Region]:
    """Yield what to draw of `region` at a time: all of it, unless somebody asked for bands."""
    known: DrawBands | None = gl.extra
    if known is None:
        yield region
    else:
        yield from known.cut(program, region)

"""Sub-pixel offsets of the frames that an anti-aliased picture averages."""

from __future__ import annotations

from functools import lru_cache


def middle_index(count: int) -> int:
    """Return with which of `count` sub-pixel offsets to begin: one near the pixel's centre.

    Pictures and windows alike: where light is kept for all frames of a view, it is kept for
    what the first one shows.
    """
    return (count - 1) // 2


@lru_cache(maxsize=1024)
def jitter(index: int, count: int) -> tuple[float, float]:
    """Return the sub-pixel offset of frame `index` of `count`, in pixels.

    A rank-1 lattice of the golden ratio: each of `count` columns and, nearly, rows of
    the pixel is met once. Its mean is exactly the pixel centre, where a single frame
    samples; otherwise averaging frames would shift the picture.
    """
    golden = 0.6180339887498949
    y_of = [(golden * number) % 1.0 for number in range(count)]
    return (index + 0.5) / count - 0.5, y_of[index] - sum(y_of) / count

"""Sub-pixel offsets of the frames of an anti-aliased picture, and their average."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import linear_from_srgb, srgb_from_linear


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


class ImageAverage:
    """The mean of images of the same names and shapes.

    ``display`` is averaged as the light that a screen emits, not as its sRGB code:
    the mean of codes would draw edges too dark. Tone mapping comes before averaging, so
    that an edge against a blinding light is smooth, too. Where its alpha is below 1, each
    frame counts by its own. A single image passes unchanged.

    Attributes
    ----------
    is_interrupted : bool
        Whether frames are lacking because somebody would not wait for them.
    """

    def __init__(self) -> None:
        self.is_interrupted = False
        self._sums: dict[str, NDArray[np.float64]] = {}
        self._count = 0
        self._single: dict[str, NDArray[np.float32]] = {}

    def add(self, images: Mapping[str, NDArray[np.float32]]) -> None:
        """Take one more frame's images."""
        self._count += 1
        if self._count == 1:
            self._single = dict(images)
            return
        for frame in (self._single, images):
            for name, image in frame.items():
                light = image.astype(np.float64)
                if name == "display":
                    light[..., :3] = linear_from_srgb(light[..., :3]) * light[..., 3:]
                self._sums[name] = self._sums.get(name, 0.0) + light
        self._single = {}

    @contextmanager
    def ended_by_interrupt(self, references: Callable[[], object]) -> Iterator[None]:
        """Let an interrupt end the block once there is a frame; without `references`, never."""
        try:
            yield
        except KeyboardInterrupt:
            if not (self._count and references()):
                raise
            self.is_interrupted = True

    def images(self) -> dict[str, NDArray[np.float32]]:
        """Return the means so far."""
        if self._single:
            return self._single
        means = {name: total / self._count for name, total in self._sums.items()}
        if "display" in means:
            color, alpha = means["display"][..., :3], means["display"][..., 3:]
            straight = color / np.where(alpha > 0.0, alpha, 1.0)
            means["display"] = np.concatenate([srgb_from_linear(straight), alpha], axis=-1)
        return {name: mean.astype(np.float32) for name, mean in means.items()}

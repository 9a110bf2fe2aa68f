"""Pictures on their way to somebody who looks: how many, how well, and whether they arrive."""

from __future__ import annotations

import io
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from ssdo_gl.images.files import png_bytes
from ssdo_gl.window.live import Governor

# One on its way while the next is drawn; a third would only be older when it is seen.
MOST_IN_FLIGHT = 2
# From sent to acknowledged, beyond what the way itself takes: as long as motion may lag.
DELIVERY_MS = 80.0


@dataclass(frozen=True)
class PictureQuality:
    """How a picture in motion is packed.

    Attributes
    ----------
    jpeg : int
        JPEG's quality, 1 to 95.
    reduction : int
        Pixels of a side that become one.
    work : float
        Bytes relative to one another, roughly.
    """

    jpeg: int
    reduction: int
    work: float


# From good to small. Bytes were measured on pictures of the built-in scenes.
QUALITIES = (
    PictureQuality(90, 1, 100.0),
    PictureQuality(75, 1, 60.0),
    PictureQuality(50, 1, 40.0),
    PictureQuality(70, 2, 18.0),
    PictureQuality(45, 2, 11.0),
    PictureQuality(45, 4, 4.0),
)


@dataclass(frozen=True)
class SentPicture:
    """A picture as bytes.

    Attributes
    ----------
    number : int
        What `acknowledge` takes.
    mime : str
        ``image/jpeg``, or ``image/png`` where it is lossless.
    """

    number: int
    data: bytes
    mime: str

    @property
    def is_lossless(self) -> bool:
        """Whether its colours are exactly those of the picture."""
        return self.mime == "image/png"


def jpeg_bytes(pixels: NDArray[np.uint8], quality: PictureQuality) -> bytes:
    """Return `pixels`, shape (height, width, 3), as a JPEG file."""
    image = PillowImage.fromarray(pixels)
    if quality.reduction > 1:
        image = image.reduce(quality.reduction)
    stream = io.BytesIO()
    image.save(stream, "JPEG", quality=quality.jpeg)
    return stream.getvalue()


class Delivery:
    """Counts pictures in flight and chooses their quality by how long they take.

    Parameters
    ----------
    clock : callable
        Returns seconds.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._sent: deque[tuple[int, float, bool]] = deque()
        self._number = 0
        # The shortest way there and back: distance, which no quality makes shorter.
        self._way_s = float("inf")
        self._governor = Governor(DELIVERY_MS, [item.work for item in QUALITIES])
        self._governor.level = 1

    @property
    def has_room(self) -> bool:
        """Whether another picture may be sent."""
        return len(self._sent) < MOST_IN_FLIGHT

    @property
    def quality(self) -> PictureQuality:
        """Of the next picture in motion."""
        return QUALITIES[self._governor.level]

    def pack(
        self, pixels: NDArray[np.uint8], *, is_lossless: bool, is_resting: bool = False
    ) -> SentPicture:
        """Return a picture to be sent now; it is in flight until it is acknowledged.

        Parameters
        ----------
        is_resting : bool
            It is looked at, and the next one may take its time: good whatever the way is.
        """
        if is_lossless:
            data = png_bytes(pixels, compress_level=1)
        else:
            data = jpeg_bytes(pixels, QUALITIES[0] if is_resting else self.quality)
        self._number += 1
        self._sent.append((self._number, self._clock(), is_lossless or is_resting))
        return SentPicture(self._number, data, "image/png" if is_lossless else "image/jpeg")

    def acknowledge(self, number: int) -> None:
        """Note that a picture, and all before it, was shown: at the present time of the clock.

        Numbers of nothing that is under way are nothing.
        """
        if all(number != sent for sent, _, _ in self._sent):
            return
        while self._sent and self._sent[0][0] <= number:
            _, then, was_resting = self._sent.popleft()
            taken_s = self._clock() - then
            self._way_s = min(self._way_s, taken_s)
            if not was_resting:
                self._governor.observe(1000.0 * (taken_s - self._way_s))

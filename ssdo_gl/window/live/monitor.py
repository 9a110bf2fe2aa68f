"""Looks at what was drawn, now and then: values that are not finite, and the live error."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.images.display import ColorMapping
from ssdo_gl.images.error import failures, mean_level, relative_rmse
from ssdo_gl.window.live.live_image import LiveImage
from ssdo_gl.window.live.non_finite_watch import Alarm, NonFiniteWatch
from ssdo_gl.window.views import View

# A flight is looked at this often (frames); a picture at rest once it is refined.
LOOK_EVERY = 30


class Monitor:
    """Reads pictures back when there is time for it.

    Attributes
    ----------
    alarm : Alarm or None
        NaN or infinity in what was shown last.
    error : float or None
        RMSE over the mean of the left image against the right one while their difference
        is shown; None once either changes. The noise of samples to come is part of it.
    uncertainty : float or None
        How much of `error` may be that noise, by how it fell as samples came; None until
        it was measured twice.
    is_error_final : bool
        Whether both images hold all samples that were asked for.
    is_due : bool
        Whether the present picture was not looked at yet.
    """

    def __init__(self, device: Device, shaders: ShaderLibrary) -> None:
        self.alarm: Alarm | None = None
        self.error: float | None = None
        self.uncertainty: float | None = None
        self.is_error_final = False
        self.is_due = True
        self._before: tuple[float, float] | None = None
        self._shown: object = None
        self._samples = 0
        self._watch = NonFiniteWatch(device, shaders)
        self._frames = 0

    def look(
        self, images: Sequence[LiveImage], view: View, *, drew: bool, is_finished: bool
    ) -> None:
        """Look at `images` if it is time.

        Parameters
        ----------
        images : sequence of LiveImage
            Left and, where two are compared, right.
        drew : bool
            Whether they have changed since the last call.
        is_finished : bool
            Whether they will not change any more by themselves.
        """
        if drew:
            self.is_due = True
            self._frames += 1
        self._update_error(images, view, is_finished)
        if not self.is_due or not (is_finished or self._frames % LOOK_EVERY == 0):
            return
        self.is_due = not is_finished
        self.alarm = None
        for image in images:
            # Not the average: frames to come make good in it what is not finite.
            texture = image.last_plane.texture
            if texture is not None:
                self.alarm = self._watch.check(texture) or self.alarm

    def _update_error(self, images: Sequence[LiveImage], view: View, is_finished: bool) -> None:
        """Forget an error of other images; take a new one once samples have doubled."""
        shown = (view.is_error, *(image.shows for image in images))
        if shown != self._shown:
            self._shown, self._samples = shown, 0
            self.error, self.is_error_final = None, False
            self.uncertainty = self._before = None
        if not view.is_error or view.kind is not ColorMapping.DISPLAY or self.is_error_final:
            return
        counts = [image.sample_count for image in images]
        # In motion there is one of each, and no time to read them back. Edges that other
        # sub-pixel offsets have moved would outweigh all else.
        has_doubled = min(counts) > 1 and sum(counts) >= 2 * self._samples
        if is_finished or (has_doubled and images[0].has_offsets_of(images[-1])):
            self._samples = sum(counts)
            self.error, self.is_error_final = _difference(images), is_finished
            if self.error is not None and min(counts) > 0:
                now = sum(1.0 / count for count in counts), self.error
                if self._before is not None and self._before[0] > now[0]:
                    self.uncertainty = noise_within(self._before, now)
                self._before = now

    def release(self) -> None:
        """Free the device objects."""
        self._watch.release()


def noise_within(before: tuple[float, float], now: tuple[float, float]) -> float:
    """Return how much of the error `now` is noise of the samples.

    The squared error is b + v x, where x is the sum of one over the samples of either
    image: v follows from two pairs (x, error), and b is what would be left at last.
    """
    (x_0, error_0), (x_1, error_1) = before, now
    noise = abs(error_0**2 - error_1**2) / (x_0 - x_1) * x_1
    return error_1 - math.sqrt(max(error_1**2 - noise, 0.0))


def _difference(images: Sequence[LiveImage]) -> float | None:
    """Return the relative RMSE of the first image against the second."""
    arrays: list[NDArray[np.float64]] = []
    for image in images:
        texture = image.plane.texture
        if texture is None or image.drawing is None:
            return None
        arrays.append(read_texture(texture)[:, :, :3].astype(np.float64) * image.weight)
    drawing = images[0].drawing
    z_vs = None if drawing is None else drawing.planes["depth"].texture
    if z_vs is None or len(arrays) != 2 or arrays[0].shape != arrays[1].shape:
        return None
    return relative_rms(arrays[0], arrays[1], read_texture(z_vs)[:, :, 0] > 0.0)


def relative_rms(
    image: NDArray[np.float64], reference: NDArray[np.float64], covered: NDArray[np.bool_]
) -> float | None:
    """Return the root mean square difference over the mean of the reference.

    Parameters
    ----------
    image, reference : ndarray, shape (height, width, 3)
        Scene-linear radiance.
    covered : ndarray of bool, shape (height, width)
        Pixels that show a surface.

    Returns
    -------
    float or None
        None where there is nothing to compare with: no surface, or a black reference.
    """
    mask = covered & ~failures(image) & ~failures(reference)
    if mean_level(reference, mask) <= 0.0:
        return None
    return relative_rmse(image, reference, mask)

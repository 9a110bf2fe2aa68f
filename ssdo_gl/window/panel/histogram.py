"""How often each radiance occurs in a picture. Pure."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.color import LUMINANCE

# Stops relative to radiance 1, white at exposure 0: from what no display tells from
# black to a bright lamp.
STOPS = (-10.0, 6.0)
BINS_PER_STOP = 4


def radiance_histogram(beauty: NDArray[np.float32]) -> NDArray[np.float64]:
    """Return the share of covered pixels in each bin of log2 luminance.

    Parameters
    ----------
    beauty : ndarray, shape (height, width, 4)
        Scene-linear, coverage in the fourth channel.

    Returns
    -------
    ndarray, shape (STOPS range * BINS_PER_STOP,)
        Sums to 1; what is darker or brighter counts in the first or last bin, what is
        not finite nowhere. Zeros if nothing is covered.
    """
    count = int((STOPS[1] - STOPS[0]) * BINS_PER_STOP)
    luminance = beauty[beauty[:, :, 3] > 0.0][:, :3].astype(np.float64) @ LUMINANCE
    luminance = luminance[np.isfinite(luminance)]
    if luminance.size == 0:
        return np.zeros(count)
    stops = np.log2(np.maximum(luminance, 2.0 ** STOPS[0]))
    bins = np.clip(((stops - STOPS[0]) * BINS_PER_STOP).astype(int), 0, count - 1)
    return np.asarray(np.bincount(bins, minlength=count) / luminance.size)

"""The exposure that suits a picture, from its own luminance."""

from __future__ import annotations

import math

import numpy as np

from ssdo_gl.color import LUMINANCE
from ssdo_gl.images.error import FloatImage
from ssdo_gl.settings.settings import MAX_EXPOSURE_EV

# The brighter surfaces of a picture come to lie here; a light grey wall would.
_TARGET, _PERCENTILE = 0.35, 75.0
# No more than a twentieth of a picture is whiter than white.
_BRIGHTEST, _BRIGHT_PERCENTILE = 1.0, 95.0
# EV. What is behind a model in added light, seen from outside, is a grey of .28: two steps
# would make it white.
FRAMED_MOST_RAISED = 1.0


def measured_exposure(
    beauty: FloatImage, slack: float = 0.0, most: float = MAX_EXPOSURE_EV
) -> float:
    """Return the exposure in EV, to a tenth, at which a picture shows well.

    Parameters
    ----------
    beauty : ndarray, shape (height, width, 4)
        Scene-linear; the fourth channel is coverage. What lies behind does not count.
    slack : float
        EV by which the picture may be brighter or darker than meant before exposure is used:
        under light of a known level a dark thing is to look dark, and a white one white.
    most : float
        EV, no more than this.

    Returns
    -------
    float
        0 if nothing that is covered shines.
    """
    light = beauty[..., :3][beauty[..., 3] > 0.0].astype(np.float64) @ LUMINANCE
    light = light[np.isfinite(light)]
    if not len(light) or light.max() <= 0.0:
        return 0.0
    level = np.percentile(light, _PERCENTILE)
    bright = np.percentile(light, _BRIGHT_PERCENTILE)
    highest = math.log2(_BRIGHTEST / (bright if bright > 0.0 else light.max()))
    wanted = math.log2(_TARGET / level) if level > 0.0 else highest
    chosen = min(wanted - min(max(wanted, -slack), slack), highest, most)
    return round(min(max(chosen, -MAX_EXPOSURE_EV), MAX_EXPOSURE_EV), 1) + 0.0

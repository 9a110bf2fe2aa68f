"""What is shown where no surface is: the environment, nothing, or one colour."""

from __future__ import annotations

import numpy as np

from ssdo_gl.color import linear_from_srgb, srgb_from_linear

ENVIRONMENT, TRANSPARENT = "environment", "transparent"
_CODES = {"black": "#000000", "grey": "#808080", "white": "#ffffff"}
BACKGROUNDS = (ENVIRONMENT, TRANSPARENT, *_CODES)


def background_color(background: str | None) -> tuple[float, float, float] | None:
    """Return the scene-linear colour, black of transparency; None: the environment is seen.

    Parameters
    ----------
    background : str or None
        One of `BACKGROUNDS`, or ``#rrggbb`` in sRGB. None: environment.
    """
    if background in (None, ENVIRONMENT):
        return None
    code = "#000000" if background == TRANSPARENT else _CODES.get(background, background)
    encoded = np.array([int(code[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])
    red, green, blue = (float(value) for value in linear_from_srgb(encoded))
    return red, green, blue


def color_code(radiance: tuple[float, float, float], exposure_ev: float) -> str:
    """Return the ``#rrggbb`` that a radiance is shown by."""
    exposed = np.clip(np.asarray(radiance) * 2.0**exposure_ev, 0.0, 1.0)
    return "#" + "".join(f"{round(255.0 * value):02x}" for value in srgb_from_linear(exposed))

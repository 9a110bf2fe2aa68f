"""What passes need that include ``lib/brdf.glsl`` for the surfaces in view."""

from __future__ import annotations

from ssdo_gl.graph.frame import Frame
from ssdo_gl.math3d import Region

# Share of the frame that may be drawn twice: shaders for gloss take 1.2 to 1.6 of the time.
LARGEST_TWICE = 0.2


def brdf_wiring(glossy: bool) -> dict[str, str]:
    """Return the resource behind each sampler; `glossy` is the define GLOSSY."""
    gloss = ("gloss", "finish", "reflectance") if glossy else ()
    return {f"t_{name}": name for name in ("albedo", *gloss)}


def gloss_draws(frame: Frame, glossy: bool) -> tuple[tuple[int, Region | None], ...]:
    """Return what to draw one over the other: the define GLOSSY, and where.

    If little of the frame is glossy, all of it is drawn as if nothing was.
    """
    region = frame.gloss_region
    width, height = frame.view.size
    if glossy and region and region[2] * region[3] <= LARGEST_TWICE * width * height:
        return (0, None), (1, region)
    return ((int(glossy), None),)

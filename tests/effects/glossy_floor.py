"""Draws small scenes of glossy things before one camera."""

from __future__ import annotations

import numpy as np
from scene_text import camera, quad, table

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description

SIZE = (64, 48)
HEAD = camera([0, 1, 4], [0, 0.2, 0], 40, exposure=0) + table("render", radius=1.0)
FLOOR = quad([-50, 0, 50], [100, 0, 0], [0, 0, -100], "floor")
GRADIENT = table(
    "environment", kind="gradient",
    zenith=[0.4, 0.5, 0.8], horizon=[0.8, 0.8, 0.8], ground=[0.1, 0.1, 0.1],
)  # fmt: skip


def picture(text: str, **settings):
    scene = read_description(HEAD + text, "scene.toml")
    return np.asarray(ssdo_gl.render(scene, size=SIZE, **settings), np.float64)

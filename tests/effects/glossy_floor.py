"""Draws small scenes of glossy things before one camera."""

from __future__ import annotations

import numpy as np

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description

SIZE = (64, 48)
HEAD = """
[camera]
position = [0, 1, 4]
target = [0, 0.2, 0]
fov_y = 40
exposure = 0
[render]
radius = 1.0
"""


def picture(text: str, **settings):
    scene = read_description(HEAD + text, "scene.toml")
    return np.asarray(ssdo_gl.render(scene, size=SIZE, **settings), np.float64)

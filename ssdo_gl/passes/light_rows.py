"""The lights of a scene as numbers for ``shaders/lights/lights.glsl``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.lights import SHADOW_NUMBERS, Form, Light, kind_number
from ssdo_gl.scene.shadow_frames import ShadowFrame

# Vectors per light and their meaning: see shaders/lights/lights.glsl. The first few do
# without a shadow map.
ROWS_PER_LIGHT = 9
UNSHADOWED_ROWS = 5


def light_rows(
    lights: Sequence[Light], frames: Sequence[ShadowFrame | None], view: FrameView
) -> NDArray[np.float64]:
    """Return what shaders know of each light, shape (len(lights), ROWS_PER_LIGHT, 4)."""
    table = np.zeros((len(lights), ROWS_PER_LIGHT, 4))
    rotation = view.view_from_world.T
    for row, light, frame in zip(table, lights, frames, strict=True):
        _fill_light(row, light, view.position_ws, rotation)
        row[5:8, :3] = light.light_from_world @ rotation
        if frame is not None:
            row[0, 2] = frame.parts_per_side
            row[3:5, 3] = frame.half_size
            row[5:8, 3] = *frame.tile, frame.span
            row[8, :3] = view.point_vs(frame.origin_ws)
            row[8, 3] = frame.face_count
    return table


def _fill_light(
    row: NDArray[np.float64], light: Light, position_ws: FloatArray, rotation: FloatArray
) -> None:
    own = light.own_row
    is_parallel = light.form is Form.PARALLEL
    row[0] = kind_number(light), SHADOW_NUMBERS[light.shadow], 0.0, own.two_sided
    row[1, :3] = (own.place if is_parallel else own.place - position_ws) @ rotation
    row[2, :3] = light.emitted
    row[3, :3] = own.axis @ rotation
    row[4, :3] = own.second_axis @ rotation
    row[1:3, 3] = own.numbers

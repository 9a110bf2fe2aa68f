"""The lights of a scene as numbers for ``shaders/lights/lights.glsl``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.scene.light import DirectionalLight, Light, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.shadow_frames import ShadowFrame, light_axes

# Vectors per light and their meaning: see shaders/lights/lights.glsl.
ROWS_PER_LIGHT = 9
KIND_NUMBERS: Mapping[type, int] = {
    PointLight: 0,
    SpotLight: 1,
    DirectionalLight: 2,
    RectangleLight: 3,
}
SHADOW_NUMBERS = {"none": 0, "map": 1, "ssdo": 2}


def light_rows(
    lights: Sequence[Light], frames: Sequence[ShadowFrame | None], view: FrameView
) -> NDArray[np.float64]:
    """Return what shaders know of each light, shape (len(lights), ROWS_PER_LIGHT, 4)."""
    table = np.zeros((len(lights), ROWS_PER_LIGHT, 4))
    for row, light, frame in zip(table, lights, frames, strict=True):
        row[0, :2] = KIND_NUMBERS[type(light)], SHADOW_NUMBERS[light.shadow]
        _fill_light(row, light, view)
        row[5:8, :3] = light_axes(light) @ view.view_from_world.T
        if frame is not None:
            row[0, 2] = frame.parts_per_side
            row[3:5, 3] = frame.half_size
            row[5:8, 3] = *frame.tile, frame.span
            row[8, :3] = view.point_vs(frame.origin_ws)
            row[8, 3] = frame.face_count
    return table


def _fill_light(row: NDArray[np.float64], light: Light, view: FrameView) -> None:
    if isinstance(light, RectangleLight):
        half_u, half_v = 0.5 * np.asarray(light.edge_u), 0.5 * np.asarray(light.edge_v)
        row[0, 3] = float(light.two_sided)
        row[1, :3] = view.point_vs(np.asarray(light.corner) + half_u + half_v)
        row[2, :3] = light.radiance
        row[3, :3] = view.direction_vs(half_u)
        row[4, :3] = view.direction_vs(half_v)
    elif isinstance(light, DirectionalLight):
        row[1, :3] = view.direction_vs(-light_axes(light)[2])
        row[2, :3] = light.irradiance
    else:
        row[1, :3] = view.point_vs(np.asarray(light.position))
        row[2, :3] = light.intensity
        if isinstance(light, SpotLight):
            cos_inner, cos_outer = (
                math.cos(math.radians(a)) for a in (light.inner_angle, light.outer_angle)
            )
            row[1, 3] = cos_outer
            row[2, 3] = 1.0 / (cos_inner - cos_outer)
            row[3, :3] = view.direction_vs(light_axes(light)[2])

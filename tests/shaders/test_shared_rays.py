"""Whose rays a pixel of a further frame takes (`shaders/rays/shared_rays.glsl`)."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import texture_from_image
from shaders.harness import evaluate

from ssdo_gl.graph.frame import FrameView

SIZE, PIXEL, DEPTH = (9, 9), (4, 4), 2.0
# A wall that faces the camera: both bytes of its normal's code are in the middle.
CODE = 127 | 127 << 8
TOWARD_CAMERA, TILTED = (0.0, 0.0, 1.0), (0.0, 0.8, 0.6)
# What a pixel covers at that depth: the frame is as high as its distance.
FOOTPRINT = DEPTH / SIZE[1]


def shared(gl, shaders, depth=DEPTH, normal=TOWARD_CAMERA, stride=1, of_pixels=()):
    """Return whose rays a point takes that the pixel in the middle shows.

    All others have rays that started from the wall. `of_pixels`: pixels (x, y), what they hold in
    place of a number of rays, and the depth that theirs started from.
    """
    view = FrameView(SIZE, np.zeros(3), np.eye(3), (0.5, 0.5), 0.1, 100.0, (0.0, 0.0), (0.0, 0.0))
    places, near = np.ones((*SIZE, 2), np.int32), np.zeros((*SIZE, 4), np.float32)
    places[..., 1], near[..., 3] = CODE, DEPTH
    for (x, y), number, z in of_pixels:
        # Images have their first row at the top.
        places[SIZE[1] - 1 - y, x, 0], near[SIZE[1] - 1 - y, x, 3] = number, z
    textures = {
        "t_own_places": texture_from_image(gl, places, "i4"),
        "t_own_near": texture_from_image(gl, near, "f4"),
    }
    point = "position_vs_at(uv_of_texel(ivec2(texel)), z)"
    found = evaluate(
        *(gl, shaders.choosing(view.choices), ["rays/shared_rays.glsl"]),
        f"vec2(texel_of_rays(ivec2(texel), {stride}, {point}, vec3{normal}))",
        {"texel": np.array([PIXEL]), "z": np.array([depth], np.float32)},
        2,
        uniforms=view.uniforms(),
        textures=textures,
    )
    return tuple(int(n) for n in found.ravel())


NONE = (-1, -1)


@pytest.mark.parametrize(("footprints", "whose"), [(0.2, PIXEL), (0.3, NONE), (-0.3, NONE)])
def test_rays_of_another_plane_are_not_taken(gl, shaders, footprints, whose) -> None:
    assert shared(gl, shaders, DEPTH + footprints * FOOTPRINT) == whose


def test_rays_of_what_faces_elsewhere_are_not_taken(gl, shaders) -> None:
    assert shared(gl, shaders, normal=TILTED) == NONE


@pytest.mark.parametrize("stride", [1, 2])
@pytest.mark.parametrize("step", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_a_pixel_beside_it_that_shows_the_surface_lends_its_rays(gl, shaders, step, stride) -> None:
    beside = PIXEL[0] + stride * step[0], PIXEL[1] + stride * step[1]
    for depth in (2.5, -2.5):  # negative: it has many rays
        of_pixels = [(beside, 2, depth)]
        assert shared(gl, shaders, 2.5, stride=stride, of_pixels=of_pixels) == beside


def test_a_pixel_without_rays_takes_those_beside_it(gl, shaders) -> None:
    assert shared(gl, shaders, of_pixels=[(PIXEL, 0, DEPTH)]) == (PIXEL[0] + 1, PIXEL[1])

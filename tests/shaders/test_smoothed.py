"""Edges that are smoothed (`shaders/window/smoothed.glsl`), against the area that they cover."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from numpy.typing import NDArray
from passes.pass_harness import texture_from_image
from shaders.harness import evaluate

SIZE = (48, 32)
DARK, BRIGHT = 0.05, 0.8
SUB_PIXELS = 32


def half_plane(slope: float, per_pixel: int) -> NDArray[np.float32]:
    """Return what lies below a line through the middle, as many points across a pixel."""
    width, height = SIZE
    x = (np.arange(width * per_pixel) + 0.5) / per_pixel - 0.5 * width
    y = (np.arange(height * per_pixel) + 0.5) / per_pixel - 0.5 * height
    is_below = y[:, None] < slope * x + 0.3
    parts = is_below.reshape(height, per_pixel, width, per_pixel).mean((1, 3))
    return (DARK + (BRIGHT - DARK) * parts).astype(np.float32)


def smoothed(
    gl, shaders, image: NDArray[np.float32], share: float = 1.0, weight: float = 1.0
) -> NDArray[np.float32]:
    """Return what the shader makes of a grey image (height, width)."""
    height, width = image.shape
    texture = texture_from_image(gl, np.repeat(image[..., None], 4, -1), "f4")
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    rows, columns = np.mgrid[:height, :width]
    uv = (np.stack([columns, height - 1 - rows], -1).reshape(-1, 2) + 0.5) / (width, height)
    body = f"smoothed(t_image, uv, {weight:.8f}, {share:.8f}).r"
    found = evaluate(
        *(gl, shaders, ["window/smoothed.glsl"], body, {"uv": uv}),
        functions="uniform sampler2D t_image;",
        textures={"t_image": texture},
    )
    return found.reshape(height, width)


@pytest.mark.parametrize("turned", [False, True], ids=["level", "upright"])
@pytest.mark.parametrize("slope", [0.1, 0.2, 0.45, -0.3])
def test_an_edge_comes_close_to_what_it_covers(gl, shaders, slope: float, turned: bool) -> None:
    steps, covered = half_plane(slope, 1), half_plane(slope, SUB_PIXELS)
    if turned:
        steps, covered = steps.T.copy(), covered.T.copy()
    # The frame cuts off an end of what lies beside it.
    inner = np.s_[8:-8, 8:-8]
    before = np.abs(steps - covered)[inner].mean()
    after = np.abs(smoothed(gl, shaders, steps) - covered)[inner].mean()
    assert after < 0.5 * before


def test_half_of_the_smoothing_is_half_of_the_way(gl, shaders) -> None:
    steps = half_plane(0.2, 1)
    whole, half = (smoothed(gl, shaders, steps, share) - steps for share in (1.0, 0.5))
    assert np.abs(whole).max() > 0.1
    assert np.abs(half - 0.5 * whole).max() < 1e-5


def test_a_sum_is_smoothed_as_its_mean(gl, shaders) -> None:
    steps = half_plane(0.2, 1)
    of_sum = smoothed(gl, shaders, 4.0 * steps, weight=0.25)
    assert np.abs(of_sum - smoothed(gl, shaders, steps)).max() < 1e-6


def test_gradients_stay_as_they_are(gl, shaders) -> None:
    image = np.tile(np.linspace(0.2, 0.7, SIZE[0], dtype=np.float32), (SIZE[1], 1))
    for gradient in (image, image.T.copy()):
        assert np.abs(smoothed(gl, shaders, gradient) - gradient).max() < 1e-6

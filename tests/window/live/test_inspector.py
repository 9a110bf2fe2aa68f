"""Single pixels read back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.render_result import Drawing
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.window.live.inspector import INSPECTED, clearance, inspect, surface_point

SIZE = (64, 36)
SETTINGS = Settings("bounce", size=SIZE, samples=8, steps=4)
# One float32 rounding of positions of size 1, through the unprojection.
POSITION_TOLERANCE = 1e-6


@pytest.fixture(scope="module")
def drawn(
    device: Device, shaders: ShaderLibrary
) -> Iterator[tuple[Drawing, dict[str, np.ndarray]]]:
    """A frame on the device, and the same frame as arrays."""
    scene = load_scene("cornell_meso")
    names = ("beauty", "visibility", "albedo", "normal_ws", "position_ws", "depth")
    with Renderer(scene, SETTINGS, device=device) as renderer:
        images = renderer.render(names).images
    live = Renderer(scene, SETTINGS, device=device, shaders=shaders)
    yield live.draw(INSPECTED, camera=scene.camera), images
    live.release()


def uv_of(x: int, y: int) -> tuple[float, float]:
    return (x + 0.5) / SIZE[0], (y + 0.5) / SIZE[1]


@pytest.mark.parametrize(("x", "y"), [(32, 18), (20, 9), (45, 30), (26, 4)])
def test_reads_what_the_arrays_hold(gl, drawn, x: int, y: int) -> None:
    drawing, images = drawn
    reading = inspect(gl, drawing, uv_of(x, y))
    assert reading is not None and reading.is_finite
    assert reading.pixel == (x, y)
    assert reading.depth == images["depth"][y, x, 0]
    np.testing.assert_allclose(
        reading.position_ws, images["position_ws"][y, x], atol=POSITION_TOLERANCE
    )
    np.testing.assert_allclose(reading.normal_ws, images["normal_ws"][y, x], atol=1e-6)
    for name in ("beauty", "visibility", "albedo"):
        assert reading.values[name] == tuple(images[name][y, x][:3])
    point = surface_point(gl, drawing, uv_of(x, y))
    np.testing.assert_allclose(point, images["position_ws"][y, x], atol=POSITION_TOLERANCE)


def test_background_has_no_point(gl, drawn) -> None:
    drawing, images = drawn
    assert images["depth"][2, 2, 0] == 0.0
    reading = inspect(gl, drawing, uv_of(2, 2))
    assert reading is not None
    assert (reading.depth, reading.position_ws, reading.normal_ws) == (0.0, None, None)
    assert surface_point(gl, drawing, uv_of(2, 2)) is None


def test_outside_the_picture_there_is_nothing(gl, drawn) -> None:
    drawing, _ = drawn
    assert inspect(gl, drawing, (1.0, 0.5)) is None
    assert inspect(gl, drawing, (0.5, -0.01)) is None


def test_clearance_is_the_nearest_surface_around_the_middle(gl, drawn) -> None:
    drawing, images = drawn
    # Row 18 from the bottom is row 17 from the top.
    middle = images["depth"][17, 21:42, 0]
    assert len(np.unique(middle)) > 1
    assert clearance(gl, drawing) == middle.min()

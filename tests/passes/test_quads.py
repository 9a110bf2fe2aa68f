"""Maps of lights in quads: the same shadows, read in another order."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import Renderer
from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.passes.quads import quads_of
from ssdo_gl.scene.load import load_scene


class Reader:
    """A view."""


@pytest.mark.parametrize("size", [(6, 4), (5, 3)])
def test_a_map_read_twice_is_copied(device, gl, shaders, size):
    if not draws_on_cpu(gl):
        pytest.skip("only processors read quads")
    width, height = size
    values = np.arange(width * height, dtype=np.float32).reshape(height, width, 1)
    atlas = make_texture(gl, size, 1, "f4", values)
    one, other = Reader(), Reader()
    assert quads_of(gl, shaders, atlas, one) is None
    # Two views of one frame read it once.
    assert quads_of(gl, shaders, atlas, other) is None
    quads = quads_of(gl, shaders, atlas, one)
    assert quads is not None
    assert quads_of(gl, shaders, atlas, other) is quads
    stored = np.frombuffer(quads.read(), np.float32).reshape(-(-height // 2), -(-width // 2), 4)
    padded = np.pad(values[..., 0], ((0, height % 2), (0, width % 2)), mode="edge")
    expected = [padded[j::2, i::2] for j in (0, 1) for i in (0, 1)]
    np.testing.assert_array_equal(stored, np.stack(expected, -1))


@pytest.mark.parametrize(
    ("name", "resolution"), [("corner", 64), ("stairs", 33), ("cornell_meso", 33)]
)
def test_a_map_that_was_copied_gives_the_same_picture(device, name, resolution):
    """A point light, the sun and a rectangle; lines of an odd number of texels, too."""
    scene = load_scene(name)
    chosen = {
        "size": (64, 36),
        "method": "direct",
        "overrides": {"shadow_map.resolution": resolution},
    }
    settings = settings_for(scene.render, chosen)
    x, y, z = scene.camera.position
    aside = dataclasses.replace(scene.camera, position=(x + 1e-3, y, z))
    images = []
    for views in ((aside, None), (None,)):
        with Renderer(scene, settings, device=device) as renderer:
            for view in views:
                image = renderer.render(["direct"], camera=view).images["direct"]
            images.append(image)
    assert images[0].max() > 0.0
    np.testing.assert_array_equal(images[0], images[1])

"""The maps of an environment, through upload and lookup."""

from __future__ import annotations

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from passes.pass_harness import make_frame, make_scene, run_pass
from shaders.harness import evaluate

from ssdo_gl.effects.tables.environment import (
    EnvironmentPass,
    octahedral_nodes,
)
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment


def directions(count):
    d = np.random.default_rng(1).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


@pytest.mark.parametrize("rotation_y", [0.0, 40.0])
def test_maps_give_radiance_and_irradiance(gl, shaders, rotation_y):
    """Radiance as the scene defines it, irradiance as its integral."""
    rng = np.random.default_rng(2)
    image = rng.uniform(0.0, 0.2, (16, 32, 3)).astype(np.float32)
    image[4, 10] = 60.0  # a small sun
    environment = MapEnvironment(image, rotation_y)
    scene = make_scene(environment=environment)
    frame = make_frame(scene, (8, 6))
    maps = run_pass(gl, shaders, EnvironmentPass(), frame)

    textures = {f"t_{name}": texture_from_image(gl, value) for name, value in maps.items()}
    found = {}
    for name in ("radiance", "irradiance"):
        found[name] = evaluate(
            gl,
            shaders,
            ["lib/environment.glsl"],
            f"environment_{name}(d)",
            {"d": directions(200)},
            3,
            defines={"ENVIRONMENT_KIND": 3},
            textures=textures,
        )
    wanted = environment.sample(directions(200))
    close = np.all(np.abs(found["radiance"] - wanted) < 1e-5 * (1.0 + wanted), axis=1)
    # Directions on a border of patches may fall on either side.
    assert close.mean() > 0.97
    # The integral, by 4 x 4 points in each patch.
    polar = (np.arange(64) + 0.5) * np.pi / 64
    azimuth = (np.arange(128) + 0.5) * 2.0 * np.pi / 128
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    w = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], -1).reshape(-1, 3)
    weight = (np.sin(p) * (np.pi / 64) * (2.0 * np.pi / 128)).reshape(-1, 1)
    integral = np.maximum(directions(200) @ w.T, 0.0) @ (environment.sample(w) * weight)
    # Interpolation over 64 cells (6e-4) and both quadratures (3e-3 of the sun).
    np.testing.assert_allclose(found["irradiance"], integral, rtol=1e-2, atol=5e-3)


@pytest.mark.parametrize("cells", [4, 6, 64])
def test_nodes_cover_the_rim_and_the_axes(cells):
    n = octahedral_nodes(cells)
    assert n.shape[0] % 2 == 1
    assert n.shape[0] > cells
    middle = n.shape[0] // 2
    np.testing.assert_allclose(n[middle, middle], [0, 0, 1])
    np.testing.assert_allclose(n[middle, -1], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(n[-1, middle], [0, 1, 0], atol=1e-15)
    for corner in (n[0, 0], n[0, -1], n[-1, 0], n[-1, -1]):
        np.testing.assert_allclose(corner, [0, 0, -1], atol=1e-15)
    # Folding makes opposite halves of the rim the same directions.
    np.testing.assert_allclose(n[0], n[0][::-1], atol=1e-15)

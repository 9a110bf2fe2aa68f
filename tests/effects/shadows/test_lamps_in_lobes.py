"""Lamps in metal, by rays to the lamp and rays of the lobe: what paths show, with little noise."""

from __future__ import annotations

import numpy as np
import pytest
from scene_text import camera, lamp, material, quad

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description

REST = camera([0, 1.2, 3], [0, 0, 0], 30, exposure=0)
REST += quad([-3, 0, 3], [6, 0, 0], [0, 0, -6], "m")


def pictures(method, spp, roughness, shadow="map", visible=True, **settings):
    """Two of the floor, from other samples; height, width, 3."""
    text = REST + material("m", 0.9, 0.8, 0.6, metallic=1, roughness=roughness)
    text += lamp([-0.5, 0.3, -1], [1, 0, 0], [0, 0.5, 0], [3, 2, 1], shadow=shadow)
    text += lamp([0.8, 0.3, -1], [0.2, 0, 0], [0, 0.2, 0], [9, 9, 9], visible=visible)
    scene = read_description(text, "lamps.toml")
    found = [
        ssdo_gl.render(scene, size=(32, 24), method=method, spp=spp, seed=seed, **settings)
        for seed in (1, 2)
    ]
    return np.asarray(found, np.float64)[:, 12:, :, :3]


@pytest.mark.parametrize(
    ("roughness", "shadow", "visible"),
    [(0.25, "map", True), (0.4, "map", False), (0.4, "none", True), (0.8, "map", True)],
)
def test_lamps_in_metal_are_those_of_paths(roughness, shadow, visible):
    near = pictures("reference-near", 64, roughness, shadow, visible, aov="specular")
    paths = pictures("reference-gi", 256, roughness, shadow, visible)
    noise = np.sqrt(sum(np.sum((a - b) ** 2) / 4.0 for a, b in (near, paths))) / near[0].size
    assert near.mean() == pytest.approx(paths.mean(), abs=4.0 * noise, rel=1e-4)


@pytest.mark.parametrize(("roughness", "variance"), [(0.05, 3e-3), (0.2, 8e-3), (0.8, 4e-7)])
def test_they_leave_little_noise_at_any_roughness(roughness, variance):
    """By rays to lamps alone it is .6, .13 and 1.5e-7; by lobes alone 6e-4, .01 and 3e-3."""
    a, b = pictures("reference-near", 64, roughness, aov="specular")
    assert np.mean((a - b) ** 2) / 2.0 < variance

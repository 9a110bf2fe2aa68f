"""Glossy passes in a bench: their time, and the error of what they add."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from effects.glossy_floor import GRADIENT
from scene_text import ball, camera, material, quad

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer
from ssdo_gl.bench.measure.errors import judge, judged_pixels
from ssdo_gl.bench.measure.panels import panel_named
from ssdo_gl.bench.measure.reference_cache import Reference
from ssdo_gl.bench.scaling import parts_of
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.settings import Settings

REST = (
    camera([0, 1, 4], [0, 0.4, 0])
    + quad([-5, 0, 5], [10, 0, 0], [0, 0, -10], "floor")
    + ball([0, 0.6, 0], 0.6)
    + GRADIENT
)
SETTINGS = Settings(size=(48, 32), radius=1.0, exposure=0.0)
PASSES = {"reflections", "reflections_filter", "reflected_radiance"}


@pytest.fixture
def bench(device, shaders):
    """Return a function from the floor's keys to a bench's renderer."""

    def opened(**keys):
        scene = read_description(REST + material("floor", 0.6, 0.6, 0.6, **keys), "scene.toml")
        return BenchRenderer(Renderer(scene, SETTINGS, device=device, shaders=shaders))

    return opened


def test_the_time_of_glossy_passes_is_a_part_of_the_frame(bench):
    glossy = bench(roughness=0.3).split(SETTINGS, ("beauty",), 2, "wall")
    assert {name for name, _ in glossy} >= PASSES
    assert parts_of(glossy)["gloss"] > 0.0
    assert "gloss" not in parts_of(bench().split(SETTINGS, ("beauty",), 2, "wall"))


def test_the_error_of_the_specular_part_is_reported(bench):
    renderer, panel = bench(roughness=0.3), panel_named("near")
    images = renderer.images(SETTINGS, panel.aovs)
    near = dataclasses.replace(SETTINGS, method="reference-near", spp=64)
    target = renderer.images(near, panel.aovs)
    none = {name: np.zeros_like(image) for name, image in target.items()}
    reference = Reference(target, none, 1, 64, 0.0)
    mask = judged_pixels(renderer, SETTINGS)
    parts = judge(panel, [images], reference, mask, 0.0).scalars.parts
    # The noise of 64 rays is in it.
    assert 0.001 < parts["specular"] < 0.2
    wrong = {**images, "specular": 1.5 * images["specular"]}
    assert judge(panel, [wrong], reference, mask, 0.0).scalars.parts["specular"] > 0.4

"""Directions that are followed side by side find what they find one after the other."""

from __future__ import annotations

import numpy as np
import pytest
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.back_layer import BackFacesPass, DepthLayersPass
from ssdo_gl.effects.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.effects.ssao import SsaoPass, SsaoSettings
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.passes.gbuffer import GBufferPass

SIZE = (40, 30)


@pytest.fixture(scope="module")
def scene():
    floor = quad((-3, -1, -8), (6, 0, 0), (0, 0, 7))
    boxes = [box((x, -1, -4 - x), (x + 0.5, -0.2, -3.5 - x)) for x in (-1.0, 0.1, 0.9)]
    return make_scene([floor, *boxes])


def images(gl, shaders, scene, samples, steps, estimator):
    frame = make_frame(scene, SIZE)
    known = run_pass(gl, shaders, GBufferPass(), frame)
    known |= run_pass(gl, shaders, BackFacesPass(), frame)
    known |= run_pass(gl, shaders, DepthLayersPass(), frame, known)
    alike = {"samples": samples, "steps": steps, "radius": 1.0, "estimator": estimator}
    keeps = 2 if estimator == "march" else None
    found = {}
    for item in (
        SsaoPass(SsaoSettings(**alike), has_back_layer=True, keeps=keeps),
        DirectionalPass(DirectionalSettings(**alike), has_back_layer=True, keeps=keeps),
    ):
        result = run_pass(gl, shaders, item, frame, {name: known[name] for name in item.reads})
        found |= {f"{item.name} {name}": image for name, image in result.items()}
    return found


@pytest.mark.parametrize(
    ("samples", "steps", "estimator"),
    [(32, 8, "march"), (24, 4, "march"), (20, 4, "march"), (8, 8, "march"), (8, 1, "rgs09")],
)
def test_any_number_together_finds_the_same(gl, scene, samples, steps, estimator):
    """Four, six, five and one direction, bit for bit, with the texels that block them."""
    results = []
    for together in ("1", "2", "4"):
        library = ShaderLibrary(gl)
        library._macros = {**library._macros, "MOST_TOGETHER": together}
        results.append(images(gl, library, scene, samples, steps, estimator))
    alone = results[0]
    assert alone["ssao visibility_raw"][..., 0].min() < 0.8
    for found in results[1:]:
        assert found.keys() == alone.keys()
        for name, image in found.items():
            np.testing.assert_array_equal(image, alone[name], err_msg=name)

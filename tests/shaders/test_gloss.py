"""Gloss of single lights, and the table of what layers reflect."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.brdf import Brdf
from shaders.harness import evaluate, reflectance_texture, unit

from ssdo_gl.effects.tables.gloss_tables import TABLE_SIZE, reflectance_table

COUNT = 4000
ONCE = reflectance_table()[..., 2].astype(np.float64)
# Relative to the value or to 1, for lobes no narrower than alpha = 0.04.
TOLERANCE = 2e-5
ALONG = """
Brdf brdf = Brdf(albedo, f0, f90, roughness);
float d = facets_between(brdf, normal, w_out, w);
LightGloss light = gloss_along(brdf, normal, w_out, w, vec3(max(dot(normal, w), 0.0)), d);
return light.radiance + diffuse_radiance_towards(brdf, normal, w_out, light.irradiance);"""
LAYER_ONCE = """
Brdf brdf = Brdf(vec3(0.0), f0, f90, roughness);
return layer_reflectance(brdf, cosine) / rescattered(brdf, cosine);"""


def surfaces(rng, metal):
    base = rng.uniform(0.02, 1.0, (COUNT, 3))
    return {
        "albedo": np.zeros((COUNT, 3)) if metal else base,
        "f0": base if metal else np.full((COUNT, 3), 0.04),
        "f90": np.ones(COUNT),
        "roughness": rng.uniform(0.2, 1.0, COUNT),
    }


@pytest.mark.parametrize("metal", [True, False], ids=["metal", "dielectric"])
def test_a_light_without_size_is_reflected_as_the_brdf_says(gl, shaders, metal):
    """Both parts together, after what the composite takes from the diffuse one for all light."""
    rng = np.random.default_rng(1)
    normal, w_out, w = (unit(rng.normal(size=(COUNT, 3))) for _ in range(3))
    w_out += (0.05 - np.minimum(np.einsum("ni,ni->n", normal, w_out), 0.05))[:, None] * normal
    inputs = {**surfaces(rng, metal), "normal": normal, "w_out": unit(w_out), "w": w}
    inputs = {name: np.float32(value).astype(np.float64) for name, value in inputs.items()}
    given = Brdf(*(inputs[name] for name in ("albedo", "f0", "f90", "roughness")), once=ONCE)
    wanted = given.times_cosine(inputs["normal"], inputs["w_out"], inputs["w"])
    found = evaluate(
        gl, shaders, ["lights/gloss_along.glsl"], ALONG, inputs, 3, defines={"GLOSSY": 1},
        textures=reflectance_texture(gl),
    )  # fmt: skip
    error = np.abs(found - wanted) / np.maximum(np.abs(wanted), 1.0)
    assert error.max() < TOLERANCE
    assert np.mean(wanted[:, 0] > 0.01) > 0.3


def test_layers_reflect_what_their_table_says_at_its_nodes_and_between(gl, shaders):
    table = reflectance_table()
    place = np.linspace(0.0, 1.0, 2 * TABLE_SIZE - 1)
    roughness, cosine = (a.ravel() for a in np.meshgrid(place, place, indexing="ij"))
    inputs = {
        "roughness": roughness, "cosine": cosine,
        "f0": np.tile([0.9, 0.5, 0.04], (len(cosine), 1)), "f90": np.full(len(cosine), 0.8),
    }  # fmt: skip
    found = evaluate(
        gl, shaders, ["lib/brdf.glsl"], LAYER_ONCE, inputs, 3,
        defines={"GLOSSY": 1}, textures=reflectance_texture(gl),
    )  # fmt: skip
    halves = [table[..., :2]]
    for axis in (0, 1):
        last = np.moveaxis(halves[-1], axis, 0).astype(np.float64)
        fine = np.empty((2 * TABLE_SIZE - 1, *last.shape[1:]))
        fine[::2], fine[1::2] = last, 0.5 * (last[1:] + last[:-1])
        halves.append(np.moveaxis(fine, 0, axis))
    share = halves[-1].reshape(-1, 2)
    wanted = share[:, :1] * [0.9, 0.5, 0.04] + share[:, 1:] * 0.8
    # Texture units place samples to 1 / 256 of a texel, between nodes that differ by 0.3 at most.
    np.testing.assert_allclose(found, wanted, atol=1.5e-3)

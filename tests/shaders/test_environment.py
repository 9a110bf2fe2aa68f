"""Distant light: radiance and irradiance of every kind of environment."""

from __future__ import annotations

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.environment_uniforms import environment_defines
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
    kind_of,
)

INCLUDES = ["lib/environment.glsl"]
GRADIENT = GradientEnvironment((0.3, 0.6, 2.0), (1.0, 0.9, 0.8), (0.2, 0.1, 0.05))
UNIFORMS = {
    "u_environment_zenith": GRADIENT.zenith,
    "u_environment_horizon": GRADIENT.horizon,
    "u_environment_ground": GRADIENT.ground,
}
ROUNDING = 1e-6
# atan() of drivers is good to 2.5e-6, times radiances up to 4.
IRRADIANCE_TOLERANCE = 1e-5


def directions(count=2000, seed=1):
    n = np.random.default_rng(seed).normal(size=(count, 3))
    n = np.concatenate([n, np.eye(3), -np.eye(3)])
    n = n / np.linalg.norm(n, axis=1, keepdims=True)
    return n.astype(np.float32).astype(np.float64)


def sphere_points(rows=400, columns=800):
    """Midpoints of a lat-long grid with their solid angles; independent of the product."""
    polar = (np.arange(rows) + 0.5) * np.pi / rows
    azimuth = (np.arange(columns) + 0.5) * 2.0 * np.pi / columns
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    w = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], -1).reshape(-1, 3)
    return w, (np.sin(p) * (np.pi / rows) * (2.0 * np.pi / columns)).reshape(-1)


def test_kinds_are_numbered_as_the_shader_knows_them():
    image = MapEnvironment(np.ones((2, 4, 3), np.float32))
    for number, environment in enumerate([None, ConstantEnvironment((1, 1, 1)), GRADIENT, image]):
        assert environment_defines(kind_of(environment)) == {"ENVIRONMENT_KIND": number}


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_radiance_without_a_map(gl, shaders, kind):
    d = directions()
    environment = [None, ConstantEnvironment(GRADIENT.zenith), GRADIENT][kind]
    wanted = np.zeros_like(d) if environment is None else environment.sample(d)
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "environment_radiance(d)",
        {"d": d},
        3,
        defines={"ENVIRONMENT_KIND": kind},
        uniforms=UNIFORMS,
    )
    np.testing.assert_allclose(found, wanted, rtol=ROUNDING)


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_irradiance_without_a_map_is_the_integral(gl, shaders, kind):
    n = directions(40)
    environment = [None, ConstantEnvironment(GRADIENT.zenith), GRADIENT][kind]
    w, solid_angle = sphere_points()
    radiance = np.zeros_like(w) if environment is None else environment.sample(w)
    wanted = (np.maximum(n @ w.T, 0.0) * solid_angle) @ radiance
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "environment_irradiance(n)",
        {"n": n},
        3,
        defines={"ENVIRONMENT_KIND": kind},
        uniforms=UNIFORMS,
    )
    # The midpoint rule with 400 rows resolves the kinks to (pi / 400)^2.
    np.testing.assert_allclose(found, wanted, atol=1.5e-4)


def test_clamped_cosines_overlap_in_closed_form(gl, shaders):
    c = np.concatenate([np.linspace(-1.0, 1.0, 2001), [-1.0 + 1e-7, 1.0 - 1e-7]])
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "clamped_cosine_overlap(c)",
        {"c": c},
        defines={"ENVIRONMENT_KIND": 2},
    )[:, 0]
    angle = np.arccos(c.astype(np.float32).astype(np.float64))
    wanted = 2.0 / 3.0 * (np.sin(angle) + (np.pi - angle) * np.cos(angle))
    np.testing.assert_allclose(found, wanted, atol=IRRADIANCE_TOLERANCE)
    assert found[0] == pytest.approx(0.0, abs=IRRADIANCE_TOLERANCE)
    assert found[1000] == pytest.approx(2.0 / 3.0, abs=IRRADIANCE_TOLERANCE)
    assert found[2000] == pytest.approx(2.0 * np.pi / 3.0, abs=IRRADIANCE_TOLERANCE)


def map_textures(gl, image, irradiance):
    def rgba(values):
        return np.concatenate([values, np.ones((*values.shape[:2], 1))], -1)

    height, width = image.shape[:2]
    return {
        "t_environment": make_texture(gl, (width, height), 4, "f4", rgba(image)),
        "t_environment_irradiance": make_texture(
            gl, (len(irradiance), len(irradiance)), 4, "f4", rgba(irradiance)
        ),
    }


def test_map_is_looked_up_where_its_definition_says(gl, shaders):
    """Row 0 is +y, -z the middle column, +x a quarter to the right of it."""
    rng = np.random.default_rng(2)
    image = rng.uniform(0.0, 5.0, (16, 32, 3))
    d = directions()
    u = np.arctan2(d[:, 0], -d[:, 2]) / (2.0 * np.pi) + 0.5
    v = np.arccos(np.clip(d[:, 1], -1.0, 1.0)) / np.pi
    column, row = np.minimum((u * 32).astype(int), 31), np.minimum((v * 16).astype(int), 15)
    # A direction on the border of two patches may fall on either.
    firm = (np.abs(u * 32 - np.round(u * 32)) > 1e-3) & (np.abs(v * 16 - np.round(v * 16)) > 1e-3)
    assert firm.mean() > 0.95
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "environment_radiance(d)",
        {"d": d},
        3,
        defines={"ENVIRONMENT_KIND": 3},
        textures=map_textures(gl, image, np.zeros((4, 4, 3))),
    )
    np.testing.assert_allclose(found[firm], image[row, column][firm], rtol=ROUNDING)
    assert np.all(np.isfinite(found))


def octahedral_grid(cells):
    place = np.linspace(-1.0, 1.0, cells + 1)
    x, y = np.meshgrid(place, place)
    z = 1.0 - np.abs(x) - np.abs(y)
    t = np.maximum(-z, 0.0)
    n = np.stack([x - t * np.copysign(1.0, x), y - t * np.copysign(1.0, y), z], -1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


@pytest.mark.parametrize("size", [16, 32])
def test_irradiance_map_is_smooth_across_its_folds(gl, shaders, size):
    """A linear function of the normal comes back, on folds and corners too."""
    axes = np.array([[0.5, 0.2, 0.1], [0.1, -0.4, 0.3], [-0.2, 0.3, 0.6]])
    table = 1.0 + octahedral_grid(size) @ axes
    edge = np.random.default_rng(3).normal(size=(1000, 3)) * [1.0, 1.0, 0.02]
    below = np.random.default_rng(4).normal(size=(500, 3)) * [0.03, 0.03, 1.0]
    below[:, 2] = -np.abs(below[:, 2])
    n = np.concatenate([directions(), edge, below])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        "environment_irradiance(n)",
        {"n": n},
        3,
        defines={"ENVIRONMENT_KIND": 3},
        textures=map_textures(gl, np.ones((2, 4, 3)), table),
    )
    # Linear interpolation over triangles with legs h = 2 / size: h^2 / 4 of the second
    # derivative, which for |axis| < 0.7 and normals of the octahedron is at most 2.5.
    # A neighbour on the wrong side of a fold would be off by 0.6 h.
    np.testing.assert_allclose(found, 1.0 + n @ axes, atol=2.5 / size**2)

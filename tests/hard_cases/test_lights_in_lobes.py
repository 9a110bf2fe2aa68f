"""What glossy surfaces show of lights: `lights/gloss_of_rectangle.glsl`.

They are compared with a midpoint rule over the visible facets of the float64 twin, which
knows nothing of how the shader aims its points.
"""

from __future__ import annotations

import numpy as np
import pytest
from oracle.brdf import Brdf, visible_normal
from shaders.harness import evaluate, reflectance_texture, unit

from ssdo_gl.effects.tables.gloss_tables import reflectance_table

COUNT = 200
# Squares of the unit square of facets: a light's edge crosses some hundred, each of which is
# wrong by half of itself at random, so the sum by 1e-3 of the lobe.
SIDE = 96
F0 = (1.0, 0.5, 0.04)
GLSL = """
Light light = Light(LIGHT_RECTANGLE, SHADOW_NONE, false, c, vec3(1.0), u, v, vec2(0.0));
Brdf brdf = Brdf(vec3(0.0), f0, 1.0, roughness);
return gloss_of_area(brdf, light, vec3(0.0), normal, w_out);"""
DEFINES = {"GLOSSY": 1, "LIGHT_FORM": 2}
ONCE = reflectance_table()[..., 2].astype(np.float64)


def dot(a, b):
    return np.einsum("...i,...i->...", a, b)


def rectangles(count, roughness, seed=1):
    """Centres, half edges and views over a horizon z = 0.

    Most have a point, mostly near their edge, within the lobe, others lie anywhere, down to
    below the horizon; views from 1.7 degrees above it; lights from 3 degrees to most of the sky.
    """
    rng = np.random.default_rng(seed)
    shape = (4 * count, 1)
    cosine = rng.uniform(0.03, 1.0, shape)
    w_out = np.concatenate([np.sqrt(1.0 - cosine**2), np.zeros(shape), cosine], 1)
    anywhere = unit(rng.normal(size=(4 * count, 3)))
    lobe = rng.exponential(max(2.0 * roughness**2, 2e-3), shape)
    place = unit(w_out * [-1.0, 1.0, 1.0] + lobe * anywhere)
    facing = unit(0.7 * rng.normal(size=(4 * count, 3)) - place)
    size = np.exp(rng.uniform(np.log(0.05), np.log(3.0), shape))
    u = unit(np.cross(facing, rng.normal(size=(4 * count, 3)))) * size
    v = np.cross(facing, u) * rng.uniform(0.2, 1.0, shape)
    s, t = np.clip(1.3 * rng.uniform(-1.0, 1.0, (2, *shape)), -1.0, 1.0)
    c = np.where(rng.random(shape) < 0.75, place - s * u - t * v, anywhere)
    top = c[:, 2] + np.abs(u[:, 2]) + np.abs(v[:, 2])
    good = (-dot(c, facing) > 0.05 * size[:, 0]) & (top > 0.02)
    return [a[good][:count].astype(np.float32).astype(np.float64) for a in (c, u, v, w_out)]


def quadrature(c, u, v, w_out, roughness):
    """Return the radiance at f0 of F0, and that of a light all around, each (N, 3)."""
    rng = np.random.default_rng(2)
    square = np.stack(np.meshgrid(np.arange(SIDE), np.arange(SIDE)), -1).reshape(-1, 2)
    count = len(square)
    ones = np.ones(count)
    normal = np.tile([0.0, 0.0, 1.0], (count, 1))
    brdf = Brdf(np.zeros((count, 3)), np.tile(F0, (count, 1)), ones, roughness * ones, ONCE)
    seen, everything = [], []
    for middle, edge_u, edge_v, out in zip(c, u, v, w_out, strict=True):
        point = (square + rng.random(square.shape)) / SIDE
        out = np.tile(out, (count, 1))
        h = visible_normal(out, brdf.alpha, point)
        w = 2.0 * dot(out, h)[:, None] * h - out
        a_2 = brdf.alpha**2
        spread = np.sqrt(a_2 + (1.0 - a_2) * out[:, 2] ** 2)
        density = brdf.distribution(normal, h) / (2.0 * (out[:, 2] + spread))
        value = brdf.gloss_times_cosine(normal, out, w) / density[:, None]
        # Where the direction meets the light: middle + s u + t v = distance w.
        s_t_distance = np.linalg.solve(
            np.stack([np.tile(edge_u, (count, 1)), np.tile(edge_v, (count, 1)), -w], -1),
            np.tile(-middle, (count, 1))[..., None],
        )[..., 0]
        is_hit = (np.abs(s_t_distance[:, :2]).max(axis=1) < 1.0) & (s_t_distance[:, 2] > 0.0)
        seen.append((value * is_hit[:, None]).mean(axis=0))
        everything.append(value.mean(axis=0))
    return np.array(seen), np.array(everything)


def turned(vectors, seed=3):
    """Return vectors (N, 3), each turned by a rotation of its own, the same in every call."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(len(vectors), 3, 3)))
    q *= np.sign(np.linalg.det(q))[:, None, None]
    return np.einsum("nij,nj->ni", q, vectors)


def by_shader(gl, shaders, c, u, v, w_out, roughness):
    count = len(c)
    inputs = {
        "c": turned(c), "u": turned(u), "v": turned(v), "w_out": turned(w_out),
        "normal": turned(np.tile([0.0, 0.0, 1.0], (count, 1))),
        "f0": np.tile(F0, (count, 1)), "roughness": np.full(count, roughness),
    }  # fmt: skip
    return evaluate(
        gl, shaders, ["lib/space.glsl", "lights/gloss.glsl"], GLSL, inputs, 3, defines=DEFINES,
        textures=reflectance_texture(gl),
    )  # fmt: skip


# Of all that the lobe would show of light all around: what 9000 lights gave, and a little.
RMS = 0.003
OFTEN = 0.004
RARE = {0.0: 0.075, 0.1: 0.055}  # by roughness; else
AT_MOST = 0.02


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.25, 0.4, 0.6, 1.0])
def test_rectangles_in_lobes_against_quadrature(gl, shaders, record, roughness):
    lights = rectangles(COUNT, roughness)
    wanted, everything = quadrature(*lights, roughness)
    is_part = (wanted > 0.05 * everything) & (wanted < 0.95 * everything)
    assert is_part[:, 0].mean() > 0.2, "too few lights are partly in the lobe"
    error = np.abs(by_shader(gl, shaders, *lights, roughness) - wanted) / everything
    case = f"rectangle in a lobe of roughness {roughness}"
    for name, value, bound in (
        ("rms", np.sqrt(np.mean(error**2, axis=0)).max(), RMS),
        ("95 of 100", np.quantile(error, 0.95, axis=0).max(), OFTEN),
        ("worst", error.max(), RARE.get(roughness, AT_MOST)),
    ):
        record(f"{case}: {name}", "direct", value, bound, "of the lobe")


# Roughness, seed and number of lights of 9000 each that 6 x 6 points, or 12 x 6 of those which the
# horizon cuts, miss by .032 to .082: low ones, seen along the surface.
HARD = (
    (0.25, 3, 121), (0.25, 3, 1321), (0.3, 11, 918), (0.4, 13, 409), (0.5, 1, 1486),
    (0.5, 3, 258), (0.5, 13, 405), (0.6, 13, 402),
)  # fmt: skip


def test_low_rectangles_in_lobes_against_quadrature(gl, shaders, record):
    worst = 0.0
    for roughness, seed, number in HARD:
        light = [a[number : number + 1] for a in rectangles(1500, roughness, seed)]
        wanted, everything = quadrature(*light, roughness)
        found = by_shader(gl, shaders, *light, roughness)
        worst = max(worst, float(np.max(np.abs(found - wanted) / everything)))
    record("low rectangle in a lobe", "direct", worst, AT_MOST, "of the lobe")


def test_rectangles_in_lobes_do_not_depend_on_the_unit_of_length(gl, shaders):
    c, u, v, w_out = rectangles(COUNT, 0.3)
    wanted = by_shader(gl, shaders, c, u, v, w_out, 0.3)
    for scale in (2.0**-40, 2.0**40):
        found = by_shader(gl, shaders, scale * c, scale * u, scale * v, w_out, 0.3)
        np.testing.assert_array_equal(found, wanted)


def test_singular_rectangles_in_lobes_give_numbers(gl, shaders):
    """No area, a sliver, the receiver on it, on its edge, in its plane; below the horizon."""
    x, y, z = np.eye(3)
    cases = [
        (z, 0 * x, 0 * x), (z, x, x), (z, x, 1e-30 * y), (0 * z, x, y), (x, x, y),
        (3.0 * x, x, y), (1e-20 * z, x, y), (-z, x, y), (1e12 * z, x, y), (z, 1e12 * x, 1e12 * y),
    ]  # fmt: skip
    c, u, v = (np.array(column) for column in zip(*cases, strict=True))
    for out in (z, unit(x + 1e-4 * z), unit(x - 0.1 * z)):
        for roughness in (0.0, 0.5, 1.0):
            w_out = np.tile(out, (len(cases), 1))
            found = by_shader(gl, shaders, c, u, v, w_out, roughness)
            assert np.isfinite(found).all() and found.min() >= 0.0
            assert found.max() < 1.5
            # Nothing is seen of what has no area or lies below the horizon.
            assert np.abs(found[[0, 7]]).max() == 0.0

"""Averaging highlights over a pixel, on small G-buffers whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.brdf import Brdf
from shaders.harness import evaluate, unit

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.frame import FrameView

# The harness draws rows of 256; each texel is an input.
SIZE = (256, 8)
COUNT = SIZE[0] * SIZE[1]
# Parallel rays, 1 scene unit for each pixel, so that all see along -z.
VIEW = FrameView(
    SIZE, np.zeros(3), np.eye(3), (0.0, 0.0), 0.1, 100.0, half_frame=(SIZE[0] / 2, SIZE[1] / 2)
)
TOWARD_LIGHT = np.array([0.3, 0.1, 0.9]) / np.linalg.norm([0.3, 0.1, 0.9])
HALF = (TOWARD_LIGHT + [0.0, 0.0, 1.0]) / np.linalg.norm(TOWARD_LIGHT + [0.0, 0.0, 1.0])
ALPHA = 0.04
# Relative; a slope in float32 next to an ALPHA, to the fourth power.
TOLERANCE = 1e-4
FRONT = np.array([0.0, 0.0, 1.0])
GLSL = """
Light light;
light.place_vs = w;
light.numbers = vec2(0.0);
ivec2 texel = ivec2(gl_FragCoord.xy);
vec3 n = gbuffer_shading_normal_vs(texel);
return distribution_of_light(light, gbuffer_position_vs(texel), n, alpha);"""


def leaning(slope_x, slope_y=0.0):
    """Normals (..., 3) of a surface of these slopes, in their broadcast shape."""
    x, y = np.broadcast_arrays(slope_x, slope_y)
    return unit(np.stack([-x, -y, np.ones_like(x, float)], -1))


def codes(normals):
    p = normals[..., :2] / np.abs(normals).sum(axis=-1, keepdims=True)
    return (p + 1.0) * 32767.0 / 65535.0


def found_of(gl, shaders, normals, footprint, *, z=10.0, geometric=None):
    """Return the distribution (rows, columns) over each pixel of a picture of `normals`."""
    shape = (SIZE[1], SIZE[0])
    normals = np.broadcast_to(normals, (*shape, 3))
    faces = np.broadcast_to(FRONT if geometric is None else geometric, (*shape, 3))
    stored = np.concatenate([codes(normals), codes(faces)], -1).astype(np.float32)
    depths = np.ascontiguousarray(np.broadcast_to(z, shape), np.float32)
    found = evaluate(
        gl, shaders.choosing(VIEW.choices), ["lights/gloss_filter.glsl"], GLSL,
        {"w": np.tile(TOWARD_LIGHT, (COUNT, 1)), "alpha": np.full(COUNT, ALPHA)},
        defines={"GLOSSY": 1, "LIGHT_FORM": 1, "FILTERS_GLOSS": 1},
        uniforms={**VIEW.uniforms(), "u_gloss_footprint": footprint},
        textures={
            "t_normals_vs": make_texture(gl, SIZE, 4, "f4", stored),
            "t_z_vs": make_texture(gl, SIZE, 1, "f4", depths),
        },
    )  # fmt: skip
    return found.reshape(shape).astype(np.float64)


def at_centres(normals):
    flat = normals.reshape(-1, 3)
    brdf = Brdf.glossy(*np.zeros((2, len(flat), 3)), *np.full((2, len(flat)), np.sqrt(ALPHA)))
    return brdf.distribution(flat, np.tile(HALF, (len(flat), 1))).reshape(normals.shape[:-1])


ARGUMENTS = {
    "defines": {"GLOSSY": 1, "LIGHT_FORM": 1, "FILTERS_GLOSS": 1},
    "functions": "vec3 unused() { return toward_camera(vec3(0.0, 0.0, -1.0)); }",
}


def called(gl, shaders, expression, given):
    chosen, includes = shaders.choosing(VIEW.choices), ["lights/gloss_filter.glsl"]
    return evaluate(gl, chosen, includes, expression, given, **ARGUMENTS)[:, 0].astype(np.float64)


def ggx(points):
    return (1.0 + np.sum(points**2, axis=-1)) ** -2.0


@pytest.mark.parametrize("width", [0.02, 1.0, 10.0])
def test_over_a_part_of_a_pixel_it_is_the_integral(gl, shaders, width):
    """Parallelograms of all shapes, folded and thin ones as well, near the highlight."""
    rng = np.random.default_rng(3)
    s, x = rng.normal(size=(2, 300, 2)) * (1.0 + width)
    x, y = width * x / (1.0 + width), width * rng.normal(size=(300, 2))
    y[::3] *= 0.01
    given = {"s": s, "x": x, "y": y}
    found = called(gl, shaders, "mean_over_part(s, x, y)", given)
    nodes, weights = np.polynomial.legendre.leggauss(96)
    t = 0.5 + 0.5 * nodes
    inside = s[:, None, None] + t[:, None, None] * x[:, None, None] + t[:, None] * y[:, None, None]
    wanted = np.einsum("nij,i,j->n", ggx(inside), 0.5 * weights, 0.5 * weights)
    # Of the largest: a thin part is widened by an eighth of the distribution's width each way.
    assert np.abs(found - wanted).max() < 0.03
    assert found.mean() == pytest.approx(wanted.mean(), rel=0.01)


def over_ellipses(s, x, y):
    """Return the mean of GGX over ellipses about s (n, 2) with half diameters x and y."""
    nodes, weights = np.polynomial.legendre.leggauss(128)
    share, turn = 0.5 + 0.5 * nodes, np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
    around = np.cos(turn)[:, None] * x[:, None] + np.sin(turn)[:, None] * y[:, None]
    inside = s[:, None, None] + np.sqrt(share)[:, None, None] * around[:, None]
    return np.einsum("nij,i->n", ggx(inside), 0.5 * weights) / len(turn)


def test_over_a_disk_of_light_it_is_the_integral(gl, shaders):
    rng = np.random.default_rng(4)
    s, radius = rng.normal(size=(300, 2)) * 3.0, np.abs(rng.normal(size=300)) * 2.0
    radius[:20] = 0.0
    found = called(gl, shaders, "mean_over_disk(s, radius)", {"s": s, "radius": radius})
    wanted = over_ellipses(s, radius[:, None] * [1.0, 0.0], radius[:, None] * [0.0, 1.0])
    np.testing.assert_allclose(found, wanted, rtol=1e-4)


@pytest.mark.parametrize(("width", "tolerance"), [(0.1, 0.03), (1.0, 0.01), (10.0, 0.012)])
def test_over_an_ellipse_of_light_it_is_the_integral(gl, shaders, width, tolerance):
    """Of the largest: of a polygon, and of a disk where it is narrower than a quarter."""
    rng = np.random.default_rng(5)
    x, y = width * rng.normal(size=(2, 300, 2))
    s = rng.normal(size=(300, 2)) * (1.0 + width)
    found = called(gl, shaders, "mean_over_ellipse(s, mat2(x, y))", {"s": s, "x": x, "y": y})
    wanted = over_ellipses(s, x, y)
    assert np.abs(found - wanted).max() < tolerance * wanted.max()


def test_without_a_footprint_or_a_curve_it_is_that_of_the_centre(gl, shaders):
    rng = np.random.default_rng(4)
    slopes = HALF[:2] / -HALF[2] + rng.uniform(-0.08, 0.08, (SIZE[1], SIZE[0], 2))
    normals = leaning(slopes[..., 0], slopes[..., 1])
    wanted = at_centres(normals)
    np.testing.assert_allclose(found_of(gl, shaders, normals, 0.0), wanted, rtol=TOLERANCE)
    even = np.broadcast_to(normals[0, 0], normals.shape)
    found = found_of(gl, shaders, even, 1.0)
    np.testing.assert_allclose(found, at_centres(even), rtol=TOLERANCE)


def test_over_a_curve_it_is_the_mean_over_the_pixel(gl, shaders):
    """Slopes that change by up to twice the width of the distribution from pixel to pixel."""
    columns = np.arange(SIZE[0])
    change = 0.08
    middle = -HALF[0] / HALF[2]

    def normals_at(x):
        return leaning(middle + 0.5 * np.sin(change / 0.5 * (x - 128.0)), -HALF[1] / HALF[2])

    inside = (np.arange(256) + 0.5) / 256 - 0.5
    wanted = at_centres(normals_at(columns[:, None] + inside)).mean(axis=1)
    found = found_of(gl, shaders, normals_at(columns[None, :]), 1.0)[4]
    bright = wanted > 0.02 * wanted.max()
    bright[[0, -1]] = False
    assert bright.sum() > 8
    centres = at_centres(normals_at(columns))
    error, unfiltered = (np.abs(a - wanted)[bright].max() / wanted.max() for a in (found, centres))
    # Lines between neighbours, and an eighth of the distribution's width across them.
    assert error < 0.03
    assert unfiltered > 0.4
    assert found[bright].sum() == pytest.approx(wanted[bright].sum(), rel=0.02)


LEFT = np.arange(SIZE[0]) < 128
BESIDE = leaning(np.where(LEFT, -HALF[0] / HALF[2], -HALF[0] / HALF[2] + 0.05), -HALF[1] / HALF[2])


def test_a_smooth_neighbour_widens_the_highlight_next_to_it(gl, shaders):
    found, centres = found_of(gl, shaders, BESIDE, 1.0)[4], at_centres(BESIDE)
    changed = np.abs(found / centres - 1.0) > 0.01
    assert list(np.flatnonzero(changed)) == [127, 128]


@pytest.mark.parametrize(
    "surface",
    [
        {"z": np.where(LEFT, 10.0, 14.0)},
        {"z": np.where(LEFT, 10.0, 0.0)},
        {"geometric": BESIDE},
    ],
    ids=["far behind", "background", "flat faces"],
)
def test_what_is_another_surface_does_not(gl, shaders, surface):
    found, centres = found_of(gl, shaders, BESIDE, 1.0, **surface)[4], at_centres(BESIDE)
    seen = np.broadcast_to(surface.get("z", 10.0), LEFT.shape) > 0.0
    np.testing.assert_allclose(found[seen], centres[seen], rtol=TOLERANCE)


def test_nor_does_a_neighbour_that_leans_too_far_to_tell_what_lies_between(gl, shaders):
    steep = leaning(np.where(LEFT, -HALF[0] / HALF[2], 0.6), -HALF[1] / HALF[2])
    found, centres = found_of(gl, shaders, steep, 1.0)[4], at_centres(steep)
    np.testing.assert_allclose(found[LEFT], centres[LEFT], rtol=TOLERANCE)

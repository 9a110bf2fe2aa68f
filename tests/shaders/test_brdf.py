"""How surfaces reflect: against float64, and the laws that every reflection keeps."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hard_cases.drawn import SEEDS, batches, directions, float32, numbers, squares, unit
from hypothesis import strategies as st
from oracle import screen_space
from oracle.brdf import Brdf
from oracle.monte_carlo import chi_square_quantile, sidak_level
from shaders.harness import evaluate
from shaders.test_lint import FILES, own_code

INCLUDES = ["lib/brdf.glsl"]
# A dot product of three and two or three products more: some ten roundings of 6e-8, of
# terms that are at most the values' largest.
TOLERANCE = 1e-6
# Unit vectors through sin and cos of the driver, as in test_sampling.
DIRECTION_TOLERANCE = 5e-7
COUNT = 20_000
# Evenly spread directions miss an integral over the sphere by COUNT^(-3/4) of the largest
# value, 1/pi, times 4 pi.
SPREAD = 1 << 14
ENERGY_TOLERANCE = 4.0 * SPREAD**-0.75
SAMPLES = 1 << 17
SIGNIFICANCE = 1e-3


@st.composite
def albedos(draw):
    """Draw functions from a count to albedos, black and white ones among them."""
    seed, edges = draw(SEEDS), draw(st.lists(st.floats(0.0, 1.0), max_size=3))

    def array(count):
        rng = np.random.default_rng(seed)
        values = rng.uniform(0.0, 1.0, (count, 3))
        some = rng.choice([0.0, 1.0, *edges], (count, 3))
        return float32(np.where(rng.random((count, 3)) < 0.2, some, values))

    return array


def surfaces(albedo, normals, w_outs, count=COUNT):
    """Return inputs of the shader: albedo, normal and w_out, the last above the surface."""
    normal, w_out = normals.array(count), w_outs.array(count)[::-1].copy()
    below = np.einsum("ni,ni->n", normal, w_out) < 0.0
    w_out[below] *= -1.0
    return {"albedo": albedo(count), "normal": normal, "w_out": w_out}


def shader(gl, shaders, body, inputs, components):
    found = evaluate(gl, shaders, INCLUDES, body, inputs, components, defines={"GLOSSY": 0})
    return found.astype(np.float64)[:, 0 if components == 1 else slice(None)]


TIMES_COSINE = "brdf_times_cosine(Brdf(albedo), normal, w_out, w_in)"
DENSITY = "brdf_density(Brdf(albedo), normal, w_out, w_in)"
SAMPLE = "brdf_sample(Brdf(albedo), normal, w_out, u)"


@batches(8, albedo=albedos(), normals=directions(), w_outs=directions(), w_ins=directions())
def test_values_and_densities_against_float64(gl, shaders, albedo, normals, w_outs, w_ins):
    given = surfaces(albedo, normals, w_outs)
    w_in = w_ins.array(COUNT)
    inputs = {**given, "w_in": w_in}
    brdf = Brdf.diffuse(given["albedo"])
    wanted = brdf.times_cosine(given["normal"], given["w_out"], w_in)
    assert np.mean(wanted > 0.0) > 0.2
    np.testing.assert_allclose(shader(gl, shaders, TIMES_COSINE, inputs, 3), wanted, atol=TOLERANCE)
    np.testing.assert_allclose(
        shader(gl, shaders, DENSITY, inputs, 1),
        brdf.density(given["normal"], given["w_out"], w_in),
        atol=TOLERANCE,
    )
    reflectance = shader(gl, shaders, "brdf_reflectance(Brdf(albedo))", given, 3)
    np.testing.assert_array_equal(reflectance, brdf.reflectance())


@batches(8, albedo=albedos(), normals=directions(), w_outs=directions(), points=squares())
def test_samples_against_float64(gl, shaders, albedo, normals, w_outs, points):
    given = surfaces(albedo, normals, w_outs)
    u = points.array(COUNT)
    inputs = {**given, "u": u}
    w_in, weight, density = Brdf.diffuse(given["albedo"]).sample(given["normal"], given["w_out"], u)
    found = shader(gl, shaders, f"{SAMPLE}.w_in", inputs, 3)
    np.testing.assert_allclose(found, w_in, atol=DIRECTION_TOLERANCE)
    found_weight = shader(gl, shaders, f"{SAMPLE}.weight", inputs, 3)
    np.testing.assert_allclose(found_weight, weight, atol=TOLERANCE)
    found_density = shader(gl, shaders, f"{SAMPLE}.density", inputs, 1)
    np.testing.assert_allclose(found_density, density, atol=TOLERANCE)
    # The weight is what the estimator of an integral multiplies by.
    value = shader(gl, shaders, TIMES_COSINE, {**given, "w_in": found}, 3)
    np.testing.assert_allclose(found_weight * found_density[:, None], value, atol=TOLERANCE)


@batches(6, albedo=albedos(), light=numbers(-15, 15))
def test_diffuse_radiance_against_float64(gl, shaders, albedo, light):
    inputs = {"albedo": albedo(COUNT), "irradiance": light.array(COUNT, 3)}
    found = shader(gl, shaders, "diffuse_radiance(Brdf(albedo), irradiance)", inputs, 3)
    wanted = Brdf.diffuse(inputs["albedo"]).diffuse_radiance(inputs["irradiance"])
    np.testing.assert_allclose(found, wanted, rtol=TOLERANCE)


def evenly_spread(count):
    """Return directions (count, 3) evenly spread over the sphere."""
    u = screen_space.kronecker_points(np.arange(count), (1 << 31,) * 3)[:, :2]
    z = 1.0 - 2.0 * u[:, 0]
    azimuth = 2.0 * np.pi * u[:, 1]
    r = np.sqrt(1.0 - z * z)
    return float32(np.stack([r * np.cos(azimuth), r * np.sin(azimuth), z], 1))


def over_directions(given, w_in):
    """Return inputs in which every surface meets every direction."""
    count = len(given["normal"])
    repeated = {name: np.repeat(value, len(w_in), axis=0) for name, value in given.items()}
    return {**repeated, "w_in": np.tile(w_in, (count, 1))}


@batches(4, albedo=albedos(), normals=directions(), w_outs=directions())
def test_no_surface_gives_more_than_it_gets(gl, shaders, albedo, normals, w_outs):
    given = surfaces(albedo, normals, w_outs, 12)
    given["albedo"][0] = 1.0
    inputs = over_directions(given, evenly_spread(SPREAD))
    value = shader(gl, shaders, TIMES_COSINE, inputs, 3).reshape(12, SPREAD, 3)
    reflected = 4.0 * np.pi * value.mean(axis=1)
    assert reflected.max() <= 1.0 + ENERGY_TOLERANCE
    assert value.min() >= 0.0
    # A path ends where nothing leaves, so `reflectance` must not promise less than there is.
    share = shader(gl, shaders, "brdf_reflectance(Brdf(albedo))", given, 3)
    assert np.all(reflected <= share + ENERGY_TOLERANCE)
    # In a white furnace, what is diffuse reflects its albedo.
    np.testing.assert_allclose(reflected, given["albedo"], atol=ENERGY_TOLERANCE)


@batches(6, albedo=albedos(), normals=directions(), w_outs=directions(), w_ins=directions())
def test_light_may_be_turned_round(gl, shaders, albedo, normals, w_outs, w_ins):
    """Helmholtz reciprocity, where both directions are above the surface."""
    given = surfaces(albedo, normals, w_outs)
    w_in, w_out, normal = w_ins.array(COUNT), given["w_out"], given["normal"]
    cos_in, cos_out = (np.einsum("ni,ni->n", normal, w) for w in (w_in, w_out))
    # Divided by the cosine, the rounding of small ones is magnified.
    above = (cos_in > 0.01) & (cos_out > 0.01)
    assert np.count_nonzero(above) > COUNT // 5
    there = shader(gl, shaders, TIMES_COSINE, {**given, "w_in": w_in}, 3)
    back = shader(gl, shaders, TIMES_COSINE, {**given, "w_in": w_out, "w_out": w_in}, 3)
    np.testing.assert_allclose(
        there[above] / cos_in[above, None],
        back[above] / cos_out[above, None],
        atol=100.0 * TOLERANCE,
    )


BINS = 12, 24  # of height, of azimuth
FINE = 8  # places in each direction within a bin


def directions_about(normal, heights, azimuths):
    frame = screen_space.frame_from_z(normal[None])[0]
    r = np.sqrt(1.0 - heights**2)
    return np.stack([r * np.cos(azimuths), r * np.sin(azimuths), heights], -1) @ frame.T


CASES = [
    (normal, w_out)
    for normal in ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (0.3, -0.5, -0.8))
    for w_out in ((0.0, 0.0, 1.0), (0.9, 0.1, 0.1))
]


@pytest.mark.parametrize(("normal", "w_out"), CASES)
def test_samples_have_their_density(gl, shaders, normal, w_out):
    """Chi-square of samples in bins of the whole sphere, against the integrated density."""
    rng = np.random.default_rng(7)
    n, out = (unit(float32(vector)) for vector in (normal, w_out))
    out = out if n @ out > 0.0 else -out

    def inputs(count, **more):
        rows = {"albedo": (0.7, 0.4, 0.1), "normal": n, "w_out": out}
        return {name: np.tile(row, (count, 1)) for name, row in rows.items()} | more

    u = float32(rng.uniform(0.0, 1.0 - 2.0**-24, (SAMPLES, 2)))
    w_in = shader(gl, shaders, f"{SAMPLE}.w_in", inputs(SAMPLES, u=u), 3)
    local = w_in @ screen_space.frame_from_z(n[None])[0]
    azimuth = np.arctan2(local[:, 1], local[:, 0])
    ranges = [(-1.0, 1.0), (-np.pi, np.pi)]
    observed = np.histogram2d(local[:, 2], azimuth, BINS, ranges)[0]

    # Equal steps of height and azimuth are equal solid angles.
    edges = [
        low + (np.arange(count * FINE) + 0.5) * (high - low) / (count * FINE)
        for count, (low, high) in zip(BINS, ranges, strict=True)
    ]
    height, turn = (a.ravel() for a in np.meshgrid(*edges, indexing="ij"))
    places = float32(directions_about(n, height, turn))
    density = shader(gl, shaders, DENSITY, inputs(len(places), w_in=places), 1)
    share = density.reshape(BINS[0], FINE, BINS[1], FINE).sum(axis=(1, 3))
    share *= 4.0 * np.pi / len(places)
    # The midpoint rule is exact for a density that is linear in the height.
    assert share.sum() == pytest.approx(1.0, abs=1e-5)

    expected = SAMPLES * share
    tested = expected >= 5.0
    assert np.all(observed[expected < 1e-3] == 0.0)
    statistic = float(np.sum((observed - expected)[tested] ** 2 / expected[tested]))
    level = sidak_level(SIGNIFICANCE, len(CASES))
    limit = chi_square_quantile(level, int(np.count_nonzero(tested)) - 1)
    assert statistic < limit, f"chi-square {statistic:.0f}, allowed {limit:.0f}"


def test_nowhere_else_is_light_reflected():
    """The next material changes one file."""
    reflects = re.compile(r"albedo[^;]*(INV_PI|/\s*PI)|INV_PI[^;]*albedo")
    found = [name for name in FILES if reflects.search(own_code(name))]
    assert found == ["lib/brdf.glsl"]

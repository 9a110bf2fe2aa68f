"""How glossy surfaces reflect: against float64, and the laws that every reflection keeps."""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.drawn import SEEDS, batches, directions, float32, squares, unit
from hypothesis import strategies as st
from oracle import screen_space
from oracle.brdf import MIN_ALPHA, Brdf, visible_normal
from oracle.monte_carlo import chi_square_quantile, sidak_level
from shaders.harness import evaluate, reflectance_texture

from ssdo_gl.effects.tables.gloss_tables import reflectance_table

COUNT = 20_000
# Relative to the value or to 1, whichever is more. Of a narrow lobe the height is that of
# its width squared, whose own rounding the direction's 6e-8 is divided by.
TOLERANCE = 1e-5
SAMPLES = 1 << 17
SIGNIFICANCE = 1e-3
ONCE = reflectance_table()[..., 2].astype(np.float64)


@st.composite
def surfaces(draw):
    """Draw functions from a count to surfaces: metals, dielectrics and both extremes."""
    seed = draw(SEEDS)

    def array(count):
        rng = np.random.default_rng(seed)
        metal = rng.random(count) < 0.5
        roughness = np.where(
            rng.random(count) < 0.2, rng.choice([0.0, 1.0], count), rng.random(count)
        )
        base = np.where(
            rng.random((count, 1)) < 0.2, rng.choice([0.0, 1.0], (count, 1)), rng.random((count, 3))
        )
        f0 = np.where(metal[:, None], base, 0.04)
        return {
            "albedo": float32(np.where(metal[:, None], 0.0, base)),
            "f0": float32(f0),
            "f90": float32(np.ones(count)),
            "roughness": float32(roughness),
        }

    return array


def twin(given):
    names = ("albedo", "f0", "f90", "roughness")
    return Brdf(*(np.asarray(given[name], np.float64) for name in names), once=ONCE)


def at(given, normals, w_outs, grazing=89.99, count=COUNT):
    """Return inputs of the shader with w_out up to `grazing` degrees from the normal."""
    normal, w_out = normals.array(count), w_outs.array(count)[::-1].copy()
    cosine = np.einsum("ni,ni->n", normal, w_out)
    w_out[cosine < 0.0] *= -1.0
    lowest = np.cos(np.radians(grazing))
    low = np.abs(cosine) < lowest
    w_out[low] += (lowest - np.abs(cosine[low]))[:, None] * normal[low]
    return {**given(count), "normal": normal, "w_out": float32(unit(w_out))}


def shader(gl, shaders, body, inputs, components):
    found = evaluate(
        gl, shaders, ["lib/brdf.glsl"], body.replace("BRDF", "Brdf(albedo, f0, f90, roughness)"),
        inputs, components, defines={"GLOSSY": 1}, textures=reflectance_texture(gl),
    )  # fmt: skip
    return found.astype(np.float64)[:, 0 if components == 1 else slice(None)]


TIMES_COSINE = "brdf_times_cosine(BRDF, normal, w_out, w_in)"
DENSITY = "brdf_density(BRDF, normal, w_out, w_in)"
SAMPLE = "brdf_sample(BRDF, normal, w_out, u)"
GLOSS_SAMPLE = "gloss_sample(BRDF, normal, w_out, u)"
RESCATTERED = "rescattered(BRDF, cosine_out(normal, w_out))"
# Light that facets reflect once, and that below them.
ONCE_TIMES_COSINE = (
    f"{TIMES_COSINE} - gloss_times_cosine(BRDF, normal, w_out, w_in)"
    " + once_times_cosine(BRDF, normal, w_out, w_in)"
)


def tolerances(inputs, w_in):
    """Return what errors may be, relative to the value or 1; inf where nothing is known.

    The half vector's rounding is that of the sum of both directions, and moves the place on
    a lobe by so much of its width; that of cosines counts where they are small.
    """
    alpha = np.maximum(inputs["roughness"].astype(np.float64) ** 2, MIN_ALPHA)
    size = np.linalg.norm(inputs["w_out"].astype(np.float64) + w_in, axis=1)
    cosines = [
        np.maximum(np.abs(np.einsum("ni,ni->n", inputs["normal"].astype(np.float64), w)), 1e-4)
        for w in (inputs["w_out"], w_in)
    ]
    rounding = 1e-6 * (1.0 / (alpha * size) + 1.0 / cosines[0] + 1.0 / cosines[1])
    # On the horizon itself, which side light comes from is a matter of rounding.
    return np.where((size > 1e-3) & (cosines[1] > 1e-4), TOLERANCE + rounding, np.inf)


@batches(5, given=surfaces(), normals=directions(), w_outs=directions(), w_ins=directions())
def test_values_and_densities_against_float64(gl, shaders, given, normals, w_outs, w_ins):
    inputs = {**at(given, normals, w_outs), "w_in": w_ins.array(COUNT)}
    args = tuple(inputs[name].astype(np.float64) for name in ("normal", "w_out", "w_in"))
    wanted = twin(inputs).times_cosine(*args)
    found = shader(gl, shaders, TIMES_COSINE, inputs, 3)
    assert np.isfinite(found).all()
    allowed = tolerances(inputs, args[2])
    assert np.mean(np.isfinite(allowed)) > 0.8
    error = np.abs(found - wanted) / np.maximum(np.abs(wanted), 1.0)
    assert np.all(error.max(axis=1) < allowed)
    assert np.quantile(error, 0.99) < TOLERANCE
    density = shader(gl, shaders, DENSITY, inputs, 1)
    error = np.abs(density - twin(inputs).density(*args)) / np.maximum(density, 1.0)
    assert np.all(error < allowed)


@batches(5, given=surfaces(), normals=directions(), w_outs=directions(), points=squares())
def test_samples_against_float64(gl, shaders, given, normals, w_outs, points):
    inputs = {**at(given, normals, w_outs, 89.0), "u": points.array(COUNT)}
    args = tuple(inputs[name].astype(np.float64) for name in ("normal", "w_out", "u"))
    w_in, weight, _ = twin(inputs).sample(*args)
    found = shader(gl, shaders, f"{SAMPLE}.w_in", inputs, 3)
    assert np.isfinite(found).all()
    # Which of both lobes is drawn from may be a matter of rounding, and the angle around
    # the normal of a view along it.
    alike = np.abs(found - w_in).max(axis=1) < 1e-3
    assert np.mean(alike) > 0.99
    found_weight = shader(gl, shaders, f"{SAMPLE}.weight", inputs, 3)
    assert np.isfinite(found_weight).all()
    assert found_weight.min() >= 0.0
    # No sample makes a firefly: its weight is at most what the chance of its lobe leaves.
    assert found_weight.max() <= 11.0
    smooth = inputs["roughness"] > 0.1
    good = alike & smooth
    # Rounding of the sample moves it on its lobe.
    assert np.quantile(np.abs(found_weight - weight)[good], 0.999) < 5e-3


@batches(5, given=surfaces(), normals=directions(), w_outs=directions(), points=squares())
def test_who_looks_from_below_the_horizon_sees_no_firefly(
    gl, shaders, given, normals, w_outs, points
):
    """Mapped normals turn that far; of a facet's back nobody sees a highlight."""
    inputs = {**at(given, normals, w_outs), "u": points.array(COUNT)}
    cosine = np.einsum("ni,ni->n", inputs["normal"], inputs["w_out"])
    inputs["w_out"] = float32(inputs["w_out"] - 2.0 * cosine[:, None] * inputs["normal"])
    weight = shader(gl, shaders, f"{SAMPLE}.weight", inputs, 3)
    assert weight.min() >= 0.0
    assert weight.max() <= 11.0


@batches(5, given=surfaces(), normals=directions(), w_outs=directions(), w_ins=directions())
def test_light_may_be_turned_round(gl, shaders, given, normals, w_outs, w_ins):
    """All but the light that facets scatter on, which is shared out by the view alone."""
    inputs = at(given, normals, w_outs, 80.0)
    w_in, w_out, normal = w_ins.array(COUNT), inputs["w_out"], inputs["normal"]
    cos_in, cos_out = (np.einsum("ni,ni->n", normal, w) for w in (w_in, w_out))
    above = (cos_in > 0.1) & (cos_out > 0.1)
    there = shader(gl, shaders, ONCE_TIMES_COSINE, {**inputs, "w_in": w_in}, 3)
    back = shader(gl, shaders, ONCE_TIMES_COSINE, {**inputs, "w_in": w_out, "w_out": w_in}, 3)
    a, b = there[above] / cos_in[above, None], back[above] / cos_out[above, None]
    np.testing.assert_allclose(a, b, rtol=1e-3, atol=1e-4)


COSINES = (1.0, 0.7, 0.3, 0.1, 0.02, 2e-4)
ROUGHNESSES = (0.0, 0.1, 0.3, 0.6, 1.0)


def sample_weights(gl, shaders, albedo, f0, roughness, cosine, body=f"{SAMPLE}.weight"):
    """Return what samples count, whose mean is the share of even light that leaves."""
    rng = np.random.default_rng(5)
    inputs = {
        "albedo": np.full((SAMPLES, 3), albedo),
        "f0": np.full((SAMPLES, 3), f0),
        "f90": np.ones(SAMPLES),
        "roughness": np.full(SAMPLES, roughness),
        "normal": np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)),
        "w_out": np.tile([np.sqrt(1.0 - cosine**2), 0.0, cosine], (SAMPLES, 1)),
        "u": float32(rng.random((SAMPLES, 2))),
    }
    return shader(gl, shaders, body, inputs, 3)[:, 0]


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_no_metal_gives_more_than_it_gets(gl, shaders, roughness):
    for cosine in COSINES:
        once = f"{GLOSS_SAMPLE}.weight / {RESCATTERED}"
        weight = sample_weights(gl, shaders, 0.0, 1.0, roughness, cosine, once)
        # Not in the mean alone: of what facets reflect once, each counts F G2 / G1.
        assert weight.max() <= 1.0 + 1e-4
        # Those of brdf_sample, a quotient of value and density, have more rounding.
        quotient = sample_weights(gl, shaders, 0.0, 1.0, roughness, cosine)
        error = quotient.std() / np.sqrt(SAMPLES)
        assert quotient.mean() <= 1.0 + 1e-4 + 4.0 * error
        if roughness == 0.0 and cosine > MIN_ALPHA:
            assert weight.mean() == pytest.approx(1.0, abs=5e-3)


# A midpoint rule over the unit square, dense at both ends of the heights of facets.
_SIDES = 256, 32
_PLACES = (np.arange(_SIDES[0]) + 0.5) / _SIDES[0]
HEIGHTS = _PLACES * _PLACES * (3.0 - 2.0 * _PLACES)
POINTS = np.stack(np.meshgrid((np.arange(_SIDES[1]) + 0.5) / _SIDES[1], HEIGHTS), -1).reshape(-1, 2)
WEIGHTS = np.repeat(6.0 * _PLACES * (1.0 - _PLACES), _SIDES[1]) / len(POINTS)


def reflected_once(roughness, cosine):
    """Return the share of even light that facets of Fresnel's 1 reflect once: quadrature."""
    count, ones = len(POINTS), np.ones(len(POINTS))
    brdf = Brdf(np.zeros((count, 3)), np.ones((count, 3)), ones, roughness * ones)
    w_out = np.tile([np.sqrt(1.0 - cosine**2), 0.0, cosine], (count, 1))
    normal = np.tile([0.0, 0.0, 1.0], (count, 1))
    h = visible_normal(w_out, brdf.alpha, POINTS)
    w_in = 2.0 * np.einsum("ni,ni->n", w_out, h)[:, None] * h - w_out
    value = brdf.gloss_times_cosine(normal, w_out, w_in)[:, 0]
    density = brdf.density(normal, w_out, w_in)
    share = np.where(density > 0.0, value / np.where(density > 0.0, density, 1.0), 0.0)
    return share @ WEIGHTS


def test_white_metal_gives_back_all_it_gets(gl, shaders):
    """At nodes of the table, between them and in the flattest views."""
    roughness, cosine = (
        a.ravel()
        for a in np.meshgrid([0.03, 0.08, 0.24, 0.5, 0.79, 1.0], [1e-4, 0.004, 0.05, 0.3, 0.8, 1.0])
    )
    count = len(cosine)
    given = {
        "albedo": np.zeros((count, 3)),
        "f0": np.ones((count, 3)),
        "f90": np.ones(count),
        "roughness": roughness,
        "cosine": cosine,
    }
    more = shader(gl, shaders, "rescattered(BRDF, cosine)", given, 3)[:, 0]
    once = [reflected_once(r, c) for r, c in zip(roughness, cosine, strict=True)]
    assert np.min(once * more) > 0.994
    assert np.max(once * more) <= 1.0 + 1e-4
    assert np.min(once) < 0.31


# What a white dielectric makes of an even sky of 1, by roughness, at these degrees from the
# normal and over all views: quadrature in float64, as `docs/materials.md` has it.
VIEWS = (0, 45, 60, 75, 80, 85, 89, 89.99)
FURNACE = {
    0.0: ((1.000, 1.000, 1.025, 1.203, 1.354, 1.587, 1.851, 1.876), 1.042),
    0.3: ((1.000, 1.001, 1.025, 1.149, 1.222, 1.296, 1.360, 1.378), 1.030),
    0.6: ((0.993, 0.994, 1.002, 1.029, 1.046, 1.069, 1.093, 1.101), 1.001),
    1.0: ((0.973, 0.975, 0.977, 0.983, 0.987, 0.996, 1.010, 1.019), 0.977),
}


@pytest.mark.parametrize("roughness", FURNACE)
def test_dielectrics_of_gltf_give_more_only_at_grazing_views(gl, shaders, roughness):
    """Appendix B mixes by the half vector, so at grazing views both parts are near whole."""
    by_view, over_all = FURNACE[roughness]
    for degrees, wanted in zip(VIEWS, by_view, strict=True):
        cosine = float(np.cos(np.radians(degrees)))
        weight = sample_weights(gl, shaders, 1.0, 0.04, roughness, cosine)
        error = weight.std() / np.sqrt(SAMPLES)
        assert weight.mean() == pytest.approx(wanted, abs=1e-3 + 4.0 * error)
    node, weight = np.polynomial.legendre.leggauss(12)
    cosines, weights = 0.5 * (node + 1.0), 0.5 * weight
    shares = [sample_weights(gl, shaders, 1.0, 0.04, roughness, c).mean() for c in cosines]
    assert 2.0 * np.sum(weights * cosines * shares) == pytest.approx(over_all, abs=4e-3)


BINS = 16, 24  # of height, of azimuth
FINE = 24


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("w_out", [(0.0, 0.0, 1.0), (0.8, 0.2, 0.5), (0.99, 0.0, 0.1)])
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_samples_have_their_density(gl, shaders, roughness, w_out, metallic):
    """Chi-square of samples in bins of the upper hemisphere, against the density."""
    rng = np.random.default_rng(7)
    n, out = (unit(float32(vector)) for vector in ((0.0, 0.0, 1.0), w_out))

    def inputs(count, **more):
        return {
            "albedo": np.full((count, 3), 0.6 * (1.0 - metallic)),
            "f0": np.full((count, 3), 0.04 + 0.8 * metallic),
            "f90": np.ones(count),
            "roughness": np.full(count, roughness),
            "normal": np.tile(n, (count, 1)),
            "w_out": np.tile(out, (count, 1)),
        } | more

    u = float32(rng.uniform(0.0, 1.0 - 2.0**-24, (SAMPLES, 2)))
    w_in = shader(gl, shaders, f"{SAMPLE}.w_in", inputs(SAMPLES, u=u), 3)
    ranges = [(0.0, 1.0), (-np.pi, np.pi)]
    azimuth = np.arctan2(w_in[:, 1], w_in[:, 0])
    # Light from below, which rough facets send there, is none.
    observed = np.histogram2d(w_in[:, 2], azimuth, BINS, ranges)[0]
    edges = [
        low + (np.arange(count * FINE) + 0.5) * (high - low) / (count * FINE)
        for count, (low, high) in zip(BINS, ranges, strict=True)
    ]
    height, turn = (a.ravel() for a in np.meshgrid(*edges, indexing="ij"))
    frame = screen_space.frame_from_z(n[None])[0]
    r = np.sqrt(1.0 - height**2)
    places = float32(np.stack([r * np.cos(turn), r * np.sin(turn), height], -1) @ frame.T)
    density = shader(gl, shaders, DENSITY, inputs(len(places), w_in=places), 1)
    share = density.reshape(BINS[0], FINE, BINS[1], FINE).mean(axis=(1, 3))
    expected = SAMPLES * share * 2.0 * np.pi / (BINS[0] * BINS[1])
    tested = expected >= 10.0
    statistic = float(np.sum((observed - expected)[tested] ** 2 / expected[tested]))
    level = sidak_level(SIGNIFICANCE, 18)
    limit = chi_square_quantile(level, int(np.count_nonzero(tested)))
    assert statistic < 1.1 * limit, f"chi-square {statistic:.0f}, allowed {limit:.0f}"


@pytest.mark.parametrize("body", [TIMES_COSINE, DENSITY])
def test_the_worst_of_views_gives_numbers(gl, shaders, body):
    """Roughness 0, f0 = 1, light and view in the plane, along the normal, and opposite."""
    places = np.array([[0, 0, 1], [1, 0, 0], [-1, 0, 0], [0, 0, -1], [1, 0, 1e-7], [0.6, 0, 0.8]])
    out, into = (a.reshape(-1, 3) for a in np.broadcast_arrays(places[:, None], places[None]))
    count = len(out)
    for roughness in (0.0, 1e-4, 1.0):
        inputs = {
            "albedo": np.ones((count, 3)), "f0": np.ones((count, 3)), "f90": np.ones(count),
            "roughness": np.full(count, roughness), "normal": np.tile([0.0, 0.0, 1.0], (count, 1)),
            "w_out": out.copy(), "w_in": into.copy(),
        }  # fmt: skip
        found = shader(gl, shaders, body, inputs, 1 if body == DENSITY else 3)
        assert np.isfinite(found).all() and found.min() >= 0.0


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize(("albedo", "f0"), [(0.0, 0.9), (0.6, 0.04)], ids=["metal", "dielectric"])
def test_even_reflectance_is_the_mean_over_even_light(gl, shaders, albedo, f0, roughness):
    rng = np.random.default_rng(1)
    cosine = np.sqrt(rng.random(COUNT))
    w_out = np.stack([np.sqrt(1.0 - cosine**2), np.zeros(COUNT), cosine], axis=1)
    surface = {
        "albedo": np.full((COUNT, 3), albedo),
        "f0": np.full((COUNT, 3), f0),
        "f90": np.ones(COUNT),
        "roughness": np.full(COUNT, roughness),
    }
    inputs = {**surface, "normal": np.tile([0.0, 0.0, 1.0], (COUNT, 1)), "w_out": w_out}
    found = shader(gl, shaders, "even_reflectance(BRDF)", inputs, 3)[0]
    draws = f"{SAMPLE}.weight"
    shares = shader(gl, shaders, draws, {**inputs, "u": rng.random((COUNT, 2))}, 3)
    error = 4.0 * shares.std(axis=0) / np.sqrt(COUNT)
    # The fits are good to 0.003.
    np.testing.assert_array_less(np.abs(found - shares.mean(axis=0)), error + 0.004)


@pytest.mark.parametrize("roughness", [0.0, 0.2, 0.5, 0.8, 1.0])
def test_reflectance_falls_where_light_arrives_upright(gl, shaders, roughness):
    """What leaves of light from one direction, by samples: reflection is the same both ways."""
    slope, even = "reflectance_slope(BRDF)", "even_reflectance(BRDF)"
    for cosine in (1.0, 0.8, 0.6, 0.4):
        one = {
            "albedo": np.full((1, 3), 0.6), "f0": np.full((1, 3), 0.04), "f90": np.ones(1),
            "roughness": np.full(1, roughness), "normal": np.array([[0.0, 0.0, 1.0]]),
            "w_out": np.array([[0.0, 0.0, 1.0]]), "cosine": np.full(1, cosine),
        }  # fmt: skip
        found = shader(gl, shaders, f"{even} + {slope} * (grazing_of(cosine) - 1.0)", one, 3)[0, 0]
        weights = sample_weights(gl, shaders, 0.6, 0.04, roughness, cosine)
        error = 4.0 * weights.std() / np.sqrt(SAMPLES)
        # Light from everywhere would be off by .046 where it arrives upright, and smooth.
        assert abs(found - weights.mean()) < error + 0.012

"""Unshadowed light of every kind, against closed forms and float64."""

from __future__ import annotations

import numpy as np
import pytest
from oracle import lambert_polygon
from shaders.harness import evaluate, unit

from ssdo_gl.scene.lights import SpotLight

INCLUDES = ["lights/lights.glsl"]
POLYGON = "parallelogram_cosine_integral(c, u, v, n, m)"
# Float32: some 50 roundings of 6e-8 in the sum over edges, whose terms are of the order
# of the light's size over its distance (here above .05) while the sum is its square.
POLYGON_TOLERANCE = 6e-6
# The sum of up to six terms of up to pi each, for lights that cover much of the sky.
POLYGON_ABSOLUTE = 1e-6
# Ten roundings of 6e-8.
POINT_TOLERANCE = 6e-7
LIGHT = """
Light make(int kind, vec3 place, vec3 axis, vec3 half_v, vec2 cone) {
    return Light(kind, SHADOW_NONE, false, place, vec3(1.0, 10.0, 100.0), axis, half_v,
                 cone);
}
"""


def corners_of(c, u, v):
    return np.array([c - u - v, c + u - v, c + u + v, c - u + v])


def random_lights(count, rng, size=(0.05, 3.0)):
    """Parallelograms in all directions, many cut by the horizon, all seen from the front."""
    n = unit(rng.normal(size=(count, 3)))
    c = unit(rng.normal(size=(count, 3)))
    half = np.exp(rng.uniform(*np.log(size), count))[:, None]
    u = unit(rng.normal(size=(count, 3))) * half
    v = unit(rng.normal(size=(count, 3))) * half * rng.uniform(0.2, 1.0, (count, 1))
    # Face the receiver.
    flip = np.einsum("ij,ij->i", c, np.cross(u, v)) > 0.0
    v[flip] *= -1.0
    # A receiver almost in the light's plane sees it jump with every rounding.
    height = -np.einsum("ij,ij->i", c, unit(np.cross(u, v)))
    keep = height > 0.05 * half[:, 0]
    return tuple(a[keep].astype(np.float32).astype(np.float64) for a in (c, u, v, n))


def test_oracle_agrees_with_the_definition():
    """Clipped Lambert against quadrature; with a cut horizon that converges slowly."""
    rng = np.random.default_rng(1)
    c, u, v, n = random_lights(40, rng, (0.05, 0.4))
    m = unit(n + 0.3 * rng.normal(size=n.shape))
    for i in range(len(c)):
        corners = corners_of(c[i], u[i], v[i])
        exact = lambert_polygon.cosine_integral(corners, n[i], m[i])
        numeric = lambert_polygon.cosine_integral_by_quadrature(corners, n[i], m[i], 200)
        # 200 points a side resolve the kink at the horizon to 1/200 of one of them.
        assert exact == pytest.approx(numeric, rel=1e-2, abs=2e-3)


def test_polygon_against_closed_forms(gl, shaders):
    """D1 and D2 for rectangles that start at the foot of the normal."""
    a = np.array([1.0, 0.2, 5.0, 40.0])
    b = np.array([1.0, 3.0, 0.1, 40.0])
    zero, one = np.zeros_like(a), np.ones_like(a)
    n = np.stack([zero, one, zero], 1)
    # Parallel, at height 1 over the point, facing down.
    c = np.stack([0.5 * a, one, 0.5 * b], 1)
    u, v = np.stack([0.5 * a, zero, zero], 1), np.stack([zero, zero, 0.5 * b], 1)
    found = (
        evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c, "u": u, "v": v, "n": n, "m": n})[:, 0]
        / np.pi
    )
    wanted = [lambert_polygon.parallel_rectangle(x, y, 1.0) for x, y in zip(a, b, strict=True)]
    np.testing.assert_allclose(found, wanted, rtol=POLYGON_TOLERANCE)
    assert wanted[0] == pytest.approx(0.138532, abs=1e-6)
    # Perpendicular, standing on the receiver's plane at distance 1, facing it (-z).
    c = np.stack([0.5 * b, 0.5 * a, one], 1)
    u, v = np.stack([zero, 0.5 * a, zero], 1), np.stack([0.5 * b, zero, zero], 1)
    found = (
        evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c, "u": u, "v": v, "n": n, "m": n})[:, 0]
        / np.pi
    )
    wanted = [lambert_polygon.perpendicular_rectangle(x, y, 1.0) for x, y in zip(a, b, strict=True)]
    np.testing.assert_allclose(found, wanted, rtol=POLYGON_TOLERANCE)
    assert wanted[0] == pytest.approx(0.055734, abs=1e-6)


@pytest.mark.parametrize("smooth", [0, 1])
def test_polygon_against_float64(gl, shaders, smooth):
    """All orientations, cut by one horizon or by both."""
    rng = np.random.default_rng(2)
    c, u, v, n = random_lights(3000, rng)
    m = unit(n + 0.4 * rng.normal(size=n.shape)) if smooth else n
    m = m.astype(np.float32).astype(np.float64)
    found = evaluate(
        gl,
        shaders,
        INCLUDES,
        POLYGON,
        {"c": c, "u": u, "v": v, "n": n, "m": m},
        defines={"HAS_SHADING_NORMALS": smooth},
    )[:, 0]
    wanted = np.array(
        [
            lambert_polygon.cosine_integral(corners_of(*light), n_i, m_i)
            for *light, n_i, m_i in zip(c, u, v, n, m, strict=True)
        ]
    )
    cut = np.count_nonzero((wanted > 0.0) & (wanted < 0.9 * wanted.max()))
    assert cut > 1000, "too few lights are partly visible to test clipping"
    np.testing.assert_allclose(found, wanted, rtol=POLYGON_TOLERANCE, atol=POLYGON_ABSOLUTE)


def test_small_lights_lose_no_precision(gl, shaders):
    """Where the terms of Lambert's sum cancel: down to a millionth of the distance."""
    size = np.exp(np.linspace(np.log(1e-6), np.log(0.1), 200))
    rng = np.random.default_rng(3)
    c = unit(rng.normal(size=(200, 3)))
    u = np.cross(c, rng.normal(size=(200, 3)))
    u = unit(u) * size[:, None]
    v = unit(unit(np.cross(c, u)) + 0.3 * c) * size[:, None]
    flip = np.einsum("ij,ij->i", c, np.cross(u, v)) > 0.0
    v[flip] *= -1.0
    n = unit(c + 0.5 * unit(rng.normal(size=(200, 3))))
    c, u, v, n = (a.astype(np.float32).astype(np.float64) for a in (c, u, v, n))
    found = evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c, "u": u, "v": v, "n": n, "m": n})[:, 0]
    wanted = [
        lambert_polygon.cosine_integral_by_quadrature(corners_of(*light), n_i, n_i, 8)
        for *light, n_i in zip(c, u, v, n, strict=True)
    ]
    np.testing.assert_allclose(found, wanted, rtol=POLYGON_TOLERANCE)


@pytest.mark.parametrize("scale", [1e-12, 1e-3, 1.0, 1e4, 1e12])
def test_polygon_is_scale_free(gl, shaders, scale):
    rng = np.random.default_rng(4)
    c, u, v, n = random_lights(200, rng)
    power_of_two = 2.0 ** np.round(np.log2(scale))
    inputs = {"u": u * power_of_two, "v": v * power_of_two, "n": n, "m": n}
    found = evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c * power_of_two, **inputs})
    wanted = evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c, "u": u, "v": v, "n": n, "m": n})
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-7)


def test_singular_polygons_are_finite_and_dark(gl, shaders):
    """No area, a sliver, the receiver on a corner, on an edge, inside, in the plane."""
    z = np.array([0.0, 0.0, 1.0])
    x = np.array([1.0, 0.0, 0.0])
    y = np.array([0.0, 1.0, 0.0])
    zero = np.zeros(3)
    cases = [  # centre, half edges, normal
        (zero, zero, zero, z),
        (z, zero, zero, z),
        (z, x, x, z),
        (z, x, 1e-30 * y, z),
        (x, x, y, z),
        (x + y, x, y, z),
        (x, x, y, y),
        (3.0 * x, x, y, x),
        (-z, x, y, z),
    ]
    c, u, v, n = (np.array(column) for column in zip(*cases, strict=True))
    found = evaluate(gl, shaders, INCLUDES, POLYGON, {"c": c, "u": u, "v": v, "n": n, "m": n})
    assert np.all(np.isfinite(found))
    # A light of no solid angle gives nothing; one in whose plane the receiver lies is
    # judged by rectangle_irradiance, tested below.
    assert np.abs(found[[0, 1, 2, 3, 8]]).max() < 1e-6


def rectangle_light(gl, shaders, p, n, c, u, v, two_sided=False):
    body = f"""
    bool sides = {str(two_sided).lower()};
    Light light = Light(LIGHT_RECTANGLE, SHADOW_NONE, sides, c, vec3(1.0, 2.0, 3.0),
                        u, v, vec2(0.0));
    return unshadowed_irradiance(light, p, n, n);"""
    return evaluate(gl, shaders, INCLUDES, body, {"p": p, "n": n, "c": c, "u": u, "v": v}, 3)


def test_rectangles_emit_on_one_side_and_not_onto_their_own_plane(gl, shaders):
    count = 400
    rng = np.random.default_rng(5)
    eye_distance = 1e3  # position_vs is only known to 1e-7 of this
    c = np.tile([0.2, 0.3, -eye_distance], (count, 1))
    u, v = np.tile([0.5, 0.0, 0.1], (count, 1)), np.tile([0.0, 0.5, -0.2], (count, 1))
    front = unit(np.cross(u, v))
    in_plane = c + rng.uniform(-3, 3, (count, 1)) * u + rng.uniform(-3, 3, (count, 1)) * v
    for normal in (front, -front):
        # Float32 rounding alone puts these on either side of the plane.
        found = rectangle_light(gl, shaders, in_plane, normal, c, u, v, two_sided=True)
        np.testing.assert_array_equal(found, 0.0)
    behind, before = in_plane - front, in_plane + front
    assert np.all(rectangle_light(gl, shaders, behind, front, c, u, v) == 0.0)
    lit = rectangle_light(gl, shaders, before, -front, c, u, v)
    assert np.all(lit > 0.0)
    np.testing.assert_allclose(lit, lit[:, :1] * [1.0, 2.0, 3.0], rtol=3e-7)
    from_behind = rectangle_light(gl, shaders, behind, front, c, u, v, two_sided=True)
    mirrored = 2.0 * in_plane - behind
    wanted = rectangle_light(gl, shaders, mirrored, -front, c, u, v)
    # Positions 1e3 from the eye are rounded to 3e-5 of the light's size.
    np.testing.assert_allclose(from_behind, wanted, rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_point_and_spot_lights_follow_their_law(gl, shaders, scale):
    rng = np.random.default_rng(6)
    count = 500
    p = rng.uniform(-2, 2, (count, 3))
    place = rng.uniform(-2, 2, (count, 3))
    n = unit(rng.normal(size=(count, 3)))
    m = unit(n + 0.3 * rng.normal(size=n.shape))
    axis = unit(p - place + 0.5 * rng.normal(size=(count, 3)))
    p, place, n, m, axis = (a.astype(np.float32).astype(np.float64) for a in (p, place, n, m, axis))
    p, place = p * 2.0 ** np.round(np.log2(scale)), place * 2.0 ** np.round(np.log2(scale))
    inner, outer = 10.0, 50.0
    cos_inner, cos_outer = np.cos(np.radians([inner, outer]))
    cone = np.tile([1.0 - cos_outer, 1.0 / (cos_inner - cos_outer)], (count, 1))
    to_light = place - p
    w = unit(to_light)
    cosine = np.maximum((w * n).sum(1), 0.0) * ((w * m).sum(1) > 0.0)
    wanted = cosine / (to_light**2).sum(1)
    inputs = {"p": p, "place": place, "n": n, "m": m, "axis": axis, "cone": cone}
    for kind, factor in (
        ("LIGHT_POINT", 1.0),
        ("LIGHT_SPOT", lambert_polygon.spot_falloff((-w * axis).sum(1), inner, outer)),
    ):
        body = f"unshadowed_irradiance(make({kind}, place, axis, vec3(0.0), cone), p, n, m)"
        found = evaluate(gl, shaders, INCLUDES, body, inputs, 3, functions=LIGHT)
        # The cosines' own rounding shows where they are near the edge of the cone.
        np.testing.assert_allclose(
            found,
            (wanted * factor)[:, None] * [1.0, 10.0, 100.0],
            rtol=POINT_TOLERANCE,
            atol=4e-6 * wanted.max() * 100.0,
        )


@pytest.mark.parametrize(("inner", "outer"), [(0.0, 0.01), (0.0, 0.02), (0.05, 0.1), (0.999, 1.0)])
def test_narrow_spots_light_their_disk(gl, shaders, inner, outer):
    """Cosines of such cones differ by less than a few roundings of float32."""
    light = SpotLight((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), (1.0, 1.0, 1.0), inner, outer)
    angle = np.radians(outer) * np.linspace(0.0, 1.2, 200)
    p = np.stack([np.sin(angle), 0.0 * angle, -np.cos(angle)], 1)
    cone = np.tile(light.shader_row().numbers, (len(p), 1))
    body = """unshadowed_irradiance(
        make(LIGHT_SPOT, vec3(0.0), vec3(0.0, 0.0, -1.0), vec3(0.0), cone),
        p, vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, 1.0))"""
    found = evaluate(gl, shaders, INCLUDES, body, {"p": p, "cone": cone}, 3, functions=LIGHT)
    # Half the sum times half the difference: float64 cancels, too.
    i, o = np.radians(inner), np.radians(outer)
    ramp = np.sin((o + angle) / 2) * np.sin((o - angle) / 2)
    ramp /= np.sin((o + i) / 2) * np.sin((o - i) / 2)
    wanted = np.clip(ramp, 0.0, 1.0) ** 2 * np.cos(angle)
    # Positions are good to 6e-8 of the distance, the cone is 1.7e-4 wide, or its rim is.
    np.testing.assert_allclose(found[:, 0], wanted, atol=4.0 * 6e-8 / (o - i))


def test_directional_light_is_the_cosine(gl, shaders):
    rng = np.random.default_rng(7)
    n, m, to_light = (
        unit(rng.normal(size=(300, 3))).astype(np.float32).astype(np.float64) for _ in range(3)
    )
    body = "unshadowed_irradiance(make(LIGHT_DIRECTIONAL, w, w, w, vec2(0.0)), vec3(0.0), n, m)"
    found = evaluate(
        gl, shaders, INCLUDES, body, {"w": to_light, "n": n, "m": m}, 3, functions=LIGHT
    )
    wanted = np.maximum((to_light * n).sum(1), 0.0) * ((to_light * m).sum(1) > 0.0)
    np.testing.assert_allclose(found, wanted[:, None] * [1, 10, 100], rtol=1e-6, atol=2e-5)


def test_a_light_at_the_surface_stays_finite(gl, shaders):
    """At distance 0 and at distances whose square float32 cannot hold."""
    distance = np.array([0.0, 1e-38, 1e-30, 1e-20, 1e-10, 1e18, 1e25])
    place = np.stack([distance * 0.0, distance, distance * 0.0], 1)
    n = np.tile([0.0, 1.0, 0.0], (len(distance), 1))
    body = """unshadowed_irradiance(make(LIGHT_POINT, place, n, n, vec2(0.0)), vec3(0.0), n, n)"""
    found = evaluate(gl, shaders, INCLUDES, body, {"place": place, "n": n}, 3, functions=LIGHT)
    assert np.all(np.isfinite(found))
    assert np.all(found[0] == 0.0)
    assert found[4, 0] == pytest.approx(1e20, rel=1e-5)
    assert found[5, 0] == pytest.approx(1e-36, rel=1e-5)


def test_angle_is_exact_where_drivers_are_not(gl, shaders):
    angle = np.concatenate([np.linspace(0.0, np.pi, 5000), np.geomspace(1e-12, 1.0, 500)])
    sine, cosine = np.sin(angle).astype(np.float32), np.cos(angle).astype(np.float32)
    sine = np.maximum(sine, 0.0)
    found = evaluate(gl, shaders, INCLUDES, "angle_of(s, c)", {"s": sine, "c": cosine})[:, 0]
    wanted = np.arctan2(sine.astype(np.float64), cosine.astype(np.float64))
    # 3e-7: the polynomial's 1e-7 and two roundings.
    np.testing.assert_allclose(found, wanted, rtol=3e-7)

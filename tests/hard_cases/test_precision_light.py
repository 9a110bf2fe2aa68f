"""Light against float64 twins: lights, environments, spherical rectangles, shadow maps.

As test_precision.py: 100 000 inputs a time, whose ranges and edges hypothesis draws.
"""

from __future__ import annotations

import numpy as np
from hard_cases.drawn import COUNT, SEEDS, batches, directions, float32, numbers, squares, unit
from hypothesis import strategies as st
from oracle import lambert_polygon, screen_space
from shaders.harness import evaluate
from shaders.test_lights import LIGHT

from ssdo_gl.gpu.texture import make_texture

STAGE = "shader against float64"
# Under which rectangles are sampled by area: rays/emitters.glsl.
SMALL_SOLID_ANGLE = 0.02
EPSILON = 2.0**-23


def around(n, rng, spread):
    """Return unit vectors near `n`, in float32."""
    return float32(unit(n + spread * rng.normal(size=n.shape)))


@batches(
    seed=SEEDS,
    normals=directions(),
    distances=numbers(-12, 12),
    inner=st.floats(0.0, 60.0),
    width=st.floats(5.0, 60.0),
)
def test_point_spot_and_directional_lights(
    gl, shaders, record, seed, normals, distances, inner, width
):
    """Light from 1e-12 to 1e12 away; the receiver is the origin."""
    rng = np.random.default_rng(seed)
    n = normals.array()
    m = around(n, rng, 0.2)
    place = float32(distances.array(COUNT)[:, None] * around(n, rng, 1.0))
    w = unit(place)
    axis = around(-w, rng, 0.5)
    outer = min(inner + width, 89.0)
    cos_inner, cos_outer = np.cos(np.radians([inner, outer]))
    cone = float32(np.tile([1.0 - cos_outer, 1.0 / (cos_inner - cos_outer)], (COUNT, 1)))
    cosine = np.maximum((w * n).sum(1), 0.0)
    side = (w * m).sum(1)
    # Rounding decides on which side of its horizon a light exactly on it lies.
    sure = np.abs(side) > 1e-6
    inputs = {"place": place, "n": n, "m": m, "axis": axis, "cone": cone, "w": float32(w)}
    ramp = lambert_polygon.spot_falloff((-w * axis).sum(1), inner, outer)
    law = cosine * (side > 0.0)
    squares_ = (place**2).sum(1)
    for kind, at, factor in (
        ("LIGHT_POINT", "place", 1.0 / squares_),
        ("LIGHT_SPOT", "place", ramp / squares_),
        ("LIGHT_DIRECTIONAL", "w", 1.0),
    ):
        # The first number of parallel light is its spread, here none.
        numbers = "vec2(0.0)" if kind == "LIGHT_DIRECTIONAL" else "cone"
        light = f"make({kind}, {at}, axis, vec3(0.0), {numbers})"
        body = f"unshadowed_irradiance({light}, vec3(0.0), n, m)"
        found = evaluate(
            gl, shaders, ["lights/lights.glsl"], body, inputs, 3, functions=LIGHT
        )[:, 0].astype(float)  # fmt: skip
        scale = 1.0 / squares_ if at == "place" else np.ones(COUNT)
        error = (np.abs(found - law * factor) / scale)[sure].max() / EPSILON
        # Of light that falls straight: the direction's 3 roundings, the cosine's 3, the
        # quotients' 3. A spot's ramp is as steep as its cone is narrow, and squared.
        bound = 6.0
        if kind == "LIGHT_SPOT":
            error /= 1.0 + 1.0 / (cos_inner - cos_outer)
        kind = kind.removeprefix("LIGHT_").lower()
        record(f"{STAGE}: light, {kind}", "irradiance", error, bound, "ULP of straight light")


GRADIENT = np.array([(0.3, 0.6, 2.0), (1.0, 0.9, 0.8), (0.2, 0.1, 0.05)])


@batches(normals=directions())
def test_gradient_sky(gl, shaders, record, normals):
    n = normals.array()
    zenith, horizon, ground = float32(GRADIENT)
    names = ("u_environment_zenith", "u_environment_horizon", "u_environment_ground")
    options = {
        "defines": {"ENVIRONMENT_KIND": 2},
        "uniforms": dict(zip(names, map(tuple, GRADIENT), strict=True)),
    }
    y = n[:, 1:2]
    wanted = horizon + (zenith - horizon) * np.maximum(y, 0.0)
    wanted += (ground - horizon) * np.maximum(-y, 0.0)
    include = ["lib/environment.glsl"]
    found = evaluate(gl, shaders, include, "environment_radiance(n)", {"n": n}, 3, **options)
    error = (np.abs(found - wanted) / np.maximum(wanted, horizon)).max() / EPSILON
    # Differences of two colours, two products, two sums.
    record(f"{STAGE}: gradient, radiance", "environment", error, 4.0, "ULP of the horizon")

    def overlap(cosine):
        angle = np.arctan2(np.sqrt(np.maximum((1 - cosine) * (1 + cosine), 0.0)), cosine)
        return 2.0 / 3.0 * (np.sin(angle) + (np.pi - angle) * cosine)

    length = np.linalg.norm(n, axis=1, keepdims=True)
    y = y / length
    wanted = np.pi * horizon + (zenith - horizon) * overlap(y) + (ground - horizon) * overlap(-y)
    found = evaluate(gl, shaders, include, "environment_irradiance(n)", {"n": n}, 3, **options)
    error = np.abs(found / wanted - 1.0).max()
    # atan() of drivers is good to 2.5e-6; the sky's colours differ by up to the factor 10.
    record(f"{STAGE}: gradient, irradiance", "environment", error, 5e-6, "relative")


@batches(towards=directions(), rows=st.integers(1, 512), columns=st.integers(1, 1024))
def test_sky_map_lookup(gl, shaders, record, towards, rows, columns):
    """Every texel holds its own address: which one does a direction meet?"""
    d = towards.array()
    image = np.zeros((rows, columns, 4))
    image[..., 0], image[..., 1] = np.arange(columns), np.arange(rows)[:, None]
    texture = make_texture(gl, (columns, rows), 4, "f4", image)
    found = evaluate(
        gl, shaders, ["lib/environment.glsl"], "environment_map_radiance(d).xy", {"d": d}, 2,
        defines={"ENVIRONMENT_KIND": 3}, textures={"t_environment": texture},
    ).astype(float)  # fmt: skip
    texture.release()
    # Straight up or down there is no azimuth.
    has_azimuth = np.hypot(d[:, 0], d[:, 2]) > 0.0
    u = (np.arctan2(d[:, 0], -d[:, 2]) / (2.0 * np.pi) + 0.5) * columns
    v = np.arctan2(np.hypot(d[:, 0], d[:, 2]), d[:, 1]) / np.pi * rows
    error = 0.0
    for address, place, size in ((found[:, 0], u, columns), (found[:, 1], v, rows)):
        # How far outside the texel that was taken; the seam's two sides are neighbours.
        outside = np.maximum(np.maximum(address - place, place - address - 1.0), 0.0) / size
        error = max(error, np.minimum(outside, 1.0 - outside)[has_azimuth].max())
    # atan() is good to 2.5e-6 rad on llvmpipe, of pi or 2 pi.
    record(f"{STAGE}: sky map lookup", "environment", error, 1.5e-6, "of the map, outside")


@batches(
    seed=SEEDS,
    points=squares(),
    sizes=numbers(-1.5, 1, (1.0,)),
    offsets=numbers(-2, 0.5, (1.0,)),
    heights=numbers(-2, 1),
)
def test_spherical_rectangles(gl, shaders, record, seed, points, sizes, offsets, heights):
    size = sizes.array(COUNT, 2)
    rng = np.random.default_rng(seed)
    # Half of them overhead, half aside.
    aside = np.where(rng.random((COUNT, 1)) < 0.5, offsets.signed(COUNT, 2), -0.5 * size)
    corner = float32(np.concatenate([aside, -heights.array(COUNT)[:, None]], 1))
    x0, y0, z = corner.T
    x1, y1 = x0 + size[:, 0], y0 + size[:, 1]

    def part(x, y):
        return np.arctan2(x * y, np.abs(z) * np.sqrt(x * x + y * y + z * z))

    wanted = part(x1, y1) - part(x0, y1) - part(x1, y0) + part(x0, y0)
    inputs = {"corner": corner, "size": size}
    include = ["lights/spherical_rectangle.glsl"]
    body = "spherical_rectangle(corner, size.x, size.y)"
    found = evaluate(gl, shaders, include, f"{body}.solid_angle", inputs)[:, 0]
    error = np.abs(found - wanted).max()
    # Four angles of up to pi, each good to 2e-7 of itself and rounded in the sum.
    record(f"{STAGE}: solid angle", "rectangle", error, 4e-6, "sr")
    inputs["u"] = points.array()
    point = evaluate(gl, shaders, include, f"spherical_rectangle_point({body}, u)", inputs, 3)
    # The share of the solid angle left of the point must be u: its definition, turned
    # around. Smaller ones are sampled by area instead (lib/emitters.glsl).
    x = point[:, 0].astype(float)
    left = part(x, y1) - part(x0, y1) - part(x, y0) + part(x0, y0)
    # Angles of up to 2 pi, a few roundings each, through the quotient of a sine: a point
    # as far aside as the rectangle reaches magnifies them by its slope.
    slope = 1.0 + np.maximum(np.abs([x0, y0]), np.abs([x1, y1])).max(0) / np.abs(z)
    error = np.abs(left - inputs["u"][:, 0] * wanted) / slope
    large = wanted > SMALL_SOLID_ANGLE
    error = error[large].max() / EPSILON if np.any(large) else 0.0
    record(f"{STAGE}: solid angle left of a sample", "rectangle", error, 24.0, "ULP x slope")
    inside = np.all((point[:, :2] >= corner[:, :2]) & (point[:, :2] <= float32([x1, y1]).T))
    record("samples on the rectangle", "rectangle", float(not inside), 0, "outside")


@batches(seeds=st.tuples(*[SEEDS] * 3), first=SEEDS)
def test_sample_points_are_integers_in_disguise(gl, shaders, record, seeds, first):
    index = np.random.default_rng(first).integers(0, 2**32, COUNT, dtype=np.uint32)
    offset = np.tile(np.array(seeds, np.uint32), (COUNT, 1))
    found = evaluate(
        gl, shaders, ["lib/hash.glsl"], "kronecker_point(index, offset)",
        {"index": index, "offset": offset}, 3,
    )  # fmt: skip
    wanted = screen_space.kronecker_points(index.astype(np.int64), tuple(map(int, seeds)))
    record(f"{STAGE}: sample points", "kronecker", np.abs(found - wanted).max(), 0.0, "off")
    assert found.max() < 1.0


@batches(codes=numbers(-8, 0, (0.0, 1.0, 0.04045)), radiances=numbers(-30, 38, (65504.0,)))
def test_codes_and_what_can_be_displayed(gl, shaders, record, codes, radiances):
    include = ["lib/color.glsl"]
    x = codes.array(COUNT)
    found = evaluate(gl, shaders, include, "srgb_decode(x)", {"x": x})[:, 0]
    wanted = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    error = np.abs(found / np.maximum(wanted, 1e-30) - 1.0)[wanted > 0.0].max()
    # pow() is exp2(y log2 x): as for encoding.
    record(f"{STAGE}: sRGB, decode", "color", error, 2e-6, "relative")
    x = radiances.signed(COUNT)
    found = evaluate(gl, shaders, include, "displayable(x)", {"x": x})[:, 0]
    gap = np.abs(found - np.clip(x, 0.0, 65504.0)).max()
    record(f"{STAGE}: displayable", "color", gap, 0.0, "off")


SHADOW = """
uniform vec2 u_half_size;
float shadow(vec3 p, vec3 m, float texels) {
    ShadowMap map = ShadowMap(vec2(0.0), 1.0, 1, texels, 1, u_half_size, vec3(0.0), mat3(1.0));
    return point_shadow_visibility(map, p, m, 0.0, SHADOW_FAR_TEXELS, false);
}
"""
SIDE = 64
SLACK, NORMAL_SLACK, FAR_TEXELS = 0.25, 2e-4, 64.0
# What rises above the receiver's plane by more, texels, and blocks nothing says nothing.
SAME_PLANE = 0.02
# Decisions that hang on less than this are rounding's to take.
TIE = 3e-5


def shadow_twin(depth, half, p, m):
    """Return visibility (N,) by nine texels, where no decision is a near tie, their weight."""
    place = p[:, :2] / p[:, 2:] * (0.5 * SIDE / half) + 0.5 * SIDE
    middle = np.floor(place)
    sure = np.abs(place - np.rint(place)).min(1) > 1e-3
    t = place - middle
    weights = np.stack([0.5 * (1 - t) ** 2, 0.75 - (t - 0.5) ** 2, 0.5 * t * t])
    texel_size = p[:, 2] * 2.0 * half / SIDE
    slack = SLACK * texel_size
    blocked, counted = np.zeros(len(p)), np.zeros(len(p))
    for j in range(3):
        for i in range(3):
            # The block of nine stays on the face; what a map shows lies two texels within.
            at = (np.clip(middle - 1, 0, SIDE - 3) + (i, j)).astype(int)
            z = depth[at[:, 1], at[:, 0]]
            slope = (at + 0.5 - 0.5 * SIDE) * (2.0 * half / SIDE)
            o = np.concatenate([slope * z[:, None], z[:, None]], 1)
            height = ((o - p) * m).sum(1)
            least = slack + NORMAL_SLACK * np.abs(o - p).sum(1)
            below, above = -height > least, height > least
            joins = least - (SLACK - SAME_PLANE) * texel_size
            far = p[:, 2] - o[:, 2] > FAR_TEXELS * texel_size
            sure &= np.abs(np.abs(height) - least) > TIE
            sure &= np.abs(height - joins) > TIE
            sure &= np.abs(p[:, 2] - o[:, 2]) > TIE
            sure &= np.abs(p[:, 2] - o[:, 2] - FAR_TEXELS * texel_size) > TIE
            weight = weights[i, :, 0] * weights[j, :, 1]
            blocks = np.where(below, far, (o[:, 2] < p[:, 2]) & above)
            counted += np.where((below | (height > joins)) & ~blocks, 0.0, weight)
            blocked += np.where(blocks, weight, 0.0)
    counted = np.maximum(counted, 1e-30)
    return np.where(blocked > 0.0, 1.0 - blocked / counted, 1.0), sure, counted


@batches(6, seed=SEEDS, half=st.floats(0.1, 1.0), share=st.floats(0.0, 1.0))
def test_shadow_filter(gl, shaders, record, seed, half, share):
    """Receivers before, behind and among texels of random depth."""
    rng = np.random.default_rng(seed)
    depth = float32(np.where(rng.random((SIDE, SIDE)) < share, 1.0, 4.0 * rng.random((SIDE, SIDE))))
    z = rng.uniform(0.5, 4.0, COUNT)
    xy = rng.uniform(-1.0, 1.0, (COUNT, 2)) * half * z[:, None]
    p = float32(np.concatenate([xy, z[:, None]], 1))
    m = float32(unit(rng.normal(size=(COUNT, 3))))
    half = float(np.float32(half))
    texture = make_texture(gl, (SIDE, SIDE), 1, "f4", depth)
    found = evaluate(
        gl, shaders, ["lights/shadow.glsl"], "shadow(p, m, 64.0)", {"p": p, "m": m},
        functions=SHADOW, uniforms={"u_half_size": (half, half), "u_shadow_tile_texels": SIDE},
        textures={"t_shadow_atlas": texture}, defines={"LIGHT_FORM": 0},
    )[:, 0]  # fmt: skip
    texture.release()
    wanted, sure, weight = shadow_twin(depth, half, p, m)
    assert sure.mean() > 0.95
    # Nine products of weights, relative to those that count. Their places, in texels, have
    # ULPs of 64 and are off by a few.
    error = (np.abs(found - wanted) * weight)[sure].max() / (SIDE * EPSILON)
    record(f"{STAGE}: shadow filter", "shadow map", error, 4.0, "ULP of a place")

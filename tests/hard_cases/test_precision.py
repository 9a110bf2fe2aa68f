"""Each stage of the shaders against a float64 twin, over 100 000 inputs and their edges.

Hypothesis draws the ranges, edges and seeds of the inputs (see drawn.py), the same ones
every time.

The table states the worst error in units in the last place (ULP: the gap between
neighbouring float32 numbers, 1.2e-7 of the value at most) or in relative terms. Bounds are
the roundings of the formula, counted, with what drivers are known to add.
"""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.drawn import COUNT, SEEDS, batches, directions, float32, numbers, squares, unit
from hypothesis import strategies as st
from oracle import lambert_polygon, ray_triangles, screen_space
from shaders.harness import evaluate
from shaders.test_bvh import NEAREST, arguments, bvh_of, soup
from shaders.test_lights import corners_of, random_lights

from ssdo_gl.graph.frame import FrameView

STAGE = "shader against float64"


def ulp(values):
    return np.spacing(np.abs(values).astype(np.float32)).astype(np.float64)


def angle_between(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1))


SIDES = st.sampled_from([1, 2, 720, 1280, 16384]) | st.integers(1, 16384)


@batches(
    8,
    seed=SEEDS,
    size=st.tuples(SIDES, SIDES),
    tangent=st.floats(1e-3, 20.0),
    jitter=st.tuples(*[st.floats(-0.5, 0.5)] * 2),
    depths=numbers(-15, 15),
)
def test_positions_from_depth(gl, shaders, record, seed, size, tangent, jitter, depths):
    """From 1e-15 to 1e15 units away, at any field of view, with jitter.

    Of the largest component: uv, 2 uv - 1, + jitter, * tangent, * z round once each, and
    2 uv - 1 doubles what came before.
    """
    rng = np.random.default_rng(seed)
    view = FrameView(size, np.zeros(3), np.eye(3), (tangent, tangent), 0.1, 1e3, jitter)
    texel = np.stack([rng.integers(0, n, COUNT) for n in size], 1)
    texel[:2] = (0, 0), np.subtract(size, 1)
    z = depths.array(COUNT)
    inputs = {"texel": texel, "z": z}
    body = "position_vs_at(uv_of_texel(texel), z)"
    args = {"uniforms": view.uniforms()}
    found = evaluate(gl, shaders, ["lib/space.glsl"], body, inputs, 3, **args).astype(float)
    shift, tangents = float32(view.jitter_ndc), float32(view.tan_half_fov)
    ndc = (2.0 * texel + 1.0) / size - 1.0 + shift
    wanted = np.concatenate([ndc * tangents * z[:, None], -z[:, None]], 1)
    extent = z * max(1.0, tangent) * (1.0 + np.abs(shift).max())
    error = (np.abs(found - wanted).max(axis=1) / ulp(extent)).max()
    record(f"{STAGE}: position from depth", "space", error, 4.0, "ULP")
    body = "texel_of_uv(uv_of_position_vs(position_vs_at(uv_of_texel(texel), z))) - texel"
    moved = evaluate(
        gl, shaders, ["lib/space.glsl"], body, inputs, 2, output_dtype="i4", **args
    )  # fmt: skip
    record("texel from its own position", "space", np.abs(moved).max(), 0, "texels off")


@batches(normals=directions())
def test_octahedral_normals(gl, shaders, record, normals):
    n = normals.array()
    include = ["lib/octahedral.glsl"]
    found = evaluate(gl, shaders, include, "oct_decode(oct_encode(n))", {"n": n}, 3).astype(float)
    # The code in [0, 1] has a ULP of 6e-8, of 2 units of the map; the map stretches by sqrt 3.
    error = angle_between(found, n).max() / 2.0**-23
    record(f"{STAGE}: octahedral round trip", "float32 code", error, 5.0, "ULP of 1 rad")
    length = np.abs(np.linalg.norm(found, axis=1) - 1.0).max() / 2.0**-23
    record(f"{STAGE}: octahedral length", "float32 code", length, 2.0, "ULP")
    code = evaluate(gl, shaders, include, "oct_encode(n)", {"n": n}, 2)
    stored = np.rint(code * 65535.0) / 65535.0
    found = evaluate(gl, shaders, include, "oct_decode(e)", {"e": stored}, 3).astype(float)
    # FIELD of 16 + 16 bits: half a step of 3e-5 along both axes, stretched: 6.5e-5.
    error = np.degrees(angle_between(found, n).max())
    record("octahedral round trip, stored", "16 + 16 bits", error, 0.004, "degrees")


@pytest.mark.parametrize("name", ["cosine_hemisphere", "uniform_hemisphere"])
@batches(points=squares())
def test_hemisphere_directions(gl, shaders, record, name, points):
    u = points.array()
    found = evaluate(gl, shaders, ["lib/sampling.glsl"], f"{name}(u)", {"u": u}, 3).astype(float)
    wanted = getattr(screen_space, name)(u)
    # 2 pi u rounds an angle of up to 6.3 by 2.4e-7, twice.
    error = np.abs(found - wanted).max() / 2.0**-23
    record(f"{STAGE}: directions", name, error, 5.0, "ULP of 1")
    length = np.abs(np.linalg.norm(found, axis=1) - 1.0).max() / 2.0**-23
    record(f"{STAGE}: directions, length", name, length, 3.0, "ULP")
    assert found[:, 2].min() > 0.0, "no direction may lie in the plane"


@batches(normals=directions())
def test_frames(gl, shaders, record, normals):
    n = normals.array()
    wanted = screen_space.frame_from_z(n)
    worst = 0.0
    for i in range(3):
        column = evaluate(gl, shaders, ["lib/sampling.glsl"], f"frame_from_z(n)[{i}]", {"n": n}, 3)
        worst = max(worst, float(np.abs(column - wanted[..., i]).max()))
    # 1 / (1 + |z|) and three products.
    record(f"{STAGE}: tangent frame", "frame_from_z", worst / 2.0**-23, 4.0, "ULP of 1")


@batches(sines=numbers(-18, 18), ratios=numbers(-7, 7, (1.0,)))
def test_angles(gl, shaders, record, sines, ratios):
    """Over all quadrants and ratios, where acos() of a cosine would lose all digits."""
    sine = sines.array(COUNT)
    cosine = float32(sine * ratios.signed(COUNT))
    cosine[:100] = 0.0
    found = evaluate(
        gl, shaders, ["lib/angle.glsl"], "angle_of(s, c)", {"s": sine, "c": cosine}
    )[:, 0]  # fmt: skip
    wanted = np.arctan2(sine, cosine)
    error = np.abs(found / wanted - 1.0).max()
    # The polynomial's own 2e-7, the quotient and one reduction.
    record(f"{STAGE}: angle", "angle_of", error, 4e-7, "relative")


def polygon_integral(corners, n):
    """Return the cosine integral of parallelograms (N, 4, 3) above the horizons of n (N, 3)."""
    total = np.zeros(len(n))
    leaves, returns = np.zeros_like(n), np.zeros_like(n)
    cut = np.zeros(len(n), bool)
    height = np.einsum("nik,nk->ni", corners, n)

    def edge(a, b, used):
        product = np.cross(a, b)
        size = np.linalg.norm(product, axis=1)
        used = used & (size > 0.0)
        angle = np.arctan2(size, (a * b).sum(1))
        return np.where(used, angle * (product * n).sum(1) / np.where(used, size, 1.0), 0.0)

    for i in range(4):
        j = (i + 1) % 4
        a, b = corners[:, i], corners[:, j]
        up_a, up_b = height[:, i] > 0.0, height[:, j] > 0.0
        crosses = up_a != up_b
        t = height[:, i] / np.where(crosses, height[:, i] - height[:, j], 1.0)
        crossing = a + (b - a) * t[:, None]
        down, up = (crosses & up_a)[:, None], (crosses & up_b)[:, None]
        leaves, returns = np.where(down, crossing, leaves), np.where(up, crossing, returns)
        cut |= crosses
        total += edge(np.where(up, crossing, a), np.where(down, crossing, b), up_a | up_b)
    return -0.5 * (total + edge(leaves, returns, cut))


@batches(seed=SEEDS, powers=st.tuples(*[st.floats(-3.0, 0.5)] * 2))
def test_polygon_irradiance(gl, shaders, record, seed, powers):
    """Rectangles from a thousandth to three times their distance, many below the horizon."""
    sizes = tuple(10.0**power for power in sorted(powers))
    c, u, v, n = random_lights(int(COUNT * 1.1), np.random.default_rng(seed), sizes)
    corners = np.stack([c - u - v, c + u - v, c + u + v, c - u + v], 1)
    wanted = polygon_integral(corners, n)
    for i in range(50):
        known = lambert_polygon.cosine_integral(corners_of(c[i], u[i], v[i]), n[i], n[i])
        assert wanted[i] == pytest.approx(known, rel=1e-9, abs=1e-12)
    found = evaluate(
        gl,
        shaders,
        ["lights/lights.glsl"],
        "parallelogram_cosine_integral(c, u, v, n, n)",
        {"c": c, "u": u, "v": v, "n": n},
        defines={"HAS_SHADING_NORMALS": 0},
    )[:, 0]
    # The terms of the sum over edges are of the order of the light's outline as seen from
    # the receiver, and so is their rounding; their sum is of the order of its square.
    error = np.abs(found - wanted)
    edge = np.maximum(np.linalg.norm(u, axis=1), np.linalg.norm(v, axis=1))
    outline = np.minimum(8.0 * edge / np.linalg.norm(c, axis=1), 2.0 * np.pi)
    worst = (error / outline).max() / 2.0**-23
    record(f"{STAGE}: rectangle irradiance", "Lambert", worst, 8.0, "ULP of its outline")
    # A square that faces the receiver overhead gives a sixteenth of its outline squared.
    bright = wanted > outline**2 / 64.0
    median = np.median(error[bright] / wanted[bright]) if np.any(bright) else 0.0
    record(f"{STAGE}: rectangle, median", "Lambert", median, 1e-6, "relative")


@batches(radiances=numbers(-30, 4.8, (0.0, 65504.0)), codes=numbers(-8, 0, (0.0, 1.0, 0.0031308)))
def test_tone_curve_and_encoding(gl, shaders, record, radiances, codes):
    x = radiances.array(COUNT)
    include = ["lib/color.glsl"]
    found = evaluate(gl, shaders, include, "tone_curve_aces(vec3(x)).x", {"x": x})[:, 0]
    y = 0.6 * x
    wanted = np.clip(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0.0, 1.0)
    error = np.abs(found - wanted) / np.maximum(wanted, 1e-30)
    record(f"{STAGE}: filmic curve", "aces", error.max(), 8.0 * 2.0**-23, "relative")
    x = codes.array(COUNT)
    found = evaluate(gl, shaders, include, "srgb_encode(x)", {"x": x})[:, 0]
    wanted = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
    # pow() is exp2(y log2 x): 5.5e-7 on llvmpipe. A step of the display is 4e-3.
    record(f"{STAGE}: sRGB", "encode", np.abs(found - wanted).max(), 1e-6, "absolute")


@batches(2, seed=SEEDS, scene=st.integers(0, 100))
def test_rays_against_all_triangles(gl, shaders, record, seed, scene):
    """Nearest hits through the hierarchy against every triangle tried in float64."""
    bvh = bvh_of(soup(60, scene))
    rng = np.random.default_rng(seed)
    origin = float32(rng.uniform(-0.7, 0.7, (COUNT, 3)))
    direction = rng.normal(size=(COUNT, 3))
    # Along axes and in their planes, where slabs divide by zero.
    direction[::9, 0] = 0.0
    direction[::27, 1] = 0.0
    direction = float32(unit(direction))
    triangles = bvh.triangles.positions.astype(np.float64)
    t, which = ray_triangles.intersect_all(origin, direction, triangles)
    inputs = {"origin": origin, "direction": direction, "limit": np.full(COUNT, 4.0)}
    out = evaluate(gl, shaders, ["rays/bvh.glsl"], NEAREST, inputs, 4, **arguments(gl, bvh))
    slot = out[:, 1].astype(np.int64)
    found = np.where(slot < 0, -1, bvh.primitive_triangles.reshape(-1)[np.maximum(slot, 0)])
    a, b, c = np.moveaxis(triangles[which], 1, 0)
    cosine = np.abs((unit(np.cross(b - a, c - a)) * direction).sum(1))
    same = (found == which) & (which >= 0)
    # Rounding decides for rays that pass an edge within 1e-6 of the scene's size.
    record("rays that hit another triangle", "bvh", np.mean(found != which), 1e-3, "share")
    # Positions round by 6e-8 and t by a few of that; a grazing ray divides by its cosine.
    error = np.abs(out[same, 0] - t[same]) * np.maximum(cosine[same], 1e-3)
    record(f"{STAGE}: distance along rays", "bvh", error.max() / 2.0**-23, 8.0, "ULP of 1 x cos")

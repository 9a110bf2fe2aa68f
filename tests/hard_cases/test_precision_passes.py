"""Whole passes against float64 twins, over some 100 000 pixels or samples a time.

As test_precision.py; hypothesis draws the seeds and ranges. Decisions that hang on a near
tie are rounding's to take: their share is bounded, and all others must be the same.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from effects import bounce_harness
from hard_cases.drawn import COUNT, SEEDS, batches, directions, float32, numbers, unit
from hypothesis import example
from hypothesis import strategies as st
from oracle import analytic_pictures, screen_space
from passes import filter_harness as filter_tests
from passes.estimator_cases import (
    covered_texels,
    picture_frame,
    random_picture,
    run_visibility,
    stored,
    tilted_plane,
    twin_of,
)
from passes.gbuffer_harness import draw, nearest, normals, rays_of
from passes.pass_harness import make_scene, run_pass
from shaders.harness import evaluate

from ssdo_gl.effects.bounce import BounceSettings
from ssdo_gl.effects.ssao import SsaoSettings
from ssdo_gl.passes.composite import CompositePass
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms
from ssdo_gl.passes.tone_map import ToneMapPass, ToneMapSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh

STAGE = "pass against float64"
EPSILON = 2.0**-23
# 17 000 covered texels with 6 directions each.
SIZE = (160, 120)
TAN_Y = 0.5
# Some comparison of a pixel's 24 is within 1e-5 of a tie.
UNSURE_SHARE = 0.03
# Of the others, those that rounding decides after all: products of several roundings go
# beyond 1e-5 once in a million comparisons, and a pixel hangs on 24.
OTHERWISE_SHARE = 3e-4


def compare(record, case, estimator, error, bound, unit):
    """Record the errors (N,) of pixels: how many are decided otherwise, the worst of the rest."""
    otherwise = error > 1e-4
    share = float(np.mean(otherwise))
    record(f"{case}, otherwise", estimator, share, OTHERWISE_SHARE, "of the pixels")
    record(case, estimator, error[~otherwise].max() / EPSILON, bound, unit)


@pytest.mark.parametrize("estimator", ["march", "hemisphere", "rgs09"])
@batches(3, seed=SEEDS, radius=st.floats(0.1, 3.0), has_back=st.booleans())
def test_visibility(gl, shaders, record, estimator, seed, radius, has_back):
    """Every texel a surface of its own: all tests of a sample decide, all the time."""
    settings = SsaoSettings(estimator=estimator, radius=radius, samples=24, steps=4)
    frame = picture_frame(SIZE, TAN_Y, seed=seed % 2**31)
    picture = random_picture(seed, SIZE, frame.view.tan_half_fov, has_back)
    found = run_visibility(gl, shaders, picture, settings, frame)
    texel = covered_texels(picture)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame, has_back))
    sure = ~samples.unsure.any(1)
    record(f"{STAGE}: near ties", estimator, 1.0 - sure.mean(), UNSURE_SHARE, "of the pixels")
    wanted = screen_space.visibility(samples)
    error = np.abs(found[texel[:, 1], texel[:, 0]] - wanted)[sure]
    # N shares of 1 / N are added; rgs09 weights them by cosines.
    compare(record, f"{STAGE}: visibility", estimator, error, 4.0, "ULP of 1")


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
@batches(3, seed=SEEDS, radius=st.floats(0.1, 3.0))
def test_bounce(gl, shaders, record, estimator, seed, radius):
    """March weights senders by solid angle, rgs09 by A_s cos cos / d^2."""
    clamp = 0.2
    settings = BounceSettings(
        estimator=estimator, radius=radius, samples=24, steps=4, refine_steps=0,
        distance_clamp=clamp,
    )  # fmt: skip
    frame = picture_frame(SIZE, TAN_Y)
    picture = random_picture(seed, SIZE, frame.view.tan_half_fov, False)
    sent = np.random.default_rng(seed).uniform(0.0, 1.0, (*picture.z.shape, 3))
    image = bounce_harness.run(gl, shaders, picture, settings, sent)
    texel = covered_texels(picture)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame))
    sure = ~samples.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], :3]
    if estimator == "march":
        wanted = screen_space.bounce_solid_angle(
            picture, texel, samples, sent, settings.hidden_senders
        )
        # Sums of 6 terms of pi / 6 times a radiance of up to 1.
        error = np.abs(found - wanted)[sure].max(1) / np.pi
        compare(record, f"{STAGE}: bounce by solid angle", estimator, error, 8.0, "ULP of pi")
        return
    wanted = screen_space.bounce_rgs09(picture, texel, samples, sent, radius, clamp)
    # A form factor is pi / (24 clamp^2) at most; its distance is a difference of positions
    # whose rounding, 6e-8 of z, shows against the clamp: 3 / (0.2 R).
    largest = np.pi / (24.0 * clamp**2) * (1.0 + 3.0 / (clamp * radius))
    error = np.abs(found - wanted)[sure].max(1) / largest
    compare(record, f"{STAGE}: bounce, rgs09", estimator, error, 8.0, "ULP x z / clamp")


@batches(seed=SEEDS, normals_=directions(), radius=numbers(-6, 6), depths=numbers(-3, 3))
def test_tangent_plane(gl, shaders, record, seed, normals_, radius, depths):
    """Which surfaces stand above a receiver's plane: how near a tie rounding decides."""
    rng = np.random.default_rng(seed)
    frame = picture_frame((1280, 720), TAN_Y)
    reach, bias = float(radius.array(1)[0]), 0.01
    texel = np.stack([rng.integers(0, n, COUNT) for n in frame.view.size], 1)
    size, tangents = np.array(frame.view.size), float32(frame.view.tan_half_fov)
    z = depths.array(COUNT)
    ray = np.concatenate([((2 * texel + 1.0) / size - 1.0) * tangents, -np.ones((COUNT, 1))], 1)
    n = normals_.array()
    # Receivers on, near and far from the plane through the surface.
    height = rng.choice([0.0, 1e-6, 1e-3, 1.0], COUNT) * rng.normal(size=COUNT) * z
    p = float32(ray * z[:, None] - height[:, None] * n)
    p[:, 2] = np.minimum(p[:, 2], -1e-3 * z)
    found = evaluate(
        gl, shaders, ["screen_space/occlusion.glsl"],
        "is_above(tangent_at(p, n), vec2(texel) + 0.5, z) ? 1 : 0",
        {"p": p, "n": n, "texel": texel, "z": z}, output_dtype="i4",
        defines={"HAS_BACK_LAYER": 0},
        uniforms={**frame.view.uniforms(), "u_radius": reach, "u_bias": bias, "u_thickness": 0.1},
    )[:, 0]  # fmt: skip
    pq = ray * z[:, None] - p
    height = (pq * n).sum(1)
    depths = 1.0 + z / -p[:, 2]
    relative = float(np.float32(bias)) + screen_space.NORMAL_ERROR * depths
    least = screen_space.DEPTH_ERROR * -p[:, 2] + relative * np.minimum(reach, -p[:, 2])
    margin = np.abs(height - least) / np.maximum(np.abs(p).max(1), np.abs(ray * z[:, None]).max(1))
    wrong = found != (height > least)
    error = margin[wrong].max() / EPSILON if np.any(wrong) else 0.0
    # Two positions of two roundings each, their difference, three products and sums.
    record(f"{STAGE}: above the tangent plane", "is_above", error, 6.0, "ULP of z from a tie")


TERMS = ("emission", "direct_irradiance", "directional_irradiance", "bounce_irradiance")
PIXELS = (320, 313)


@batches(4, seed=SEEDS, light=numbers(-20, 20, (1e-30, 1e30)))
def test_terms_are_added_up(gl, shaders, record, seed, light):
    """emission + albedo / pi * irradiance, of senders and of the picture."""
    shape = (PIXELS[1], PIXELS[0])
    rng = np.random.default_rng(seed)
    frame = picture_frame(PIXELS, TAN_Y)
    images = {
        term: dataclasses.replace(light, seed=seed + i).array(*shape, 4)
        for i, term in enumerate(TERMS)
    }
    albedo = rng.integers(0, 65536, (*shape, 4)) / 65535.0
    albedo[..., 3] = 1.0
    images |= {"z_vs": np.ones((*shape, 1)), "normals_vs": np.full((*shape, 4), 0.5)}
    images |= {"albedo": albedo}
    images["emission"][..., 3] = 1.0
    emission, direct, directional, bounce = (images[term][..., :3] for term in TERMS)
    passes = (
        (
            SenderRadiancePass(SenderTerms(TERMS[1:3], TERMS[:1])),
            emission + albedo[..., :3] / np.pi * (direct + directional),
        ),
        (
            CompositePass("none", TERMS[1:], TERMS[:1]),
            emission + albedo[..., :3] / np.pi * (direct + directional + bounce),
        ),
    )  # fmt: skip
    for item, wanted in passes:
        inputs = {name: images[name] for name in item.reads}
        (found,) = run_pass(gl, shaders, item, frame, inputs).values()
        error = np.abs(found[..., :3] / wanted - 1.0).max() / EPSILON
        # All terms are positive: two sums, two products, one more sum, 1 / pi, albedo.
        record(f"{STAGE}: sum of the terms", item.name, error, 4.0, "ULP")


@batches(4, light=numbers(-12, 12, (0.0, 65504.0)), exposure=st.floats(-8.0, 8.0))
def test_display(gl, shaders, record, light, exposure):
    beauty = light.array(PIXELS[1], PIXELS[0], 4)
    frame = picture_frame(PIXELS, TAN_Y)
    for curve in ("plain", "aces"):
        item = ToneMapPass(ToneMapSettings(curve=curve, exposure=exposure))
        shown = run_pass(gl, shaders, item, frame, {"beauty": beauty})["display"][..., :3]
        x = np.minimum(beauty[..., :3] * 2.0**exposure, 65504.0)
        y = 0.6 * x
        if curve == "aces":
            x = np.clip(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0.0, 1.0)
        x = np.minimum(x, 1.0)
        wanted = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)
        error = np.abs(shown - wanted).max() * 255.0
        # Half a step of 16 bits by rounding to one, and pow() by 1e-6 of 255 steps.
        record(f"{STAGE}: display", curve, error, 0.5 / 257 + 1e-3, "steps of 8 bits")


def filter_twin(picture, value, radius=3, tolerance=0.5):
    """Return the separable filter of an image (h, w, 4), row 0 at the bottom."""
    height, width = picture.z.shape
    texel = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1)
    position = picture.position(texel)
    codes = analytic_pictures.oct_encode(picture.shading) / 65535.0
    plane = (position * picture.geometric).sum(-1)
    footprint = picture.z * 2.0 * picture.tan_half_fov[1] / height
    for axis in (1, 0):
        total, tilted = np.zeros((2, *value.shape))
        weights, first, second = np.zeros((3, *picture.z.shape))
        for i in range(-radius, radius + 1):

            def tap(image, i=i, axis=axis):
                return np.roll(image, -i, axis)

            place = np.arange(picture.z.shape[axis]) + i
            inside = (place >= 0) & (place < picture.z.shape[axis])
            inside = inside[None, :] if axis == 1 else inside[:, None]
            x = ((tap(position) * picture.geometric).sum(-1) - plane) / tolerance
            x = x / np.maximum(footprint, tap(footprint))
            turn = 2.0 * (tap(codes) - codes)
            agree = np.maximum(1.0 - (turn**2).sum(-1) / 0.8**2, 0.0)
            weight = min(min(4, 2 * radius - 2), radius + 1 - abs(i)) * (1.0 + x * x) ** -2.0
            weight = weight * np.maximum(agree**2, 1e-3) * inside
            total += weight[..., None] * tap(value)
            tilted += i * weight[..., None] * tap(value)
            weights += weight
            first += i * weight
            second += i * i * weight
        # What a line through the taps says of the way to their middle is taken off.
        tilt = np.clip(first / np.maximum(second, 1e-30), -1 / (radius + 1), 1 / (radius + 1))
        value = (total - tilt[..., None] * tilted) / (weights - tilt * first)[..., None]
    return value


@batches(4, seed=SEEDS, degrees=st.floats(0.0, 61.0), rough=st.floats(0.0, 0.02))
# The plane ends at a horizon within the picture, where a tap lies 25 times as far as the centre.
@example(seed=0, degrees=60.0, rough=0.0)
@example(seed=1, degrees=60.0, rough=0.02)
def test_edge_aware_filter(gl, shaders, record, seed, degrees, rough):
    rng = np.random.default_rng(seed)
    frame = picture_frame(PIXELS, TAN_Y)
    picture = tilted_plane(degrees, PIXELS, frame.view.tan_half_fov)
    z = float32(picture.z * (1.0 + rough * rng.normal(size=picture.z.shape)))
    z = np.where(z > 0.0, z, 3.0)
    shading = stored(unit(picture.geometric + 0.2 * rng.normal(size=picture.geometric.shape)))
    picture = dataclasses.replace(picture, z=z, shading=shading)
    value = float32(rng.uniform(0.0, 1.0, (*z.shape, 4)))
    found = filter_tests.run(gl, shaders, picture, value)
    error = np.abs(found - filter_twin(picture, value)).max()
    # A tap's height over the plane is a difference of distances from the eye, none of them more
    # than 626 tolerances, of half a footprint of 1 / 313 where the farther is. They are rounded to
    # 4e-5 of a tolerance: weights are off by as much.
    record(f"{STAGE}: edge-aware filter", "separable", error, 1e-4, "of values up to 1")


@batches(4, seed=SEEDS, away=numbers(0, 3), scale=numbers(-6, 6))
def test_depth_and_normals_of_triangles(gl, shaders, record, seed, away, scale):
    """A dozen triangles at any distance and size, in any pose, against rays."""
    rng = np.random.default_rng(seed)
    unit_length, distance = float(scale.array(1)[0]), float(away.array(1)[0])
    corners = rng.normal(size=(12, 3, 3)) * [1.0, 1.0, 0.3]
    corners[..., 2] -= 2.0 + distance
    corners[..., :2] *= 0.3 * (2.0 + distance)
    mesh = Mesh(corners.reshape(-1, 3) * unit_length, np.arange(36).reshape(-1, 3))
    scene = make_scene([mesh], camera=Camera((0, 0, 0), (0, 0, -1), fov_y=60.0))
    frame, images = draw(gl, shaders, scene, PIXELS)
    rays = rays_of(frame).reshape(-1, 3)
    wanted, index, weights = nearest(rays, corners)
    z = images["z_vs"].reshape(-1).astype(float) / unit_length
    # Pixels on an edge may go either way: only those among neighbours of their own
    # triangle count. Slivers thinner than a pixel slip through that.
    around = index.reshape(PIXELS[::-1])
    firm = np.isfinite(wanted) & (weights.min(1) > 1e-3) & (z > 0.0)
    for axis in (0, 1):
        for step in (-1, 1):
            firm &= (np.roll(around, step, axis) == around).ravel()
    face = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))[index]
    cosine = np.abs((face * unit(rays)).sum(1))
    error = np.abs(z / wanted - 1.0) * np.maximum(cosine, 1e-3)
    is_other = error > 1e-4
    share = float(np.mean(is_other[firm]))
    record("pixels that show another triangle", "gbuffer", share, 1e-3, "share")
    firm &= ~is_other
    record(
        f"{STAGE}: depth of triangles", "gbuffer", error[firm].max() / EPSILON, 8.0,
        "ULP x cos",
    )  # fmt: skip
    _, geometric = (image.reshape(-1, 3) for image in normals(images))
    angle = np.linalg.norm(np.cross(geometric, face), axis=1)[firm].max()
    # 16 + 16 octahedral bits.
    record(f"{STAGE}: normals of triangles", "gbuffer", np.degrees(angle), 0.004, "degrees")

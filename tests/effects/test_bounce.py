"""The bounce against its float64 twin, closed forms and energy."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from effects.bounce_harness import (
    CORNER_RADIUS,
    CORNER_SIZE,
    CORNER_TAN,
    ESTIMATORS,
    colors,
    ones,
    run,
    the_corner,
)
from oracle import closed_forms, screen_space, slices
from passes.estimator_cases import (
    SIZE,
    SUM_TOLERANCE,
    TAN_Y,
    corner,
    covered_texels,
    inputs_of,
    noise,
    picture_frame,
    positions,
    run_on,
    twin_of,
)
from passes.pass_harness import run_pass

from ssdo_gl.effects.bounce import BouncePass, BounceSettings
from ssdo_gl.effects.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment

# As for visibility in a corner, times pi.
CORNER_TOLERANCE = math.pi * 0.011


@pytest.mark.parametrize("has_back, hidden", [(False, 0.0), (True, 0.25)])
def test_march_matches_the_twin_on_noise(gl, shaders, has_back, hidden):
    settings = BounceSettings(
        radius=0.8, samples=24, steps=4, refine_steps=0, hidden_senders=hidden
    )
    picture = noise(has_back=has_back)
    sent = colors(picture)
    image = run(gl, shaders, picture, settings, sent, has_back=has_back)
    texel = covered_texels(picture)
    frame = picture_frame(SIZE, TAN_Y)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame, has_back))
    expected = screen_space.bounce_solid_angle(picture, texel, samples, sent, hidden)
    sure = ~samples.unsure.any(1)
    assert sure.mean() > 0.97
    found = image[texel[:, 1], texel[:, 0], :3]
    np.testing.assert_allclose(found[sure], expected[sure], atol=math.pi * SUM_TOLERANCE)
    assert expected.max() > 1.0


@pytest.mark.parametrize("has_back, hidden", [(False, 0.0), (True, 0.25)])
def test_bitmask_matches_the_twin_on_noise(gl, shaders, has_back, hidden):
    """Each of a slice's 32 directions receives from the nearest that hides it."""
    settings = BounceSettings(
        estimator="bitmask", radius=0.8, samples=24, steps=4, hidden_senders=hidden
    )
    picture = noise(has_back=has_back)
    sent = colors(picture)
    image = run(gl, shaders, picture, settings, sent, has_back=has_back)
    texel = covered_texels(picture)
    twin = twin_of(settings, picture_frame(SIZE, TAN_Y), has_back)
    r, sectors = slices.find_sectors(picture, texel, texel, twin)
    expected = slices.bounce_sectors(picture, r, sectors, sent, hidden)
    sure = ~sectors.unsure.any(1)
    assert sure.mean() > 0.97
    found = image[texel[:, 1], texel[:, 0], :3]
    # Weights of slices are sines and cosines of sums.
    np.testing.assert_allclose(found[sure], expected[sure], atol=math.pi * 2 * SUM_TOLERANCE)
    assert expected.max() > 1.0


def test_rgs09_matches_the_twin_on_noise(gl, shaders):
    """A_s cos cos / d^2 with A_s = pi R^2 / N and d of at least a part of R."""
    settings = BounceSettings(estimator="rgs09", radius=0.8, samples=24, distance_clamp=0.2)
    picture = noise()
    sent = colors(picture)
    image = run(gl, shaders, picture, settings, sent)
    texel = covered_texels(picture)
    samples = screen_space.sample(
        picture, texel, texel, twin_of(settings, picture_frame(SIZE, TAN_Y))
    )
    expected = screen_space.bounce_rgs09(picture, texel, samples, sent, 0.8, 0.2)
    sure = ~samples.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], :3]
    # Form factors reach pi / (N 0.2^2) and are products of float32 normals.
    np.testing.assert_allclose(found[sure], expected[sure], rtol=1e-4, atol=1e-4)
    assert expected.max() > 1.0


def corner_rows(image):
    """Mean over the middle columns of the floor's rows, and k = d / R of the rows."""
    rows = np.arange(24, 48)
    d = np.linalg.norm(positions(the_corner())[rows, 80] - [0.0, 0.0, -3.0], axis=1)
    return image[rows][:, 48:112].mean(1), d / CORNER_RADIUS


def of_blocks(values):
    return np.asarray(values).reshape(-1, 4, *np.shape(values)[1:]).mean(1)


@pytest.mark.parametrize("scale", [0.01, 1.0, 100.0])
def test_lit_corner_gets_the_light_of_its_wall(gl, shaders, scale):
    """A closed form: a wall of radiance 1 within R sends pi A1 = seg(k), at any scale."""
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    picture = corner(CORNER_SIZE, frame.view.tan_half_fov, scale)
    settings = BounceSettings(
        radius=CORNER_RADIUS * scale, samples=512, steps=8, thickness=np.inf, front_slack=0.0
    )
    image = run(gl, shaders, picture, settings, ones(picture, (1.0, 0.5, 0.25)))
    found, k = corner_rows(image)
    expected = np.where(k < 1.0, closed_forms.disk_segment_area(np.minimum(k, 1.0)), 0.0)
    for channel, radiance in enumerate((1.0, 0.5, 0.25)):
        np.testing.assert_allclose(
            of_blocks(found[:, channel]), radiance * of_blocks(expected), atol=CORNER_TOLERANCE
        )


def test_refining_finds_the_part_of_the_wall_that_sends(gl, shaders):
    """A wall that brightens with height: the step that is found blocked lies behind the
    wall, and projects to a place above the one that the ray meets."""
    picture = the_corner()
    c = np.sqrt(0.5)
    height = np.maximum((positions(picture) - [0.0, 0.0, -3.0]) @ [0.0, c, c], 0.0)
    sent = height[..., None] / CORNER_RADIUS * np.ones(3)
    w = screen_space.cosine_hemisphere(
        screen_space.kronecker_points(np.arange(1 << 14), (0, 0, 0))[:, :2]
    )
    errors = []
    for refine in (0, 4):
        settings = BounceSettings(
            radius=CORNER_RADIUS,
            samples=512,
            steps=8,
            thickness=np.inf,
            front_slack=0.0,
            refine_steps=refine,
        )
        found, k = corner_rows(run(gl, shaders, picture, settings, sent))
        with np.errstate(divide="ignore"):
            met = np.where(w[:, 0] > k[:, None], k[:, None] / w[:, 0] * w[:, 2], 0.0)
        expected = np.pi * met.mean(1)
        errors.append(np.abs(of_blocks(found[:, 0]) - of_blocks(expected)).max())
    # What is left is half a texel of height, .02, times up to pi / 2, and the
    # directions' error. Measured .037, and .10 without refining.
    assert errors[1] < 0.045
    assert errors[1] < 0.5 * errors[0]


def test_rgs09_has_its_own_expectation_in_the_corner(gl, shaders):
    """The mean of A_s cos cos / d^2 over the points that the wall hides from the floor."""
    settings = BounceSettings(
        estimator="rgs09", radius=CORNER_RADIUS, samples=512, distance_clamp=0.3
    )
    picture = the_corner()
    found, k = corner_rows(run(gl, shaders, picture, settings, ones(picture)))
    u = screen_space.kronecker_points(np.arange(1 << 15), (0, 0, 0))
    points = screen_space.uniform_hemisphere(u[:, :2]) * u[:, 2:]
    # Floor (0, c, c), wall (0, -c, c), camera along z: a hidden point is seen at the
    # place where its line of sight, along (0, 0, 1), meets the wall: x, y of room space
    # (away from the wall, up) change alike.
    expected = []
    for q in k:
        behind = points[:, 0] - q
        on_wall = np.stack([np.full(len(points), q), points[:, 1], points[:, 2] + behind], 1)
        d = np.linalg.norm(on_wall, axis=1)
        cosines = on_wall[:, 2] / d * on_wall[:, 0] / d
        form = np.pi * cosines / np.maximum(d, 0.3) ** 2
        expected.append(np.where(behind > 0.0, form, 0.0).mean())
    # The line of sight is not quite parallel over this narrow view: 3 %.
    np.testing.assert_allclose(
        of_blocks(found[:, 0]), of_blocks(expected), atol=CORNER_TOLERANCE, rtol=0.03
    )


@pytest.mark.parametrize("is_half", [False, True])
def test_senders_added_up_where_they_are_asked_are_those_of_the_image(gl, shaders, is_half):
    picture = noise()
    rng = np.random.default_rng(2)
    step = 2 if is_half else 1
    images = {
        "albedo": rng.random((*picture.z.shape, 4)),
        "emission": rng.random((*picture.z.shape, 4)),
        "direct_irradiance": rng.random((*picture.z.shape, 4)),
        "directional_raw": rng.random((*picture.z[::step, ::step].shape, 4)),
    }
    terms = SenderTerms(("direct_irradiance", "directional_raw"), ("emission",))
    frame = picture_frame(SIZE, TAN_Y)
    settings = BounceSettings(samples=16, steps=4, radius=0.8)
    senders = run_pass(gl, shaders, SenderRadiancePass(terms), frame, images)
    items = BouncePass(settings), BouncePass(settings, terms=terms)
    assert "sender_radiance" not in items[1].reads
    inputs = {**inputs_of(picture), **images, **senders}
    looked_up, added_up = (
        run_pass(gl, shaders, item, frame, {name: inputs[name] for name in item.reads})
        for item in items
    )
    np.testing.assert_array_equal(added_up["bounce_raw"], looked_up["bounce_raw"])
    assert looked_up["bounce_raw"][..., :3].max() > 0.1


def test_a_sender_is_known_to_a_sixteenth_of_the_radius_whatever_the_steps():
    def found(steps, **more):
        return BounceSettings(samples=64, steps=steps, **more).refinements

    assert [found(steps) for steps in (2, 4, 7, 8, 15, 16, 64)] == [2, 2, 2, 1, 1, 0, 0]
    assert found(64, refine_steps=3) == 3 and found(4, refine_steps=0) == 0


@pytest.mark.parametrize("refine", [0, 2])
def test_furnace_is_exact_per_pixel(gl, shaders, refine):
    """Sky of radiance 1, senders of radiance 1: whatever is open or blocked, E = pi."""
    frame = picture_frame(CORNER_SIZE, CORNER_TAN, environment=ConstantEnvironment((1.0,) * 3))
    picture = the_corner()
    more = {"samples": 64, "steps": 8, "radius": CORNER_RADIUS, "thickness": np.inf}
    directional = run_on(
        gl,
        shaders,
        DirectionalPass(DirectionalSettings(**more), environment="constant"),
        frame,
        picture,
    )
    bounce = run(gl, shaders, picture, BounceSettings(refine_steps=refine, **more), ones(picture))
    total = directional[..., :3] + bounce[..., :3]
    np.testing.assert_allclose(total, np.pi, rtol=SUM_TOLERANCE)
    assert directional[..., 3].min() < 0.6


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_unlit_is_exactly_dark(gl, shaders, estimator):
    settings = BounceSettings(estimator=estimator, radius=0.8)
    image = run(gl, shaders, noise(), settings, 0.0 * ones(noise()))
    assert np.all(image[..., :3] == 0.0)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_linear_in_light(gl, shaders, estimator):
    settings = BounceSettings(estimator=estimator, radius=0.8)
    sent = colors(noise())
    once = run(gl, shaders, noise(), settings, sent)[..., :3]
    np.testing.assert_array_equal(
        run(gl, shaders, noise(), settings, 4.0 * sent)[..., :3], 4.0 * once
    )
    strong = dataclasses.replace(settings, strength=2.0)
    np.testing.assert_array_equal(run(gl, shaders, noise(), strong, sent)[..., :3], 2.0 * once)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_power_of_two_scale_changes_nothing(gl, shaders, estimator):
    picture = noise(has_back=True)
    settings = BounceSettings(estimator=estimator, radius=0.8)
    sent = colors(picture)
    reference = run(gl, shaders, picture, settings, sent, has_back=True)[..., :3]
    for scale in (2.0**-10, 2.0**13):
        scaled = dataclasses.replace(
            picture, z=picture.z * scale, z_back=picture.z_back * scale, near=picture.near * scale
        )
        resized = dataclasses.replace(settings, radius=0.8 * scale)
        found = run(gl, shaders, scaled, resized, sent, has_back=True)[..., :3]
        np.testing.assert_array_equal(found, reference)

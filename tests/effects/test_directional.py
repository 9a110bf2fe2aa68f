"""Light through open directions: the environment, exact totals, invariants."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import screen_space, slices
from passes.estimator_cases import (
    LAMP,
    SIZE,
    SKY,
    SUM_TOLERANCE,
    TAN_Y,
    covered_texels,
    noise,
    picture_frame,
    plane,
    run_directional,
    twin_of,
)

from ssdo_gl.effects.directional import DirectionalSettings
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.lights import DirectionalLight, PointLight

POINT = PointLight((0.3, 0.4, -2.5), (1.0, 2.0, 3.0), shadow="ssdo")
SUN = DirectionalLight((0.0, -0.6, -0.8), (1.0, 2.0, 3.0), shadow="ssdo")


def gradient_irradiance(normals):
    """Integral of SKY over the cosine-weighted hemisphere, by many directions."""
    directions = screen_space.cosine_hemisphere(
        screen_space.kronecker_points(np.arange(1 << 14), (1, 2, 3))[:, :2]
    )
    frames = screen_space.frame_from_z(normals)
    return np.array([np.pi * SKY.sample(directions @ f.T).mean(0) for f in frames])


# Quadrature by 2^14 points of integrands with a kink at the horizon.
QUADRATURE_TOLERANCE = 3e-4


# --- environment ----------------------------------------------------------------------


@pytest.mark.parametrize("radius", [0.0, 0.5, np.inf])
def test_constant_environment_is_visibility_times_pi(gl, shaders, radius):
    """The white furnace: E = pi L V to the last bit, whatever blocks what."""
    settings = DirectionalSettings(radius=radius, samples=32, steps=4)
    radiance = np.array([0.25, 1.0, 3.0], np.float32)
    image = run_directional(
        gl, shaders, noise(), settings, environment=ConstantEnvironment((0.25, 1.0, 3.0))
    )
    covered = noise().z > 0.0
    expected = np.float32(np.pi) * radiance * image[..., 3:]
    np.testing.assert_allclose(image[covered][:, :3], expected[covered], rtol=2.4e-7)
    assert (image[covered][:, 3] < 1.0).any() == (radius > 0.0)


@pytest.mark.parametrize("control", ["subtract", "ratio"])
@pytest.mark.parametrize("degrees", [0.0, 60.0, 89.9])
def test_open_plane_gets_the_exact_irradiance(gl, shaders, control, degrees):
    """No sampling noise where nothing is blocked, with two directions as with many."""
    settings = DirectionalSettings(radius=0.5, samples=8, steps=4, control=control)
    picture = plane(degrees)
    image = run_directional(gl, shaders, picture, settings, environment=SKY)
    assert np.all(image[..., 3] == 1.0)
    lit = image[picture.z > 0.0][:, :3]
    np.testing.assert_allclose(lit, np.broadcast_to(lit[0], lit.shape), rtol=1e-6)
    expected = gradient_irradiance(picture.shading[picture.z > 0.0][:1])[0]
    np.testing.assert_allclose(lit[0], expected, rtol=QUADRATURE_TOLERANCE)


@pytest.mark.parametrize("control", ["none", "subtract", "ratio"])
def test_gradient_matches_the_twin(gl, shaders, control):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4, control=control)
    picture = noise(has_back=True)
    image = run_directional(gl, shaders, picture, settings, environment=SKY, has_back=True)
    texel = covered_texels(picture)[::7]
    frame = picture_frame(SIZE, TAN_Y)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame, True))
    light = samples.share[..., None] * SKY.sample(samples.w)
    everything = light.sum(1)
    open_light = (light * ~samples.blocked[..., None]).sum(1)
    exact = gradient_irradiance(picture.shading[texel[:, 1], texel[:, 0]])
    if control == "none":
        expected = np.pi * open_light
    elif control == "subtract":
        expected = np.maximum(exact - np.pi * (everything - open_light), 0.0)
    else:
        one = exact.sum(1) / np.pi / samples.share.shape[1]
        c = (open_light.sum(1) + one * screen_space.visibility(samples)) / (everything.sum(1) + one)
        expected = c[:, None] * exact + np.pi * (open_light - c[:, None] * everything)
        expected = np.maximum(expected, 0.0)
    sure = ~samples.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], :3]
    np.testing.assert_allclose(found[sure], expected[sure], atol=np.pi * 2.0 * QUADRATURE_TOLERANCE)


@pytest.mark.parametrize("control", ["none", "subtract"])
def test_gradient_by_slices_matches_the_twin(gl, shaders, control):
    """Each slice is looked up in four parts, which are open as far as their bits are."""
    settings = DirectionalSettings(
        estimator="bitmask", radius=0.6, samples=32, steps=4, control=control
    )
    picture = noise(has_back=True)
    image = run_directional(gl, shaders, picture, settings, environment=SKY, has_back=True)
    texel = covered_texels(picture)[::7]
    twin = twin_of(settings, picture_frame(SIZE, TAN_Y), True)
    r, sectors = slices.find_sectors(picture, texel, texel, twin)
    w, share, is_open = slices.sky_parts(r, sectors)
    light = share[..., None] * SKY.sample(w)
    open_light = np.pi * (light * is_open[..., None]).sum((1, 2))
    exact = gradient_irradiance(picture.shading[texel[:, 1], texel[:, 0]])
    blocked = np.pi * light.sum((1, 2)) - open_light
    expected = open_light if control == "none" else np.maximum(exact - blocked, 0.0)
    sure = ~sectors.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], :3]
    np.testing.assert_allclose(found[sure], expected[sure], atol=np.pi * 2.0 * QUADRATURE_TOLERANCE)
    visibility = 1.0 - (sectors.share * sectors.hidden.sum(2)).sum(1)
    np.testing.assert_allclose(
        image[texel[:, 1], texel[:, 0], 3][sure], visibility[sure], atol=2 * SUM_TOLERANCE
    )


def test_rgs09_sums_the_open_light_as_printed(gl, shaders):
    """Uniform directions, each 2 pi / N wide; nothing corrects the sum."""
    settings = DirectionalSettings(estimator="rgs09", radius=0.6, samples=16)
    picture = noise()
    image = run_directional(
        gl, shaders, picture, settings, environment=ConstantEnvironment((1.0, 1.0, 1.0))
    )
    texel = covered_texels(picture)
    frame = picture_frame(SIZE, TAN_Y)
    samples = screen_space.sample(picture, texel, texel, twin_of(settings, frame))
    axis = picture.shading[texel[:, 1], texel[:, 0]]
    cosines = samples.share * 16 / 2.0
    assert np.einsum("ndi,ni->nd", samples.w, axis).shape == cosines.shape
    expected = (cosines * ~samples.blocked).sum(1) * (2.0 * np.pi / 16)
    sure = ~samples.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], 0]
    np.testing.assert_allclose(found[sure], expected[sure], atol=np.pi * SUM_TOLERANCE)


def map_textures(radiance, irradiance):
    """A lat-long map and an octahedral irradiance map, rows as they lie in memory."""
    shape = np.asarray(radiance).shape
    image = np.concatenate([np.asarray(radiance), np.ones((*shape[:2], 1))], -1)
    e = np.full((9, 9, 4), irradiance)  # of odd size: the axes are rows of texels
    return {"environment": image, "environment_irradiance": e}


@pytest.mark.parametrize("control", ["ratio", "subtract"])
def test_a_sun_in_the_map_stays_between_nothing_and_everything(gl, shaders, control):
    """One texel of 1e6: a direction that meets it must not exceed what there is."""
    radiance = np.ones((16, 32, 3))
    radiance[4, 7] = 1e6
    total = 4.0e4  # about the irradiance of that sun; exactness is another test's matter
    picture = noise()
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4, control=control)
    environment = MapEnvironment(np.asarray(radiance, np.float32))
    image = run_directional(
        gl,
        shaders,
        picture,
        settings,
        environment=environment,
        more=map_textures(radiance, total),
    )
    assert np.all(np.isfinite(image))
    assert np.all(image[..., :3] >= 0.0)
    # The ratio counts one direction more than were drawn, at the hemisphere's visibility.
    assert np.all(image[..., :3] <= total * (1.0 + 1.0 / settings.direction_count))


def test_map_without_features_equals_a_constant(gl, shaders):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4)
    radiance = np.full((8, 16, 3), 2.0)
    image = run_directional(
        gl,
        shaders,
        noise(),
        settings,
        environment=MapEnvironment(np.asarray(radiance, np.float32)),
        more=map_textures(radiance, 2.0 * np.pi),
    )
    constant = run_directional(
        gl, shaders, noise(), settings, environment=ConstantEnvironment((2.0,) * 3)
    )
    np.testing.assert_allclose(image, constant, atol=2.0 * np.pi * SUM_TOLERANCE)


# --- invariants -----------------------------------------------------------------------


@pytest.mark.parametrize("estimator", ["march", "rgs09", "bitmask"])
def test_unlit_is_exactly_dark(gl, shaders, estimator):
    settings = DirectionalSettings(estimator=estimator, radius=1.0)
    image = run_directional(gl, shaders, noise(), settings)
    assert np.all(image[..., :3] == 0.0)


@pytest.mark.parametrize("estimator", ["march", "rgs09", "bitmask"])
def test_linear_in_light(gl, shaders, estimator):
    """Doubling every light doubles every float exactly."""
    settings = DirectionalSettings(estimator=estimator, radius=0.6, samples=32, steps=4)
    picture = noise()

    def twice(values):
        return tuple(2.0 * v for v in values)

    bright = GradientEnvironment(twice(SKY.zenith), twice(SKY.horizon), twice(SKY.ground))
    lamp = dataclasses.replace(LAMP, radiance=twice(LAMP.radiance))
    once = run_directional(gl, shaders, picture, settings, environment=SKY, lights=(LAMP,))
    double = run_directional(gl, shaders, picture, settings, environment=bright, lights=(lamp,))
    np.testing.assert_array_equal(double[..., :3], 2.0 * once[..., :3])
    np.testing.assert_array_equal(double[..., 3], once[..., 3])


def test_two_lights_add_up(gl, shaders):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4)
    picture = noise()
    parts = [
        run_directional(gl, shaders, picture, settings, environment=SKY),
        run_directional(gl, shaders, picture, settings, lights=(LAMP,)),
        run_directional(gl, shaders, picture, settings, lights=(POINT,)),
    ]
    together = run_directional(
        gl, shaders, picture, settings, environment=SKY, lights=(LAMP, POINT)
    )
    np.testing.assert_allclose(
        together[..., :3], sum(p[..., :3] for p in parts), rtol=1e-5, atol=1e-5
    )


def test_hemisphere_is_left_out_when_nobody_needs_it(gl, shaders):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4)
    with_it = run_directional(gl, shaders, noise(), settings, lights=(LAMP,))
    without = run_directional(
        gl, shaders, noise(), settings, lights=(LAMP,), needs_visibility=False
    )
    np.testing.assert_array_equal(without[..., :3], with_it[..., :3])
    assert np.all(without[..., 3] == 1.0)
    assert with_it[..., 3].min() < 1.0


def test_lights_of_other_kinds_are_left_to_direct(gl, shaders):
    settings = DirectionalSettings(radius=0.6)
    lights = tuple(dataclasses.replace(light, shadow="map") for light in (LAMP, POINT, SUN))
    assert np.all(run_directional(gl, shaders, plane(), settings, lights=lights)[..., :3] == 0.0)


def test_background_is_dark_and_open(gl, shaders):
    picture = noise()
    image = run_directional(gl, shaders, picture, DirectionalSettings(radius=1.0), environment=SKY)
    sky = picture.z == 0.0
    assert sky.any()
    np.testing.assert_array_equal(image[sky], np.broadcast_to([0, 0, 0, 1], image[sky].shape))

"""Light through open directions: exact totals, blocked light, lights of every kind."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import closed_forms, screen_space
from passes.estimator_cases import (
    corner,
    covered_texels,
    picture_frame,
    positions,
    random_picture,
    run_on,
    tilted_plane,
    twin_of,
)

from ssdo_gl.passes.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    Environment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.light import DirectionalLight, Light, PointLight, RectangleLight, SpotLight

SIZE = (48, 36)
TAN_Y = 0.5
# Sums of some 16 float32 terms of one size.
SUM_TOLERANCE = 2e-6
SKY = GradientEnvironment((0.5, 1.0, 2.0), (1.0, 0.75, 0.5), (0.1, 0.2, 0.3))
# Overhead and to the left of a floor that lies 3 below the camera's axis and beyond.
LAMP = RectangleLight((-0.5, 1.0, -4.0), (0.0, 0.0, 1.5), (-1.0, 0.5, 0.0), (3.0, 2.0, 1.0), "ssdo")


def run(
    gl,
    shaders,
    picture,
    settings,
    *,
    environment: Environment | None = None,
    lights: tuple[Light, ...] = (),
    has_back=False,
    more=None,
    **keywords,
):
    size = picture.z.shape[1], picture.z.shape[0]
    frame = picture_frame(
        size, picture.tan_half_fov[1], near=picture.near, environment=environment, lights=lights
    )
    kinds = {
        type(None): "none",
        ConstantEnvironment: "constant",
        GradientEnvironment: "gradient",
        MapEnvironment: "map",
    }
    render_pass = DirectionalPass(
        settings, environment=kinds[type(environment)], has_back_layer=has_back, **keywords
    )
    return run_on(gl, shaders, render_pass, frame, picture, more)


def noise(seed=3, has_back=False):
    return random_picture(seed, SIZE, picture_frame(SIZE, TAN_Y).view.tan_half_fov, has_back)


def plane(degrees=40.0):
    return tilted_plane(degrees, SIZE, picture_frame(SIZE, TAN_Y).view.tan_half_fov)


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
    image = run(gl, shaders, noise(), settings, environment=ConstantEnvironment((0.25, 1.0, 3.0)))
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
    image = run(gl, shaders, picture, settings, environment=SKY)
    assert np.all(image[..., 3] == 1.0)
    lit = image[picture.z > 0.0][:, :3]
    np.testing.assert_allclose(lit, np.broadcast_to(lit[0], lit.shape), rtol=1e-6)
    expected = gradient_irradiance(picture.shading[picture.z > 0.0][:1])[0]
    np.testing.assert_allclose(lit[0], expected, rtol=QUADRATURE_TOLERANCE)


@pytest.mark.parametrize("control", ["none", "subtract", "ratio"])
def test_gradient_matches_the_twin(gl, shaders, control):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4, control=control)
    picture = noise(has_back=True)
    image = run(gl, shaders, picture, settings, environment=SKY, has_back=True)
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
        c = (open_light.sum(1) + one * screen_space.visibility(samples)) / (
            everything.sum(1) + one
        )
        expected = c[:, None] * exact + np.pi * (open_light - c[:, None] * everything)
        expected = np.maximum(expected, 0.0)
    sure = ~samples.unsure.any(1)
    found = image[texel[:, 1], texel[:, 0], :3]
    np.testing.assert_allclose(
        found[sure], expected[sure], atol=np.pi * 2.0 * QUADRATURE_TOLERANCE
    )


def test_rgs09_sums_the_open_light_as_printed(gl, shaders):
    """Uniform directions, each 2 pi / N wide; nothing corrects the sum."""
    settings = DirectionalSettings(estimator="rgs09", radius=0.6, samples=16)
    picture = noise()
    image = run(gl, shaders, picture, settings, environment=ConstantEnvironment((1.0, 1.0, 1.0)))
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
    image = run(
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
    image = run(
        gl,
        shaders,
        noise(),
        settings,
        environment=MapEnvironment(np.asarray(radiance, np.float32)),
        more=map_textures(radiance, 2.0 * np.pi),
    )
    constant = run(gl, shaders, noise(), settings, environment=ConstantEnvironment((2.0,) * 3))
    np.testing.assert_allclose(image, constant, atol=2.0 * np.pi * SUM_TOLERANCE)


# --- rectangles -----------------------------------------------------------------------


def lambert(light, point, normal):
    """Irradiance of a rectangle light by Lambert's formula, all of it above the horizon."""
    c, u, v = (np.asarray(x) for x in (light.corner, light.edge_u, light.edge_v))
    corners = np.array([c, c + v, c + u + v, c + u]) - point
    factor = closed_forms.rectangle_form_factor(corners, normal)
    return np.pi * max(factor, 0.0) * np.asarray(light.radiance)


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_rectangle_lights_an_open_floor(gl, shaders, estimator):
    picture = plane(55.0)
    settings = DirectionalSettings(estimator=estimator, radius=0.5, samples=4096 // 16, steps=4)
    # Above the plane's middle, facing it.
    n = picture.geometric[18, 24]
    middle = positions(picture)[18, 24]
    u = np.cross(n, [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    v = np.cross(u, n)  # so that u x v = -n: it faces the plane
    corner_ = middle + 0.7 * n - 0.4 * u - 0.3 * v
    light = RectangleLight(tuple(corner_), tuple(0.8 * u), tuple(0.6 * v), (3.0, 2.0, 1.0), "ssdo")
    assert np.cross(light.edge_u, light.edge_v) @ n < 0.0
    image = run(gl, shaders, picture, settings, lights=(light,))
    expected = lambert(light, middle, n)
    if estimator == "march":
        np.testing.assert_allclose(image[18, 24, :3], expected, rtol=1e-5)
        # Everywhere but at the horizon: none of it is blocked.
        assert image[(picture.z > 0.0) & (picture.z < 6.0)][:, :3].min() > 0.0
    else:
        # The paper's directions meet it by chance: 16 sets of 256 around the middle.
        points = positions(picture)[16:20, 22:26].reshape(-1, 3)
        block = np.array([lambert(light, point, n) for point in points])
        found = image[16:20, 22:26, :3].mean((0, 1))
        np.testing.assert_allclose(found, block.mean(0), rtol=0.02)
    turned = dataclasses.replace(light, edge_u=light.edge_v, edge_v=light.edge_u)
    assert np.all(run(gl, shaders, picture, settings, lights=(turned,))[..., :3] == 0.0)
    both = dataclasses.replace(turned, two_sided=True)
    again = run(gl, shaders, picture, settings, lights=(both,))
    np.testing.assert_allclose(again[18, 24, :3], image[18, 24, :3], rtol=1e-5)


def test_rectangle_matches_the_twin_on_noise(gl, shaders):
    """The share that arrives is a weighted mean over directions aimed at the lamp."""
    lamp = dataclasses.replace(LAMP, two_sided=True)
    settings = DirectionalSettings(radius=1.0, samples=32, steps=4)
    picture = noise()
    lit = run(gl, shaders, picture, settings, lights=(lamp,))[..., 0]
    unoccluded = run(gl, shaders, picture, settings, lights=(lamp,), is_open=True)[..., 0]
    texel = covered_texels(picture)
    twin = twin_of(settings, picture_frame(SIZE, TAN_Y))
    edges = (np.asarray(x) for x in (lamp.corner, lamp.edge_u, lamp.edge_v))
    share, unsure = screen_space.rectangle_visibility(picture, texel, twin, *edges)
    exact = unoccluded[texel[:, 1], texel[:, 0]]
    use = (exact > 0.0) & ~unsure.any(1)
    assert use.sum() > 300
    assert 0.2 < share[use].mean() < 0.8
    found = lit[texel[:, 1], texel[:, 0]][use] / exact[use]
    np.testing.assert_allclose(found, share[use], atol=20 * SUM_TOLERANCE)


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_wall_within_reach_takes_a_rectangle_s_light(gl, shaders, estimator):
    """The lamp stands behind the wall: dark where every ray meets the wall within R."""
    frame = picture_frame((64, 64), 0.25)
    picture = corner((64, 64), frame.view.tan_half_fov)
    c = np.sqrt(0.5)
    behind = np.array([0.0, 0.0, -3.0]) - 0.3 * np.array([0.0, -c, c])
    up = np.array([0.0, c, c])
    light = RectangleLight(
        tuple(behind + 0.05 * up - [0.2, 0.0, 0.0]),
        tuple(0.2 * up),
        (0.4, 0.0, 0.0),
        (3.0, 2.0, 1.0),
        "ssdo",
        two_sided=True,
    )
    settings = DirectionalSettings(
        estimator=estimator, radius=2.0, samples=256, steps=8, thickness=np.inf
    )
    floor = np.arange(4, 32)
    image = run(gl, shaders, picture, settings, lights=(light,))
    if estimator == "march":
        assert np.all(image[floor, 8:56, :3] == 0.0)
    short = run(gl, shaders, picture, dataclasses.replace(settings, radius=0.02), lights=(light,))
    lit = short[floor, 8:56, 0].mean()
    assert lit > 0.05
    # One point per direction finds some of the wall.
    assert image[floor, 8:56, 0].mean() < 0.9 * lit


def test_visible_lamp_nearer_than_r_does_not_block_itself(gl, shaders):
    """The lamp is in the depth buffer: its own surface ends every ray that is aimed at it."""
    frame = picture_frame((64, 64), 0.4)
    c = np.sqrt(0.5)
    picture = corner((64, 64), frame.view.tan_half_fov)
    # The wall itself shines.
    up, normal = np.array([0.0, c, c]), np.array([0.0, -c, c])
    start = np.array([-0.3, 0.0, -3.0]) + 0.1 * up
    light = RectangleLight(
        tuple(start), (0.6, 0.0, 0.0), tuple(0.4 * up), (1.0, 1.0, 1.0), "ssdo"
    )
    assert np.cross(light.edge_u, light.edge_v) @ normal > 0.0
    settings = DirectionalSettings(radius=3.0, samples=128, steps=8)
    image = run(gl, shaders, picture, settings, lights=(light,))
    for row, column in ((20, 32), (28, 10), (5, 50)):
        point = positions(picture)[row, column]
        expected = lambert(light, point, np.array([0.0, c, c]))
        # Stored normals are off by up to 6.5e-5 rad, and the lamp stands low.
        np.testing.assert_allclose(image[row, column, :3], expected, rtol=5e-4)


# --- points, spots, directional lights ----------------------------------------------------

POINTS: tuple[Light, ...] = (
    PointLight((0.3, 0.4, -2.5), (1.0, 2.0, 3.0), "ssdo"),
    SpotLight((0.3, 0.4, -2.5), (0.0, 0.0, -1.0), (1.0, 2.0, 3.0), 20.0, 60.0, "ssdo"),
    DirectionalLight((0.0, -0.6, -0.8), (1.0, 2.0, 3.0), "ssdo"),
)


def analytic(light, point, normal):
    if isinstance(light, DirectionalLight):
        cosine = max(-np.asarray(light.direction) @ normal, 0.0)
        return cosine * np.asarray(light.irradiance)
    to_light = np.asarray(light.position) - point
    d = np.linalg.norm(to_light)
    w = to_light / d
    factor = max(w @ normal, 0.0) / d**2
    if isinstance(light, SpotLight):
        inner, outer = np.cos(np.radians([light.inner_angle, light.outer_angle]))
        factor *= np.clip((-w @ np.asarray(light.direction) - outer) / (inner - outer), 0, 1) ** 2
    return factor * np.asarray(light.intensity)


@pytest.mark.parametrize("light", POINTS, ids=lambda light: type(light).__name__)
def test_point_lights_reach_an_open_plane(gl, shaders, light):
    picture = plane(20.0)
    settings = DirectionalSettings(radius=1.0, samples=8)
    image = run(gl, shaders, picture, settings, lights=(light,))
    for y, x in ((18, 24), (5, 40), (30, 3)):
        expected = analytic(light, positions(picture)[y, x], picture.shading[y, x])
        np.testing.assert_allclose(image[y, x, :3], expected, rtol=1e-5, atol=1e-6)


def test_shadow_of_a_wall_ends_at_r(gl, shaders):
    """Light from behind the wall, just above the floor: dark up to R / cos from it."""
    frame = picture_frame((64, 64), 0.25)
    picture = corner((64, 64), frame.view.tan_half_fov)
    c = np.sqrt(0.5)
    normal = np.array([0.0, -c, c])  # of the wall
    sun = DirectionalLight(
        tuple(0.8 * normal - 0.6 * np.array([0.0, c, c])), (1.0, 1.0, 1.0), "ssdo"
    )
    settings = DirectionalSettings(radius=0.25, light_steps=32, thickness=np.inf, front_slack=0.0)
    image = run(gl, shaders, picture, settings, lights=(sun,))
    away = (positions(picture) - [0.0, 0.0, -3.0]) @ normal
    floor = np.arange(64) < 32
    dark = away[:, 32] < 0.8 * 0.25 - 0.03
    lit = away[:, 32] > 0.8 * 0.25 + 0.03
    assert np.all(image[floor & dark][:, 8:56, 0] == 0.0)
    # Stored normals are off by up to 6.5e-5 rad.
    np.testing.assert_allclose(image[floor & lit][:, 8:56, 0], 0.6, rtol=1e-4)


# --- invariants -----------------------------------------------------------------------


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_unlit_is_exactly_dark(gl, shaders, estimator):
    settings = DirectionalSettings(estimator=estimator, radius=1.0)
    image = run(gl, shaders, noise(), settings)
    assert np.all(image[..., :3] == 0.0)


@pytest.mark.parametrize("estimator", ["march", "rgs09"])
def test_linear_in_light(gl, shaders, estimator):
    """Doubling every light doubles every float exactly."""
    settings = DirectionalSettings(estimator=estimator, radius=0.6, samples=32, steps=4)
    picture = noise()

    def twice(values):
        return tuple(2.0 * v for v in values)

    bright = GradientEnvironment(twice(SKY.zenith), twice(SKY.horizon), twice(SKY.ground))
    lamp = dataclasses.replace(LAMP, radiance=twice(LAMP.radiance))
    once = run(gl, shaders, picture, settings, environment=SKY, lights=(LAMP,))
    double = run(gl, shaders, picture, settings, environment=bright, lights=(lamp,))
    np.testing.assert_array_equal(double[..., :3], 2.0 * once[..., :3])
    np.testing.assert_array_equal(double[..., 3], once[..., 3])


def test_two_lights_add_up(gl, shaders):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4)
    picture = noise()
    parts = [
        run(gl, shaders, picture, settings, environment=SKY),
        run(gl, shaders, picture, settings, lights=(LAMP,)),
        run(gl, shaders, picture, settings, lights=(POINTS[0],)),
    ]
    together = run(gl, shaders, picture, settings, environment=SKY, lights=(LAMP, POINTS[0]))
    np.testing.assert_allclose(
        together[..., :3], sum(p[..., :3] for p in parts), rtol=1e-5, atol=1e-5
    )


def test_hemisphere_is_left_out_when_nobody_needs_it(gl, shaders):
    settings = DirectionalSettings(radius=0.6, samples=32, steps=4)
    with_it = run(gl, shaders, noise(), settings, lights=(LAMP,))
    without = run(gl, shaders, noise(), settings, lights=(LAMP,), needs_visibility=False)
    np.testing.assert_array_equal(without[..., :3], with_it[..., :3])
    assert np.all(without[..., 3] == 1.0)
    assert with_it[..., 3].min() < 1.0


def test_lights_of_other_kinds_are_left_to_direct(gl, shaders):
    settings = DirectionalSettings(radius=0.6)
    lights = tuple(dataclasses.replace(light, shadow="map") for light in (LAMP, *POINTS))
    assert np.all(run(gl, shaders, plane(), settings, lights=lights)[..., :3] == 0.0)


def test_background_is_dark_and_open(gl, shaders):
    picture = noise()
    image = run(gl, shaders, picture, DirectionalSettings(radius=1.0), environment=SKY)
    sky = picture.z == 0.0
    assert sky.any()
    np.testing.assert_array_equal(image[sky], np.broadcast_to([0, 0, 0, 1], image[sky].shape))

"""The picture from its terms, pixel by pixel."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import analytic_pictures
from passes.pass_harness import make_frame, make_scene, run_pass

from ssdo_gl.passes.composite import CompositePass, Display
from ssdo_gl.passes.edge_aware_filter import (
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Signal,
    without_last_stage,
)
from ssdo_gl.passes.tone_map import CURVES, ToneMapPass, ToneMapSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    kind_of,
)

SIZE = (16, 12)
# A few roundings of 6e-8.
TOLERANCE = 1e-6
# Half a step of the albedo's 16 bits (8e-6) times irradiances of up to 9 over pi.
ALBEDO_ROUNDING = 2.5e-5
# One of the 65536 levels of a display's channel: the sum may round otherwise in one shader.
DISPLAY_STEP = 1.6e-5
GRADIENT = GradientEnvironment((0.3, 0.6, 2.0), (1.0, 0.9, 0.8), (0.2, 0.1, 0.05))
CAMERA = Camera((1.0, 2.0, 3.0), (0.0, 1.5, 0.0), fov_y=50.0)


def terms(seed=1):
    """Random images; the left half of the frame is background."""
    rng = np.random.default_rng(seed)
    shape = (SIZE[1], SIZE[0])
    normal = rng.normal(size=(*shape, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    code = analytic_pictures.oct_encode(normal)
    z = rng.uniform(1.0, 9.0, (*shape, 1))
    z[:, : SIZE[0] // 2] = 0.0
    images = {
        "z_vs": z,
        "normals_vs": np.concatenate([code, code], -1) / 65535.0,
        "albedo": rng.uniform(0.0, 1.0, (*shape, 4)),
        "emission": rng.uniform(0.0, 3.0, (*shape, 4)),
        "direct_irradiance": rng.uniform(0.0, 3.0, (*shape, 4)),
        "directional_irradiance": rng.uniform(0.0, 3.0, (*shape, 4)),
        "bounce_irradiance": rng.uniform(0.0, 3.0, (*shape, 4)),
        "visibility": rng.uniform(0.0, 1.0, (*shape, 1)),
    }
    return images, analytic_pictures.oct_decode(code)


def compose(gl, shaders, images, environment=None, emission_region=None, **wiring):
    scene = make_scene(camera=CAMERA, environment=environment)
    wiring = {"radiances": ["emission"], **wiring}
    composite = CompositePass(kind_of(environment), **wiring)
    frame = dataclasses.replace(make_frame(scene, SIZE), emission_region=emission_region)
    inputs = {name: images[name] for name in composite.reads}
    return frame, run_pass(gl, shaders, composite, frame, inputs)["beauty"]


def on_surfaces(image):
    return image[:, SIZE[0] // 2 :, :3]


@pytest.mark.parametrize(
    "chosen", ["", "direct", "directional", "bounce", "direct directional bounce"]
)
def test_terms_add_up(gl, shaders, chosen):
    images, _ = terms()
    names = [f"{name}_irradiance" for name in chosen.split()]
    _, beauty = compose(gl, shaders, images, irradiances=names)
    irradiance = sum((images[name][..., :3] for name in names), np.zeros((*SIZE[::-1], 3)))
    wanted = images["emission"][..., :3] + images["albedo"][..., :3] / np.pi * irradiance
    np.testing.assert_allclose(
        on_surfaces(beauty), on_surfaces(wanted), rtol=TOLERANCE, atol=ALBEDO_ROUNDING
    )
    assert np.all(beauty[:, SIZE[0] // 2 :, 3] == 1.0)
    assert np.all(beauty[:, : SIZE[0] // 2] == 0.0), "without an environment the sky is black"


@pytest.mark.parametrize("is_small", [True, False])
def test_emission_is_added_where_surfaces_may_emit(gl, shaders, is_small):
    """Outside, it may be left over from anything; where it is asked of much, it was cleared."""
    images, _ = terms()
    x, y, width, height = (9, 2, 4, 3) if is_small else (2, 2, 14, 8)
    region = x, y, width, height
    names = ["direct_irradiance"]
    _, beauty = compose(gl, shaders, images, irradiances=names, emission_region=region)
    _, whole = compose(gl, shaders, images, irradiances=names)
    emission = images["emission"][..., :3].astype(np.float32)
    inside = np.zeros(SIZE[::-1], bool)
    top = SIZE[1] - y - height
    inside[top : top + height, x : x + width] = True
    inside |= not is_small
    wanted = whole[..., :3] - np.where(inside[..., None], 0.0, emission)
    np.testing.assert_allclose(on_surfaces(beauty), on_surfaces(wanted), atol=TOLERANCE)


@pytest.mark.parametrize("combine", ["ambient", "multiply", "report", "report_traced"])
@pytest.mark.parametrize("environment", [None, GRADIENT])
def test_what_visibility_multiplies(gl, shaders, combine, environment):
    images, normal_vs = terms()
    frame, beauty = compose(
        gl,
        shaders,
        images,
        environment,
        irradiances=["direct_irradiance"],
        visibility="visibility",
        combine=combine,
    )
    direct, v = images["direct_irradiance"][..., :3], images["visibility"]
    ambient = np.zeros_like(direct)
    if environment is not None:
        cosine = (normal_vs @ frame.view.view_from_world)[..., 1:2]
        angle = np.arccos(cosine)

        def overlap(a):
            return 2.0 / 3.0 * (np.sin(a) + (np.pi - a) * np.cos(a))

        zenith, horizon, ground = map(
            np.array, (GRADIENT.zenith, GRADIENT.horizon, GRADIENT.ground)
        )
        ambient = (
            np.pi * horizon
            + (zenith - horizon) * overlap(angle)
            + (ground - horizon) * overlap(np.pi - angle)
        )
    irradiance, extra = {
        "ambient": (direct + ambient * v, 0.0),
        "multiply": ((direct + ambient) * v, 0.0),
        "report": (direct * (v + 0.4), 0.0),
        "report_traced": (direct, 0.5 * v),
    }[combine]
    wanted = images["emission"][..., :3] + images["albedo"][..., :3] / np.pi * irradiance + extra
    np.testing.assert_allclose(
        on_surfaces(beauty), on_surfaces(wanted), rtol=TOLERANCE, atol=ALBEDO_ROUNDING
    )


@pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.4, -0.3)])
def test_sky_is_the_environment_along_each_ray(gl, shaders, jitter_px):
    images, _ = terms()
    scene = make_scene(camera=CAMERA, environment=GRADIENT)
    composite = CompositePass("gradient")
    frame = make_frame(scene, SIZE, jitter_px=jitter_px)
    beauty = run_pass(gl, shaders, composite, frame, {n: images[n] for n in composite.reads})[
        "beauty"
    ]
    rays = analytic_pictures.view_rays(SIZE, frame.view.tan_half_fov)[::-1].copy()
    rays[..., :2] += np.array(frame.view.jitter_ndc) * frame.view.tan_half_fov
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True) @ frame.view.view_from_world
    sky = slice(None), slice(0, SIZE[0] // 2)
    np.testing.assert_allclose(beauty[sky][..., :3], GRADIENT.sample(rays)[sky], rtol=2e-6)
    assert np.all(beauty[sky][..., 3] == 0.0)


def test_furnace_is_exact(gl, shaders):
    """Open surfaces under a uniform sky of 1 show their albedo."""
    images, _ = terms()
    images["emission"][:] = 0.0
    images["visibility"][:] = 1.0
    environment = ConstantEnvironment((1.0, 1.0, 1.0))
    _, beauty = compose(gl, shaders, images, environment, visibility="visibility")
    np.testing.assert_allclose(
        on_surfaces(beauty), on_surfaces(images["albedo"]), rtol=TOLERANCE, atol=ALBEDO_ROUNDING
    )
    assert np.all(beauty[:, : SIZE[0] // 2, :3] == 1.0)


def test_unlit_is_exactly_black(gl, shaders):
    images, _ = terms()
    for name in ("emission", "direct_irradiance", "bounce_irradiance"):
        images[name][:] = 0.0
    lights = ["direct_irradiance", "bounce_irradiance"]
    _, beauty = compose(gl, shaders, images, irradiances=lights)
    assert np.all(beauty[..., :3] == 0.0)


@pytest.mark.parametrize("background", ["environment", "transparent", "#204060"])
@pytest.mark.parametrize("curve", CURVES)
def test_what_a_display_shows_is_what_the_tone_mapper_makes(gl, shaders, background, curve):
    images, _ = terms()
    wiring = {"irradiances": ["direct_irradiance"], "radiances": ["emission"]}
    frame, beauty = compose(gl, shaders, images, GRADIENT, **wiring)
    tone = ToneMapPass(ToneMapSettings(exposure=0.5, background=background, curve=curve))
    wanted = run_pass(gl, shaders, tone, frame, {"beauty": beauty})["display"]
    display = Display(tone.writes, tone.defines, tone.uniforms)
    both = CompositePass("gradient", **wiring, display=display)
    found = run_pass(gl, shaders, both, frame, {name: images[name] for name in both.reads})
    np.testing.assert_allclose(found["display"], wanted, atol=DISPLAY_STEP)
    assert np.ptp(wanted[..., :3]) > 0.5


@pytest.mark.parametrize("scale", [1.0, 0.5])
@pytest.mark.parametrize("name", ["edge", "naive", "none"])
@pytest.mark.parametrize("glossy", [False, True])
def test_a_filter_may_end_where_the_terms_are_added_up(gl, shaders, name, scale, glossy):
    images, _ = terms()
    images |= dict.fromkeys(("gloss", "finish", "reflectance"), images["albedo"])
    step = round(1.0 / scale)
    raw = np.array(images["bounce_irradiance"][::step, ::step])
    raw[..., 3] = images["z_vs"][::step, ::step, 0]
    raw[4, -2] = np.nan
    images["raw"] = raw
    frame = make_frame(make_scene(camera=CAMERA), SIZE)
    whole = EdgeAwareFilterPass(
        "filter", EdgeAwareFilterSettings(filter=name), Signal("raw", "smooth", holds_z=True)
    )

    def made_by(item):
        return run_pass(gl, shaders, item, frame, {name: images[name] for name in item.reads})

    images |= made_by(whole)
    lights = ["direct_irradiance", "smooth"]
    wanted = made_by(CompositePass("none", lights, ["emission"], glossy=glossy))["beauty"]
    rest, end = without_last_stage(whole, scale)
    assert (rest is None) == ((scale == 1.0 and name != "edge") or name == "none")
    if rest is not None:
        images |= made_by(rest)
        assert images[end.wiring["t_value_0"]].shape == raw.shape
    del images["smooth"]
    ended = CompositePass("none", lights[:1], ["emission"], glossy=glossy, last_stage=end)
    found = made_by(ended)["beauty"]
    np.testing.assert_array_equal(found, wanted)
    assert np.all(np.isfinite(found)) and np.ptp(found) > 0.5


def test_light_of_gloss_is_added_where_gloss_may_be_seen(gl, shaders):
    """Two draws, of which one reads nothing of gloss, make what one over everything does."""
    images, _ = terms()
    images["reflectance"] = images["albedo"]
    item = CompositePass("none", ["direct_irradiance"], ["emission"], glossy=True, gloss=["shine"])
    assert {"shine", "gloss"} < set(item.reads)
    frame = make_frame(make_scene(camera=CAMERA), SIZE)
    x, y, width, height = region = (9, 2, 4, 5)
    inside = np.zeros((SIZE[1], SIZE[0], 1), bool)
    # Row 0 is at the top of images, and at the bottom of regions.
    inside[SIZE[1] - y - height : SIZE[1] - y, x : x + width] = True
    images["shine"] = np.where(inside, images["bounce_irradiance"], 0.0)
    images |= {name: np.where(inside, images["albedo"], 0.0) for name in ("gloss", "finish")}
    given = {name: images[name] for name in item.reads}
    wanted = run_pass(gl, shaders, item, frame, given)["beauty"]
    images["shine"][~inside[..., 0]] = np.nan
    frame = dataclasses.replace(frame, gloss_region=region)
    given = {name: images[name] for name in item.reads}
    found = run_pass(gl, shaders, item, frame, given)["beauty"]
    np.testing.assert_allclose(found, wanted, rtol=TOLERANCE)


def test_only_what_is_needed_is_read():
    assert CompositePass("none", ["e"], ["l"]).reads == ("z_vs", "albedo", "e", "l")
    assert "normals_vs" not in CompositePass("none", visibility="v", combine="report").reads
    assert CompositePass("none").settings_key() != CompositePass("gradient").settings_key()
    shown = (
        CompositePass("none", display=Display(tone.writes, tone.defines, tone.uniforms))
        for tone in (ToneMapPass(ToneMapSettings(exposure=ev)) for ev in (0.0, 1.0))
    )
    assert len({item.settings_key() for item in shown}) == 2


def test_more_terms_than_the_shader_has_slots_for_are_refused():
    CompositePass("none", list("abcdef"), list("ghij"))
    with pytest.raises(ValueError, match="7 irradiances and 0 radiances"):
        CompositePass("none", list("abcdefg"))
    with pytest.raises(ValueError, match="0 irradiances and 5 radiances"):
        CompositePass("none", [], list("abcde"))


def test_every_slot_is_added(gl, shaders):
    images, _ = terms()
    rng = np.random.default_rng(3)
    shape = (SIZE[1], SIZE[0], 4)
    more = {f"x{i}": rng.uniform(0.0, 3.0, shape) for i in range(10)}
    irradiances, radiances = list(more)[:6], list(more)[6:]
    _, beauty = compose(
        gl, shaders, {**images, **more}, irradiances=irradiances, radiances=radiances
    )
    irradiance = sum(more[name][..., :3] for name in irradiances)
    radiance = sum(more[name][..., :3] for name in radiances)
    wanted = radiance + images["albedo"][..., :3] / np.pi * irradiance
    # Six irradiances of up to 3 each: twice what others add up.
    np.testing.assert_allclose(
        on_surfaces(beauty), on_surfaces(wanted), rtol=TOLERANCE, atol=2.0 * ALBEDO_ROUNDING
    )

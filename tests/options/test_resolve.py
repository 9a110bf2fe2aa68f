"""What a user types becomes Settings, or one line that says what would be valid."""

from __future__ import annotations

import dataclasses
import json
import pickle

import numpy as np
import pytest

from ssdo_gl.options.pass_settings import overrides_from_table, overrides_from_text
from ssdo_gl.options.resolve import camera_from_text, chosen_camera, resolved, settings_for
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, describe, values
from ssdo_gl.settings.settings import LONGEST, MAX_SPP, SHORTEST


def test_flags_win_over_the_scene_and_the_scene_over_defaults():
    scene_settings = {"radius": 0.3, "samples": 16}
    settings = settings_for(scene_settings, {"samples": 32, "method": None})
    assert (settings.radius, settings.samples, settings.method) == (0.3, 32, "gi")


def test_another_method_drops_the_scenes_estimator():
    scene_settings = {"method": "ssdo", "estimator": "rgs09"}
    assert settings_for(scene_settings, {}).chosen_estimator == "rgs09"
    assert settings_for(scene_settings, {"method": "ssao"}).chosen_estimator == "march"


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ({"radius": -1.0}, "expected a number from 1e-15 to 1e+15 scene units, or 0 or inf"),
        ({"samples": 8.0}, "samples = 8.0"),
        ({"samples": True}, "samples = True"),
        ({"samples": "many"}, "samples = 'many'"),
        ({"samples": int("9" * 300)}, "samples = 9999"),
        ({"spp": 10**5000}, "spp = a whole number of thousands of digits: expected"),
        ({"size": 5}, "size = 5"),
        ({"method": "ssdoo"}, "did you mean 'ssdo'?"),
        ({"method": "direct", "estimator": "march"}, "it takes none"),
        ({"method": "ssdo", "estimator": "zbuffer"}, "expected one of march, rgs09"),
        ({"overrides": {"bounce.strenght": 2.0}}, "did you mean 'strength'?"),
    ],
)
def test_values_out_of_range_name_the_setting_and_what_is_valid(flags, said):
    with pytest.raises(SettingError) as caught:
        settings_for({}, flags)
    assert said in str(caught.value)


def test_an_unknown_setting_suggests_a_known_one():
    with pytest.raises(SettingError, match="unknown setting 'sampels'; did you mean 'samples'"):
        settings_for({}, {"sampels": 3})


@pytest.mark.parametrize("radius", [0.0, 0, 1e-15, float("inf")])
def test_a_radius_may_be_nothing_or_everything(radius):
    assert settings_for({}, {"radius": radius}).radius == radius


def test_cameras():
    assert camera_from_text("0,1,2 3,4,5 60") == ((0, 1, 2), (3, 4, 5), 60)
    assert camera_from_text("0,1,2 3,4,5") == ((0, 1, 2), (3, 4, 5), None)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "0,0,0",
        "0,0 1,1,1",
        "0,0,0 0,0,0",
        "a,b,c 1,2,3",
        "0,0,0 nan,0,0",
        "0,0,0 1,0,0 0",
        "0,0,0 1e300,0,0",
    ],
)
def test_bad_cameras_are_refused(text):
    with pytest.raises(SettingError, match="--camera"):
        camera_from_text(text)


FRONT = Camera((0.0, 0.0, 4.0), (0.0, 0.0, 0.0), fov_y=90.0)


def scene_seen_by(camera, *, is_framed=False):
    tall = Mesh(np.array([[-1.0, -3, 0], [1, -3, 0], [0, 3, 0]]), np.array([[0, 1, 2]]))
    return Scene((tall,), (Material(),), (SceneObject(0, 0),), camera, is_framed=is_framed)


@pytest.mark.parametrize(
    ("text", "projection", "home", "expected"),
    [
        (None, "perspective", FRONT, (90.0, None)),
        (None, "orthographic", FRONT, (90.0, 8.0)),  # as high as at the target
        (None, "ortho", FRONT.orthographic(3.0), (90.0, 3.0)),
        ("0,0,2 0,0,0", None, FRONT.orthographic(3.0), (90.0, 3.0)),
        ("0,0,2 0,0,0 7", None, FRONT.orthographic(3.0), (90.0, 7.0)),
        ("0,0,2 0,0,0 7", "ortho", FRONT, (90.0, 7.0)),
        ("0,0,2 0,0,0", "ortho", FRONT, (90.0, 4.0)),
        ("0,0,2 0,0,0 7", "perspective", FRONT.orthographic(3.0), (7.0, None)),
        ("0,0,2 0,0,0 7", None, FRONT, (7.0, None)),
    ],
)
def test_camera_and_projection_go_together(text, projection, home, expected):
    camera = chosen_camera(scene_seen_by(home), text, projection)
    assert (camera.fov_y, camera.height) == (expected[0], pytest.approx(expected[1]))
    assert camera.target == FRONT.target


def test_what_the_program_has_framed_stays_whole_between_parallel_rays():
    """6 high, seen from the front: as high as the frame, but for the usual margin."""
    camera = chosen_camera(scene_seen_by(FRONT, is_framed=True), None, "ortho")
    assert camera.height == pytest.approx(6.0 * 1.06)


@pytest.mark.parametrize("projection", [None, "ortho"])
@pytest.mark.parametrize("is_framed", [True, False])
def test_what_moves_is_framed_where_it_stands_at_the_time(is_framed, projection):
    scene = scene_seen_by(FRONT, is_framed=is_framed)
    away = dataclasses.replace(scene.objects[0], motion=Motion(sway=(100.0, 0.0, 0.0)))
    camera = chosen_camera(dataclasses.replace(scene, objects=(away,)), None, projection, 1.0)
    if not is_framed and projection is None:
        assert camera is None
    else:
        assert camera.target[0] == pytest.approx(100.0 if is_framed else 0.0, abs=1.0)
        assert (camera.height is None) == (projection is None)


def test_parallel_rays_seen_through_a_pinhole_keep_the_size_of_the_target():
    camera = chosen_camera(scene_seen_by(FRONT.orthographic(2.0)), None, "perspective")
    assert camera.position == pytest.approx((0.0, 0.0, 1.0))
    assert camera.height_at_target == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("text", "projection", "message"),
    [
        ("0,0,0 1,0,0 180", None, "fov must be between 0 and 180"),
        ("0,0,0 1,0,0 180", "perspective", "fov must be between 0 and 180"),
    ],
)
def test_the_third_number_of_a_camera_fits_its_projection(text, projection, message):
    with pytest.raises(SettingError, match=message):
        chosen_camera(scene_seen_by(FRONT), text, projection)


def test_overrides_reach_any_pass():
    assert overrides_from_text(["bounce.strength=2", "tone_map.curve=aces"]) == {
        "bounce.strength": 2.0,
        "tone_map.curve": "aces",
    }


@pytest.mark.parametrize("name", ["directional.thickness", "reference_gi.bounces"])
def test_none_leaves_a_setting_to_the_program(name):
    """As the tables of defaults call it."""
    assert overrides_from_text([f"{name}=none"]) == {name: None}
    assert overrides_from_table({name: "none"}) == {name: None}


@pytest.mark.parametrize("name", ["ssao_filter", "directional_filter", "bounce_filter"])
def test_each_filter_has_settings_of_its_own(name):
    assert overrides_from_text([f"{name}.tap_radius=5"]) == {f"{name}.tap_radius": 5}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bounce", "expected PASS.FIELD=VALUE"),
        ("bunce.strength=1", "did you mean 'bounce'"),
        ("bounce.strenght=1", "did you mean 'strength'"),
        ("bounce.strength=-1", "expected a number from 0"),
        ("bounce.strength=inf", "strength = inf"),
        ("gbuffer.size=1", "the pass gbuffer has no settings"),
        ("bounce.strength=none", "strength = 'none': expected a number from 0$"),
        ("directional.thickness=x", "thickness = 'x': expected a number from 0 to inf, or none$"),
        ("tone_map.curve=film", "expected one of aces, plain"),
    ],
)
def test_bad_overrides_are_refused(text, said):
    with pytest.raises(SettingError, match=said):
        overrides_from_text([text])


SCENE = load_scene("corner")


def scene_with(**scene_settings):
    return dataclasses.replace(SCENE, render=scene_settings)


SCENE_SETTINGS = {
    "method": "ssao",
    "estimator": "march",
    "samples": 16,
    "size": (320, 200),
    "radius": 0.25,
    "exposure": 1.5,
    "filter": "none",
    "resolution_scale": 0.5,
    "seed": 3,
}


def test_python_and_command_line_resolve_a_scene_alike():
    """What was not given yields to the scene, whoever asks; what was given holds."""
    scene = scene_with(**SCENE_SETTINGS)
    for given in ({}, {"samples": 48}, {"size": (1280, 720), "seed": 0}, {"filter": "edge"}):
        by_flags = resolved(settings_for(scene.render, given), scene)
        by_python = resolved(Settings(**given), scene)
        assert by_flags == by_python
        for name, value in {**SCENE_SETTINGS, **given}.items():
            assert getattr(by_python, name) == value, name


def test_a_default_that_was_given_is_no_default():
    scene = scene_with(samples=16)
    assert resolved(Settings(samples=48), scene).samples == 48
    assert resolved(dataclasses.replace(Settings(), samples=48), scene).samples == 48
    assert resolved(dataclasses.replace(Settings(), steps=4), scene).samples == 16


def test_scene_settings_are_taken_once():
    """Who clears a field of resolved settings means it: a bound on errors, for one."""
    scene = scene_with(max_error=0.1, samples=16)
    first = resolved(Settings(), scene)
    assert first.max_error == 0.1
    again = resolved(dataclasses.replace(first, max_error=None, samples=8), scene)
    assert (again.max_error, again.samples) == (None, 8)


def test_a_scene_setting_of_no_known_name_is_refused():
    with pytest.raises(SettingError, match="unknown setting 'sampels'; did you mean 'samples'"):
        resolved(Settings(), scene_with(sampels=3))


def test_what_nobody_chose_comes_from_the_scene():
    settings = resolved(Settings(), dataclasses.replace(SCENE, render={}))
    assert settings.radius == SCENE.default_radius()
    assert settings.exposure == SCENE.camera.exposure


@pytest.mark.parametrize(("reach", "radius"), [(1e-20, SHORTEST), (1e20, LONGEST)])
def test_the_default_radius_of_the_smallest_and_largest_scenes_is_in_its_range(reach, radius):
    scene = dataclasses.replace(SCENE, render={}, reach=reach)
    assert resolved(Settings(method="bounce"), scene).radius == radius


def test_automatic_exposure_is_kept_in_its_range():
    camera = dataclasses.replace(SCENE.camera, exposure=107.0)
    scene = dataclasses.replace(SCENE, camera=camera, render={})
    assert resolved(Settings(), scene).exposure == 60.0


def test_a_bound_lifts_the_default_limit_of_rays_but_not_a_given_one():
    bounded = Settings(method="reference-ao", max_error=0.01)
    assert resolved(bounded, SCENE).spp == resolved(bounded, SCENE).shadow_rays == MAX_SPP
    given = dataclasses.replace(bounded, spp=256, shadow_rays=16)
    assert resolved(given, SCENE).spp == 256
    assert resolved(given, SCENE).shadow_rays == 16
    assert resolved(Settings(method="reference-ao"), SCENE).spp == 256
    assert resolved(Settings(max_error=0.01), SCENE).shadow_rays == 16


def test_marked_defaults_behave_as_plain_values():
    settings = Settings()
    assert (settings.samples, settings.method, settings.size) == (48, "gi", (1280, 720))
    assert json.dumps(values(settings)) == json.dumps(values(pickle.loads(pickle.dumps(settings))))
    assert repr(settings.samples) == "48" and hash(settings.size) == hash((1280, 720))
    assert not any(settings.gives(name) for name in describe(Settings) if name != "overrides")
    assert not pickle.loads(pickle.dumps(settings)).gives("samples")

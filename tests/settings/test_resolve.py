"""What a user types becomes Settings, or one line that says what would be valid."""

from __future__ import annotations

import pytest

from ssdo_gl.settings.fields import SettingError
from ssdo_gl.settings.resolve import (
    camera_from_text,
    overrides_from_text,
    settings_for,
    size_from_text,
)


def test_flags_win_over_the_scene_and_the_scene_over_defaults():
    wishes = {"radius": 0.3, "samples": 16}
    settings = settings_for(wishes, {"samples": 32, "method": None})
    assert (settings.radius, settings.samples, settings.method) == (0.3, 32, "bounce")


def test_another_method_drops_the_scenes_estimator():
    wishes = {"method": "ssdo", "estimator": "rgs09"}
    assert settings_for(wishes, {}).chosen_estimator == "rgs09"
    assert settings_for(wishes, {"method": "ssao"}).chosen_estimator == "hemisphere"


@pytest.mark.parametrize("text", ["0x5", "5x0", "100000x1"])
def test_impossible_sizes_are_refused(text):
    with pytest.raises(SettingError, match=r"--size = .*each side must be within 1 to 16384 px"):
        settings_for({}, {"size": size_from_text(text)})


@pytest.mark.parametrize("text", ["5", "5x", "-5x5", "5.5x5", "x", ""])
def test_unreadable_sizes_are_refused(text):
    with pytest.raises(SettingError, match="expected WIDTHxHEIGHT"):
        size_from_text(text)


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ({"radius": -1.0}, "--radius = -1.0: must be within 0 to inf scene units"),
        ({"radius": float("nan")}, "--radius = nan"),
        ({"samples": 0}, "--samples = 0: must be within 1 to 1024"),
        ({"resolution_scale": 0.3}, "--resolution-scale = 0.3"),
        ({"method": "direct", "estimator": "march"}, "it takes none"),
        ({"method": "ssdo", "estimator": "zbuffer"}, "choose one of march, rgs09"),
        ({"exposure": float("inf")}, "finite number of EV"),
    ],
)
def test_values_out_of_range_name_the_flag_and_the_range(flags, said):
    with pytest.raises(SettingError) as caught:
        settings_for({}, flags)
    assert said in str(caught.value)


def test_an_unknown_setting_suggests_a_known_one():
    with pytest.raises(SettingError, match="unknown setting 'sampels'; did you mean samples"):
        settings_for({}, {"sampels": 3})


def test_an_infinite_radius_is_allowed():
    assert settings_for({}, {"radius": float("inf")}).radius == float("inf")


def test_cameras():
    camera = camera_from_text("0,1,2 3,4,5 60")
    assert camera == {"position": (0, 1, 2), "target": (3, 4, 5), "fov_y": 60}
    assert "fov_y" not in camera_from_text("0,1,2 3,4,5")


@pytest.mark.parametrize(
    "text",
    ["", "0,0,0", "0,0 1,1,1", "0,0,0 0,0,0", "a,b,c 1,2,3", "0,0,0 nan,0,0", "0,0,0 1,0,0 180"],
)
def test_bad_cameras_are_refused(text):
    with pytest.raises(SettingError, match="--camera"):
        camera_from_text(text)


def test_overrides_reach_any_pass():
    assert overrides_from_text(["bounce.strength=2", "tone_map.curve=aces"]) == {
        "bounce.strength": 2.0,
        "tone_map.curve": "aces",
    }


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bounce", "expected PASS.FIELD=VALUE"),
        ("bunce.strength=1", "did you mean bounce"),
        ("bounce.strenght=1", "did you mean strength"),
        ("bounce.strength=-1", "must be within 0"),
        ("tone_map.curve=film", "choose one of aces, plain"),
    ],
)
def test_bad_overrides_are_refused(text, said):
    with pytest.raises(SettingError, match=said):
        overrides_from_text([text])

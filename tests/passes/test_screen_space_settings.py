"""Settings that the screen-space estimators share."""

from __future__ import annotations

import dataclasses

import pytest
from passes.estimator_cases import picture_frame

from ssdo_gl.effects.bounce import BounceSettings
from ssdo_gl.effects.directional import DirectionalSettings
from ssdo_gl.effects.ssao import SsaoPass, SsaoSettings
from ssdo_gl.passes.screen_space_settings import (
    ScreenSpaceSettings,
    estimator_uniforms,
    pattern_offset,
)
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.fields import SettingError, check, parse

CLASSES = (ScreenSpaceSettings, SsaoSettings, DirectionalSettings, BounceSettings)


@pytest.mark.parametrize("settings_class", CLASSES)
def test_defaults_are_within_their_own_ranges(settings_class):
    check(settings_class())


def test_resolution_scale_is_a_half_or_one():
    assert ScreenSpaceSettings(resolution_scale=1.0).receiver_stride == 1
    assert ScreenSpaceSettings(resolution_scale=0.5).receiver_stride == 2
    with pytest.raises(SettingError, match=r"resolution_scale = 0\.7: must be 0\.5 or 1"):
        _ = ScreenSpaceSettings(resolution_scale=0.7).receiver_stride


@pytest.mark.parametrize(
    "estimator, samples, steps, directions, step_count",
    [
        ("march", 20, 8, 2, 8),
        ("march", 4, 8, 1, 4),
        ("march", 64, 1, 64, 1),
        ("hemisphere", 20, 8, 20, 1),
        ("rgs09", 1, 8, 1, 1),
        ("gtao", 40, 8, 2, 8),
        ("gtao", 8, 8, 1, 4),
        ("gtao", 8, 1, 4, 1),
    ],
)
def test_samples_are_shared_out_over_directions(estimator, samples, steps, directions, step_count):
    """`samples` counts depth reads; it is never exceeded. A slice reads both ways."""
    settings = SsaoSettings(estimator=estimator, samples=samples, steps=steps)
    assert (settings.direction_count, settings.step_count) == (directions, step_count)
    assert ESTIMATORS[estimator].sides * directions * step_count <= samples


def test_a_slice_takes_two_reads_at_least():
    settings = SsaoSettings(estimator="gtao", samples=1)
    assert (settings.direction_count, settings.step_count) == (1, 1)


@pytest.mark.parametrize(
    "estimator, label", [("march", "4x8"), ("gtao", "2x2x8"), ("hemisphere", "32")]
)
def test_labels_say_how_reads_are_shared_out(estimator, label):
    assert ESTIMATORS[estimator].count_label(32, 8) == label


@pytest.mark.parametrize(
    "estimator, has_back, thickness, expected",
    [
        ("march", True, None, 1.0),
        ("march", False, None, 0.3),
        ("hemisphere", False, None, 2.0),
        ("march", True, 0.7, 0.7),
        ("march", False, 0.0, 0.0),
    ],
)
def test_thickness_depends_on_the_back_layer_unless_given(estimator, has_back, thickness, expected):
    settings = SsaoSettings(estimator=estimator, thickness=thickness)
    uniforms = estimator_uniforms(settings, picture_frame((8, 8), 0.5), has_back)
    assert uniforms["u_thickness"] == expected


def test_seeds_start_the_sequence_elsewhere():
    offsets = [pattern_offset(seed) for seed in range(64)]
    assert len(set(offsets)) == 64
    assert offsets == [pattern_offset(seed) for seed in range(64)]
    assert all(0 <= part < 2**32 for offset in offsets for part in offset)


def test_settings_read_from_text():
    assert parse(SsaoSettings, "thickness", "0.4") == 0.4
    assert parse(SsaoSettings, "radius", "inf") == float("inf")
    with pytest.raises(SettingError, match="steps"):
        parse(SsaoSettings, "stepz", "4")
    with pytest.raises(SettingError, match="estimator"):
        parse(DirectionalSettings, "estimator", "zbuffer")


def test_passes_with_other_settings_have_other_keys():
    base = SsaoSettings()
    keys = {
        SsaoPass(base).settings_key(),
        SsaoPass(base, has_back_layer=True).settings_key(),
        SsaoPass(dataclasses.replace(base, radius=1.0)).settings_key(),
        SsaoPass(dataclasses.replace(base, bias=0.1)).settings_key(),
    }
    assert len(keys) == 4

"""Effects follow the scene's content; with --effects full they follow the request alone."""

from __future__ import annotations

import dataclasses

import pytest

from ssdo_gl.effects import decide, effective_combine
from ssdo_gl.scene.content import SceneContent
from ssdo_gl.settings import Settings

RICH = SceneContent(
    has_lights=True,
    has_direct_lights=True,
    has_shadowed_lights=True,
    has_ssdo_lights=True,
    environment="gradient",
    has_albedo=True,
    has_unlit_emission=False,
    has_textures=False,
    has_vertex_colors=False,
    has_cutouts=False,
    has_closed_meshes=True,
    has_motion=False,
    triangle_count=12,
)
NO_LIGHT = dataclasses.replace(
    RICH,
    has_lights=False,
    has_direct_lights=False,
    has_shadowed_lights=False,
    has_ssdo_lights=False,
    environment="none",
)
SWITCHES = ("direct", "shadow_map", "directional", "bounce", "back_layer", "visibility")


def running(content, wanted=("beauty",), **settings):
    effects = decide(content, Settings(**settings), wanted)
    return {name for name in SWITCHES if getattr(effects, name)}


def test_a_rich_scene_runs_everything():
    assert running(RICH) == {"direct", "shadow_map", "directional", "bounce", "back_layer"}


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        ("direct", {"direct", "shadow_map"}),
        ("ssao", {"direct", "shadow_map", "visibility"}),
        ("ssdo", {"direct", "shadow_map", "directional", "back_layer"}),
    ],
)
def test_a_method_runs_what_its_picture_needs(method, expected):
    assert running(RICH, method=method) == expected


def test_only_what_was_asked_for_runs():
    assert running(RICH, wanted=("albedo", "depth")) == set()
    assert running(RICH, wanted=("direct",)) == {"direct", "shadow_map"}
    assert running(RICH, wanted=("directional",)) == {"directional", "back_layer"}
    visible = running(RICH, wanted=("visibility",), method="direct")
    assert visible == {"visibility", "back_layer"}


@pytest.mark.parametrize(
    ("changes", "missing"),
    [
        ({"has_shadowed_lights": False}, {"shadow_map"}),
        ({"has_closed_meshes": False}, {"back_layer"}),
        ({"has_albedo": False}, {"bounce"}),
        ({"environment": "none", "has_ssdo_lights": False}, {"directional"}),
        ({"has_direct_lights": False, "has_shadowed_lights": False}, {"direct", "shadow_map"}),
    ],
)
def test_what_a_scene_lacks_is_not_simulated(changes, missing):
    content = dataclasses.replace(RICH, **changes)
    assert running(RICH) - running(content) == missing


def test_a_scene_almost_without_an_effect_keeps_it():
    assert "directional" in running(dataclasses.replace(RICH, environment="none"))
    assert "bounce" in running(dataclasses.replace(NO_LIGHT, has_unlit_emission=True))


def test_an_unlit_scene_runs_nothing():
    assert running(NO_LIGHT) == set()


def test_full_takes_no_notice_of_the_content():
    assert running(NO_LIGHT, effects="full") == running(RICH, effects="full")


def test_no_shadows_means_no_shadow_map():
    assert running(RICH, method="direct", shadows="none") == {"direct"}


def test_every_decision_has_a_reason():
    for content in (RICH, NO_LIGHT):
        for row in decide(content, Settings(), ("beauty",)).decisions:
            assert row.reason


@pytest.mark.parametrize(
    ("environment", "chosen", "expected"),
    [("none", None, "multiply"), ("map", None, "ambient"), ("map", "report", "report")],
)
def test_what_visibility_multiplies(environment, chosen, expected):
    content = dataclasses.replace(RICH, environment=environment)
    assert effective_combine(content, Settings(combine=chosen)) == expected

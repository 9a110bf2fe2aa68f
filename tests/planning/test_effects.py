"""Effects follow the scene's content; with --effects full they follow the request alone."""

from __future__ import annotations

import dataclasses
import math

import pytest

from ssdo_gl.planning.content import LightContent, SceneContent
from ssdo_gl.planning.effects import decide, effective_combine
from ssdo_gl.planning.view import Sight
from ssdo_gl.settings import Settings

LAMP, PANEL = LightContent("map"), LightContent("ssdo", is_rectangle=True)
OFF = LightContent("map", is_on=False)
RICH = SceneContent(
    lights=(LAMP, PANEL),
    environment="gradient",
    environment_is_simplified=False,
    has_albedo=True,
    has_emission=True,
    has_unlit_emission=False,
    has_textures=False,
    has_vertex_colors=False,
    has_cutouts=False,
    has_closed_meshes=True,
    has_motion=False,
    triangle_count=12,
)
NO_LIGHT = dataclasses.replace(
    RICH, lights=(OFF, dataclasses.replace(PANEL, is_on=False)), environment="none"
)
# A view that rules nothing out.
CROWDED = Sight(
    is_empty=False,
    open_distance=0.0,
    only_solids=False,
    nearest_pixel=1e-4,
    farthest_pixel=1e-3,
    slant=1.2,
    reaches=(True, True),
    shadows=(True, True),
)
RADIUS = 0.3
SWITCHES = ("direct", "shadow_map", "directional", "bounce", "back_layer", "visibility")


def effects_of(content, wanted=("beauty",), sight=None, **settings):
    return decide(content, Settings(**{"radius": RADIUS, **settings}), wanted, sight)


def running(content, wanted=("beauty",), sight=None, **settings):
    effects = effects_of(content, wanted, sight, **settings)
    return {name for name in SWITCHES if getattr(effects, name)}


def content(**changes):
    return dataclasses.replace(RICH, **changes)


def sight(**changes):
    return dataclasses.replace(CROWDED, **changes)


def reasons(effects, effect):
    return [row.reason for row in effects.decisions if row.effect == effect and not row.run]


EVERYTHING = {"direct", "shadow_map", "directional", "bounce", "back_layer"}


def test_a_rich_scene_runs_everything():
    assert running(RICH) == running(RICH, sight=CROWDED) == EVERYTHING


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
        ({"lights": (LightContent("none"), PANEL)}, {"shadow_map"}),
        ({"has_closed_meshes": False}, {"back_layer"}),
        ({"has_albedo": False}, {"bounce"}),
        ({"environment": "none", "lights": (LAMP,)}, {"directional"}),
        ({"environment": "none", "lights": (LAMP, OFF)}, {"directional"}),
        ({"lights": (PANEL,)}, {"direct", "shadow_map"}),
        ({"lights": (OFF, PANEL)}, {"direct", "shadow_map"}),
    ],
)
def test_what_a_scene_lacks_is_not_simulated(changes, missing):
    assert running(RICH) - running(content(**changes)) == missing


def test_a_scene_almost_without_an_effect_keeps_it():
    assert "directional" in running(content(environment="none"))
    assert "directional" in running(content(lights=(LAMP,)))
    assert "bounce" in running(dataclasses.replace(NO_LIGHT, has_unlit_emission=True))
    assert "shadow_map" in running(content(lights=(LightContent("none"), LAMP)))


def test_an_unlit_scene_runs_nothing():
    assert running(NO_LIGHT) == set()


def test_full_takes_no_notice_of_content_and_view():
    nothing = sight(is_empty=True, open_distance=math.inf, reaches=(False, False))
    bare = dataclasses.replace(NO_LIGHT, has_albedo=False, has_emission=False)
    full = effects_of(bare, sight=nothing, effects="full")
    assert running(bare, sight=nothing, effects="full") == EVERYTHING
    assert full.lights is None and full.shadow_maps is None and full.emission
    assert full.samples_hemisphere and full.sender_emission
    assert not (full.is_open or full.is_scalar or full.shares_directions)
    assert not full.simplifies_environment


def test_no_shadows_means_no_shadow_map():
    assert running(RICH, method="direct", shadows="none") == {"direct"}
    traced = effects_of(RICH, method="direct", shadows="traced")
    assert traced.traced_shadows and not traced.shadow_map


def test_lights_that_reach_nothing_are_left_out():
    dark = effects_of(RICH, sight=sight(reaches=(False, True), shadows=(False, True)))
    assert dark.lights == (False, True)
    assert not dark.direct and not dark.shadow_map and dark.directional
    assert reasons(dark, "direct light") == ["no light can reach anything in view"]
    neither = effects_of(
        content(environment="none"), sight=sight(reaches=(False, False), shadows=(False, False))
    )
    assert not (neither.direct or neither.directional or neither.bounce)
    assert reasons(neither, "bounce") == ["nothing that can be seen is lit"]


def test_a_light_that_nothing_shadows_needs_no_map():
    two = content(lights=(LAMP, LAMP))
    one = effects_of(two, sight=sight(shadows=(True, False)))
    assert one.shadow_map and one.shadow_maps == (True, False) and one.lights == (True, True)
    free = effects_of(two, sight=sight(shadows=(False, False)))
    assert free.direct and not free.shadow_map
    assert reasons(free, "shadow maps") == ["nothing can stand between a light and what is in view"]


def test_an_empty_view_needs_nothing():
    empty = sight(is_empty=True, reaches=(False, False), shadows=(False, False))
    assert running(RICH, sight=empty) == set()
    assert effects_of(RICH, ("visibility",), empty).is_open


ALONE, APART = sight(open_distance=math.inf), sight(open_distance=2.0, only_solids=True)


@pytest.mark.parametrize("view", [ALONE, APART, sight(nearest_pixel=0.31)])
def test_where_nothing_is_near_there_is_no_bounce_and_no_march(view):
    sky = content(lights=(LAMP, LAMP))
    effects = effects_of(sky, sight=view)
    assert effects.is_open and effects.directional
    assert not effects.bounce and not effects.back_layer
    assert len(reasons(effects, "blocked directions")) == 1


@pytest.mark.parametrize(
    ("view", "changes"),
    [
        # Rays of .3 end up to .3 (1 + 3 * 1.2) = 1.38 away, and two pixels more.
        (sight(open_distance=1.381, only_solids=True), {}),
        (sight(open_distance=2.0, only_solids=False), {}),
        (APART, {"estimator": "rgs09"}),
        (APART, {"radius": 0.5}),
        (APART, {"radius": math.inf}),
        (APART, {"overrides": {"directional.thickness": 9.0}}),
        (APART, {"overrides": {"bounce.radius": 0.5}}),
        (sight(nearest_pixel=0.2999), {}),
        (sight(nearest_pixel=0.31), {"overrides": {"bounce.radius": 0.4}}),
    ],
)
def test_where_something_is_almost_out_of_reach_everything_runs(view, changes):
    effects = effects_of(content(lights=(LAMP, LAMP)), sight=view, **changes)
    assert not effects.is_open and effects.bounce


def test_without_solids_sheets_may_be_far_apart():
    sheets = content(has_closed_meshes=False)
    assert effects_of(sheets, sight=sight(open_distance=2.0)).is_open


def test_the_estimator_without_a_radius_is_never_open():
    view = sight(open_distance=math.inf)
    assert not effects_of(RICH, ("visibility",), view, method="ssao", estimator="zbuffer").is_open
    assert effects_of(RICH, ("visibility",), view, method="ssao", estimator="rgs09").is_open


def test_marches_to_lights_know_no_smallest_radius():
    assert not effects_of(RICH, sight=sight(nearest_pixel=0.31)).is_open
    far_light = sight(nearest_pixel=0.31, reaches=(True, False))
    assert effects_of(RICH, sight=far_light).is_open


SKY = content(environment="constant", lights=(LAMP,))


def test_a_constant_environment_needs_only_visibility():
    assert effects_of(SKY).is_scalar
    assert not effects_of(content(environment="constant")).is_scalar
    assert effects_of(content(environment="constant", lights=(LAMP, OFF))).is_scalar
    assert not effects_of(content(lights=(LAMP,))).is_scalar
    assert not effects_of(SKY, estimator="rgs09").is_scalar
    assert not effects_of(SKY, overrides={"directional.estimator": "rgs09"}).is_scalar
    assert not effects_of(SKY, effects="full").is_scalar


def test_lights_alone_need_no_other_directions():
    room = content(environment="none")
    assert not effects_of(room).samples_hemisphere
    assert effects_of(room, ("beauty", "visibility")).samples_hemisphere
    assert effects_of(RICH).samples_hemisphere
    assert effects_of(room, estimator="rgs09").samples_hemisphere


def test_one_march_serves_two_passes():
    assert effects_of(RICH).shares_directions
    assert effects_of(SKY).shares_directions
    assert not effects_of(RICH, method="ssdo").shares_directions
    lamp = content(environment="none", lights=(LAMP,))
    assert not effects_of(lamp).shares_directions
    assert effects_of(lamp, ("beauty", "visibility")).shares_directions
    # The window's lights have directions of their own.
    assert not effects_of(content(environment="none")).shares_directions


@pytest.mark.parametrize(
    "changes",
    [
        {"estimator": "rgs09"},
        {"effects": "full"},
        {"samples": 256},
        {"steps": 2, "samples": 16},
        {"size": (4097, 16)},
        {"size": (16, 4097)},
        {"overrides": {"bounce.radius": 0.1}},
        {"overrides": {"directional.steps": 4}},
        {"overrides": {"bounce.estimator": "rgs09", "directional.estimator": "rgs09"}},
    ],
)
def test_marches_that_differ_are_not_shared(changes):
    assert not effects_of(RICH, **changes).shares_directions


def test_the_same_override_on_both_sides_is_shared():
    both = {"bounce.bias": 0.01, "directional.bias": 0.01, "bounce.strength": 2.0}
    assert effects_of(RICH, overrides=both).shares_directions


def test_emission_is_read_only_where_something_emits():
    assert effects_of(RICH).emission and not effects_of(RICH).sender_emission
    assert not effects_of(content(has_emission=False)).emission
    glowing = content(has_unlit_emission=True)
    assert effects_of(glowing).sender_emission
    assert not effects_of(glowing, method="ssdo").sender_emission


def test_references_take_no_notice_of_the_view():
    empty = sight(is_empty=True, reaches=(False, False), shadows=(False, False))
    effects = effects_of(RICH, sight=empty, method="reference-near")
    assert effects.direct and effects.directional and effects.bounce
    assert effects.lights is None and not effects.simplifies_environment
    assert not effects.is_scalar and not effects.shares_directions


@pytest.mark.parametrize(
    ("changes", "combine", "runs"),
    [
        ({}, "ambient", True),
        ({"environment": "none"}, "ambient", False),
        ({"environment": "none"}, "multiply", True),
        ({"environment": "none", "lights": (OFF,)}, "multiply", False),
        ({"lights": (OFF,)}, "multiply", True),
        ({"lights": (OFF,)}, "report", False),
        ({}, "report", True),
    ],
)
def test_visibility_runs_where_there_is_something_to_multiply(changes, combine, runs):
    assert ("visibility" in running(content(**changes), method="ssao", combine=combine)) == runs


def test_the_report_adds_traced_visibility_as_light_of_its_own():
    dark = content(lights=(OFF,))
    assert "visibility" in running(dark, method="reference-ao", combine="report")


def test_every_decision_has_a_reason_and_no_effect_is_decided_twice():
    views = (None, CROWDED, ALONE, sight(is_empty=True))
    for scene in (RICH, NO_LIGHT, SKY):
        for view in views:
            small = None if view is None else sight_for(view, scene)
            rows = effects_of(scene, sight=small).decisions
            assert all(row.reason and row.effect for row in rows)
            names = [row.effect for row in rows]
            assert len(names) == len(set(names))


def sight_for(view, scene):
    count = len(scene.lights)
    return dataclasses.replace(view, reaches=view.reaches[:count], shadows=view.shadows[:count])


@pytest.mark.parametrize(
    ("environment", "chosen", "expected"),
    [("none", None, "multiply"), ("map", None, "ambient"), ("map", "report", "report")],
)
def test_what_visibility_multiplies(environment, chosen, expected):
    changed = dataclasses.replace(RICH, environment=environment)
    assert effective_combine(changed, Settings(combine=chosen)) == expected

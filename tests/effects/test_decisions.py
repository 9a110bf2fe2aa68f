"""Effects follow the scene's content; with --effects full they follow the request alone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.effects.ambient import combine_of
from ssdo_gl.effects.emission import Emission
from ssdo_gl.effects.request import Request
from ssdo_gl.facts.content import LightContent, SceneContent
from ssdo_gl.facts.view import ViewFacts
from ssdo_gl.planning.walk import decide
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.settings import MAX_SIZE_PX

LAMP, PANEL = LightContent("map"), LightContent("ssdo")
OFF = LightContent("map", is_on=False)
RICH = SceneContent(
    lights=(LAMP, PANEL),
    environment="gradient",
    has_albedo=True,
    has_emission=True,
    has_unlit_emission=False,
    has_glow=False,
    has_stand_ins=False,
    has_gloss=False,
    has_translucency=False,
    has_baked_occlusion=False,
    has_closed_meshes=True,
)
NO_LIGHT = dataclasses.replace(
    RICH, lights=(OFF, dataclasses.replace(PANEL, is_on=False)), environment="none"
)
# A view that rules nothing out.
FRAME = 0, 0, 64, 36
CROWDED = ViewFacts(False, False, gloss_region=FRAME, emission_region=FRAME)
RADIUS = 0.3
SWITCHES = ("direct", "shadow_map", "directional", "bounce", "back_layer", "ssao", "reference_ao")
ENVIRONMENTS = {
    "none": None,
    "constant": ConstantEnvironment((1.0, 1.0, 1.0)),
    "gradient": GradientEnvironment((1.0, 1.0, 1.0), (0.5, 0.5, 0.5), (0.0, 0.0, 0.0)),
    "map": MapEnvironment(np.eye(4, 8, dtype=np.float32)[:, :, None].repeat(3, axis=2)),
}


def request_of(content, wanted=("beauty",), facts=None, **settings):
    environment = ENVIRONMENTS[content.environment]
    scene = Scene((), (), (), Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), (), environment)
    chosen = Settings(**{"method": "bounce", "radius": RADIUS, **settings})
    return Request(scene, content, chosen, wanted, facts)


def decided_of(content, wanted=("beauty",), facts=None, **settings):
    return decide(request_of(content, wanted, facts, **settings))


def running(content, wanted=("beauty",), facts=None, **settings):
    decided = decided_of(content, wanted, facts, **settings)
    return {name for name in SWITCHES if decided.runs(name)}


def content(**changes):
    return dataclasses.replace(RICH, **changes)


def facts(**changes):
    return dataclasses.replace(CROWDED, **changes)


def reasons(decided, effect):
    return [row.reason for row in decided.rows if row.effect == effect and not row.run]


def is_open(decided):
    return decided.spares("blocked directions")


def shares_directions(decided):
    return decided.spares("second march")


EVERYTHING = {"direct", "shadow_map", "directional", "bounce", "back_layer"}


def test_a_rich_scene_runs_everything():
    assert running(RICH) == running(RICH, facts=CROWDED) == EVERYTHING


@pytest.mark.parametrize(
    ("method", "expected"),
    [
        ("direct", {"direct", "shadow_map"}),
        ("ssao", {"direct", "shadow_map", "back_layer", "ssao"}),
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
    assert visible == {"ssao", "back_layer"}


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
    nothing = facts(is_empty=True)
    bare = dataclasses.replace(NO_LIGHT, has_albedo=False, has_emission=False)
    full = decided_of(bare, facts=nothing, effects="full")
    assert running(bare, facts=nothing, effects="full") == EVERYTHING
    assert full.lights is None and full.runs("emission")
    assert not full.spares("hemisphere")
    assert not (is_open(full) or shares_directions(full))


def test_no_shadows_means_no_shadow_map():
    assert running(RICH, method="direct", shadows="none") == {"direct"}
    traced = decided_of(RICH, method="direct", shadows="traced")
    assert traced.runs("traced_shadows") and not traced.runs("shadow_map")


def test_lights_that_are_off_are_left_out():
    dark = decided_of(content(lights=(OFF, PANEL)))
    assert dark.lights == (False, True)
    assert not dark.runs("direct") and not dark.runs("shadow_map") and dark.runs("directional")
    assert reasons(dark, "direct light") == ["all light comes through open directions"]
    assert reasons(decided_of(NO_LIGHT), "bounce") == ["nothing that can be seen is lit"]


def test_an_empty_view_needs_nothing():
    empty = facts(is_empty=True)
    assert running(RICH, facts=empty) == set()
    assert is_open(decided_of(RICH, ("visibility",), empty))


ALONE = facts(is_alone=True)


def test_where_nothing_is_near_there_is_no_bounce_and_no_march():
    sky = content(lights=(LAMP, LAMP))
    effects = decided_of(sky, facts=ALONE)
    assert is_open(effects) and effects.runs("directional")
    assert not effects.runs("bounce") and not effects.runs("back_layer")
    assert len(reasons(effects, "blocked directions")) == 1
    crowded = decided_of(sky, facts=CROWDED)
    assert not is_open(crowded) and crowded.runs("bounce")


def test_the_estimator_without_a_radius_is_never_open():
    view = ALONE
    assert not decided_of(RICH, ("visibility",), view, method="ssao", estimator="zbuffer").spares(
        "blocked directions"
    )
    assert decided_of(RICH, ("visibility",), view, method="ssao", estimator="rgs09").spares(
        "blocked directions"
    )


SKY = content(environment="constant", lights=(LAMP,))


def test_lights_alone_need_no_other_directions():
    room = content(environment="none")
    assert decided_of(room).spares("hemisphere")
    assert not decided_of(room, ("beauty", "visibility")).spares("hemisphere")
    assert not decided_of(RICH).spares("hemisphere")
    assert not decided_of(room, estimator="rgs09").spares("hemisphere")


def test_one_march_serves_two_passes():
    assert shares_directions(decided_of(RICH))
    # Kept as 14 bits for each side of the picture.
    assert MAX_SIZE_PX == 1 << 14
    assert shares_directions(decided_of(RICH, size=(MAX_SIZE_PX, 16)))
    assert shares_directions(decided_of(SKY))
    assert not shares_directions(decided_of(RICH, method="ssdo"))
    lamp = content(environment="none", lights=(LAMP,))
    assert not shares_directions(decided_of(lamp))
    assert shares_directions(decided_of(lamp, ("beauty", "visibility")))
    # The window's lights have directions of their own.
    assert not shares_directions(decided_of(content(environment="none")))


@pytest.mark.parametrize(
    "changes",
    [
        {"estimator": "rgs09"},
        {"effects": "full"},
        {"samples": 256},
        {"steps": 2, "samples": 16},
        {"overrides": {"bounce.radius": 0.1}},
        {"overrides": {"directional.steps": 4}},
        {"overrides": {"bounce.estimator": "rgs09", "directional.estimator": "rgs09"}},
    ],
)
def test_marches_that_differ_are_not_shared(changes):
    assert not shares_directions(decided_of(RICH, **changes))


def test_the_same_override_on_both_sides_is_shared():
    both = {"bounce.bias": 0.01, "directional.bias": 0.01, "bounce.strength": 2.0}
    assert shares_directions(decided_of(RICH, overrides=both))


def sends_emission(content, **settings):
    request = request_of(content, **settings)
    decide(request)
    return request.runs("emission") and Emission().sends(request)


def test_emission_is_read_only_where_something_emits():
    assert decided_of(RICH).runs("emission") and not sends_emission(RICH)
    assert not decided_of(content(has_emission=False)).runs("emission")
    elsewhere = dataclasses.replace(CROWDED, emission_region=None)
    assert decided_of(RICH, facts=CROWDED).runs("emission")
    assert not decided_of(RICH, facts=elsewhere).runs("emission")
    glowing = content(has_unlit_emission=True)
    assert sends_emission(glowing) and sends_emission(RICH, effects="full")


def test_rays_look_for_what_glows_with_gi_alone():
    glowing = content(has_unlit_emission=True, has_glow=True)
    shapes = content(has_stand_ins=True)
    for holds in (glowing, shapes):
        assert decided_of(holds, method="gi").runs("emitters")
        assert not decided_of(holds, method="bounce").runs("emitters")
        assert not decided_of(holds, method="gi", facts=facts(is_empty=True)).runs("emitters")
    assert not decided_of(RICH, method="gi").runs("emitters")
    # It is direct light then, which marches do not bring once more.
    assert not sends_emission(glowing, method="gi")
    glossy = content(has_stand_ins=True, has_gloss=True)
    assert decided_of(glossy, method="gi").runs("emitters")
    # Rectangles stand for them where rays of lobes find no light, or shadows are traced.
    black = content(has_stand_ins=True, has_gloss=True, has_albedo=False)
    assert not decided_of(black, method="gi").runs("emitters")
    assert not decided_of(shapes, method="gi", shadows="traced").runs("emitters")


def test_references_take_no_notice_of_the_view():
    empty = facts(is_empty=True)
    effects = decided_of(RICH, facts=empty, method="reference-near")
    assert effects.runs("traced_shadows") and effects.runs("reference_near")
    assert effects.lights is None
    assert not shares_directions(effects)


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
    assert ("ssao" in running(content(**changes), method="ssao", combine=combine)) == runs


def test_the_report_adds_traced_visibility_as_light_of_its_own():
    dark = content(lights=(OFF,))
    assert "reference_ao" in running(dark, method="reference-ao", combine="report")


def test_every_decision_has_a_reason_and_no_effect_is_decided_twice():
    views = (None, CROWDED, ALONE, facts(is_empty=True))
    for scene in (RICH, NO_LIGHT, SKY):
        for view in views:
            rows = decided_of(scene, facts=view).rows
            assert all(row.reason and row.effect for row in rows)
            names = [row.effect for row in rows]
            assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("environment", "chosen", "expected"),
    [("none", None, "multiply"), ("map", None, "ambient"), ("map", "report", "report")],
)
def test_what_visibility_multiplies(environment, chosen, expected):
    changed = dataclasses.replace(RICH, environment=environment)
    assert combine_of(request_of(changed, combine=chosen)) == expected

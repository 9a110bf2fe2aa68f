"""The walk over the registry: what is wired to what, and why; no OpenGL needed."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from ssdo_gl.effects.registry import image_names
from ssdo_gl.effects.request import Request, Shortcut
from ssdo_gl.facts.content import analyse
from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.passes.edge_aware_filter import FILTER
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.planning.walk import build, decide
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS

SCENE = load_scene("cornell_meso")
METALS = str(Path(__file__).parents[2] / "benchmarks" / "metals.toml")


def pipeline_of(wanted=("beauty",), scene=SCENE, **settings):
    chosen = Settings(**{"method": "bounce", "radius": 0.3, **settings})
    request = Request(scene, analyse(scene), chosen, wanted)
    decide(request)
    return build(request)


def order_of(pipeline):
    return [item.name for item in compile_graph(pipeline.passes, pipeline.resources).order]


@pytest.mark.parametrize("scene", ["coloured_lights", "corner", "furnace", "courtyard"])
@pytest.mark.parametrize("effects", ["auto", "full"])
@pytest.mark.parametrize("method", METHODS)
def test_every_method_is_wired_soundly(scene, effects, method):
    """`compile_graph` refuses reads and outputs that nobody writes, and two writers."""
    pipeline = pipeline_of(image_names(), load_scene(scene), method=method, effects=effects)
    order = order_of(pipeline)
    assert order[0] == "gbuffer"
    assert set(order) <= set(pipeline.reasons)


def test_passes_follow_what_they_read():
    order = order_of(pipeline_of(("display", "beauty")))
    assert order.index("direct") < order.index("sender_radiance") < order.index("bounce")
    assert order.index(FILTER) < order.index("composite") < order.index("tone_map")


SEPARATE = ["directional_filter", "bounce_filter"]


@pytest.mark.parametrize(
    ("wanted", "settings", "filters"),
    [
        (("display",), {}, [FILTER]),
        (("bounce", "directional"), {}, [FILTER]),
        (("bounce",), {}, ["bounce_filter"]),
        (("display",), {"method": "ssdo"}, ["directional_filter"]),
        (("display",), {"effects": "full"}, [*SEPARATE, "reflections_filter"]),
        (("display",), {"overrides": {"bounce_filter.tap_radius": 4}}, SEPARATE),
        (("display",), {"resolution_scale": 0.5}, [FILTER]),
        (("display",), {"overrides": {"bounce.resolution_scale": 0.5}}, SEPARATE),
    ],
)
def test_one_filter_serves_two_images_where_it_can(wanted, settings, filters):
    pipeline = pipeline_of(wanted, **settings)
    order = order_of(pipeline)
    found = [name for name in order if name == FILTER or name.endswith("_filter")]
    assert found == filters
    assert all(pipeline.reasons[name] for name in order)
    skipped = {"directional_filter", "bounce_filter"} & set(pipeline.skipped)
    assert not skipped & set(filters) and (filters != [FILTER] or not skipped)


@pytest.mark.parametrize(
    ("wanted", "is_summed"),
    [
        (("display",), True),
        (("beauty", "depth"), True),
        (("beauty", "visibility"), False),
        (("display", "bounce"), False),
    ],
)
def test_the_bounce_adds_up_what_only_the_picture_reads(wanted, is_summed):
    pipeline = pipeline_of(wanted)
    (joined,) = (item for item in pipeline.passes if item.name == FILTER)
    (composite,) = (item for item in pipeline.passes if item.name == "composite")
    parts = {"directional_irradiance", "bounce_irradiance"}
    # What only the picture reads is filtered to its end there.
    begun = "filtered_irradiance_before_last"
    assert set(joined.writes) == ({begun} if is_summed else parts)
    assert set(joined.writes) < set(composite.reads)
    (bounce,) = (item for item in pipeline.passes if item.name == "bounce")
    assert ("directional_raw" in bounce.reads) == is_summed
    assert ("directional_raw" in joined.reads) == (not is_summed)
    assert len(set(composite.reads) & (parts | {begun})) == len(joined.writes)


@pytest.mark.parametrize(
    ("wanted", "settings", "is_shown"),
    [
        (("display",), {}, True),
        (("display", "depth"), {"method": "ssao"}, True),
        (("display", "beauty"), {}, False),
        (("display",), {"effects": "full"}, False),
        (("display",), {"method": "reference-gi"}, False),
    ],
)
def test_terms_add_up_to_what_a_display_shows_where_only_that_is_read(wanted, settings, is_shown):
    pipeline = pipeline_of(wanted, **settings)
    order = order_of(pipeline)
    assert ("tone_map" in order) == (not is_shown)
    assert ("tone_map" in pipeline.skipped) == is_shown
    (composite,) = (item for item in pipeline.passes if item.name == "composite")
    assert set(composite.writes) == {"display" if is_shown else "beauty"}


FEW = {"samples": 16, "steps": 4, "resolution_scale": 0.5}


@pytest.mark.parametrize(
    ("scene", "settings", "is_summed"),
    [
        ("cornell_meso", FEW, True),
        ("cornell_meso", {**FEW, "samples": 20}, False),
        ("cornell_meso", {**FEW, "resolution_scale": 1.0}, False),
        ("cornell_meso", {**FEW, "estimator": "bitmask"}, False),
        ("cornell_meso", {**FEW, "effects": "full"}, False),
        (METALS, FEW, False),
    ],
)
def test_the_bounce_adds_up_what_few_senders_send(scene, settings, is_summed):
    pipeline = pipeline_of(("display",), load_scene(scene), **settings)
    assert ("sender_radiance" in order_of(pipeline)) == (not is_summed)
    assert ("sender_radiance" in pipeline.skipped) == is_summed
    (bounce,) = (item for item in pipeline.passes if item.name == "bounce")
    assert ("albedo" in bounce.reads) == is_summed


@pytest.mark.parametrize(
    ("wanted", "scene", "settings", "writes"),
    [
        (("display",), "cornell_meso", {}, "filtered_irradiance_before_last"),
        (("display",), "cornell_meso", {"method": "ssdo"}, "directional_irradiance_before_last"),
        (("display",), "cornell_meso", FEW, "filtered_irradiance_before_last"),
        (("display",), "cornell_meso", {"filter": "naive"}, None),
        (("display",), "cornell_meso", {"filter": "none"}, None),
        (
            ("display",),
            "cornell_meso",
            {**FEW, "filter": "naive"},
            "filtered_irradiance_before_last",
        ),
        (("display", "directional"), "cornell_meso", {"method": "ssdo"}, "directional_irradiance"),
        (("display",), METALS, {}, "filtered_irradiance_before_last"),
        (("display",), "cornell_meso", {"method": "ssao"}, "visibility"),
    ],
)
def test_a_filter_ends_where_only_the_picture_reads_it(wanted, scene, settings, writes):
    pipeline = pipeline_of(wanted, load_scene(scene), **settings)
    filters = ("ssao_filter", "directional_filter", FILTER)
    order = compile_graph(pipeline.passes, pipeline.resources).order
    written = [name for item in order if item.name in filters for name in item.writes]
    assert written == ([] if writes is None else [writes])
    (composite,) = (item for item in pipeline.passes if item.name == "composite")
    assert (writes or "bounce_raw") in composite.reads
    assert (FILTER in pipeline.skipped) == (writes is None)


def test_the_g_buffer_writes_what_is_read():
    (depth_only,) = (p for p in pipeline_of(("depth",)).passes if p.name == "gbuffer")
    assert set(depth_only.writes) == {"z_vs"}
    (all_of_it,) = (
        p for p in pipeline_of(("depth",), effects="full").passes if p.name == "gbuffer"
    )
    assert set(all_of_it.writes) == set(GBufferPass.TARGETS)


def test_images_that_no_running_effect_has_are_neutral():
    outputs = pipeline_of(("bounce", "depth"), method="ssdo").outputs
    assert outputs["bounce"].resource is None and outputs["bounce"].neutral == 0.0
    assert outputs["depth"].resource == "z_vs"


def test_the_path_tracer_is_the_picture_and_its_terms_are_not():
    pipeline = pipeline_of(("beauty", "display", "direct"), method="reference-gi")
    assert pipeline.outputs["beauty"].resource == "gi_radiance"
    assert "composite" not in order_of(pipeline)
    assert pipeline.outputs["direct"].resource == "direct_radiance"


def test_skipped_passes_have_the_reason_of_the_decision_that_spared_them():
    dark = dataclasses.replace(SCENE, lights=(), environment=None)
    skipped = pipeline_of(scene=dark).skipped
    assert skipped["direct"] == "the scene has no light that is on"
    assert skipped["directional"].startswith("there is neither an environment nor")
    assert not pipeline_of(scene=dark, effects="full").skipped


def test_a_shortcut_that_nobody_declared_is_refused_once_all_is_decided():
    request = Request(SCENE, analyse(SCENE), Settings(radius=0.3), ("beauty",))
    early = Shortcut("early", lambda _: "why not", ())
    assert request.takes(early)
    decide(request)
    assert request.takes(early), "what was settled before may be asked about again"
    with pytest.raises(LookupError, match="'late'"):
        request.takes(Shortcut("late", lambda _: "why not", ()))


@pytest.mark.parametrize("method", ["bounce", "ssao", "reference-near"])
def test_a_sky_of_one_colour_is_one_decision_whatever_casts_shadows(method):
    """Tables of rays hold the sky as it is: what follows from its kind must ask the same."""
    from ssdo_gl.scene.environment.environment_kinds import GradientEnvironment

    uniform = GradientEnvironment(*[(0.5, 0.5, 0.5)] * 3)
    scene = dataclasses.replace(SCENE, environment=uniform)
    for shadows in ("map", "traced", "none"):
        order_of(pipeline_of(image_names(), scene, method=method, shadows=shadows))

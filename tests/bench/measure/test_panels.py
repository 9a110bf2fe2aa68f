"""Panels and grid follow from the registry: an effect is one row there and none here."""

from __future__ import annotations

from bench.fake_bench import bench

from ssdo_gl.bench.analysis import as_row
from ssdo_gl.bench.measure.panels import all_aovs, error_panels
from ssdo_gl.bench.measure.points import Point, read_grid
from ssdo_gl.bench.references import converged_march
from ssdo_gl.bench.report.page import report_html
from ssdo_gl.effects.effect import Effect, Term
from ssdo_gl.effects.registry import registered


class Toy(Effect):
    """An effect with a term of the picture and an image of its own."""

    name = "toy"
    methods = frozenset({"bounce", "reference-near"})
    terms = (Term("glow", "toy_glow"),)
    images = ("openness",)

    def need(self, request):
        raise AssertionError("nothing is rendered here")

    def passes(self, request):
        raise AssertionError("nothing is rendered here")


def test_each_reference_judges_what_it_makes():
    near, gi, visibility = error_panels()
    assert (near.name, near.method, near.aov) == ("near", "reference-near", "beauty")
    assert near.parts == ("direct", "specular", "directional", "bounce"), "emitters are not judged"
    assert near.relative and near.own_radius
    assert (gi.name, gi.method, gi.parts) == ("gi", "reference-gi", ())
    assert not gi.own_radius, "a path knows no R"
    assert gi.is_all_light and "all light transport" in gi.title
    assert not near.is_all_light
    assert (visibility.name, visibility.method) == ("visibility", "reference-ao")
    assert visibility.kind == visibility.aov == "visibility" and not visibility.relative
    assert all_aovs([near, gi]) == ("beauty", "direct", "specular", "directional", "bounce")


def test_a_point_is_held_to_what_it_can_reach():
    near, gi, visibility = error_panels()
    march = Point("radiance", "f", "bounce", "march")
    assert [p.judges(march) for p in (near, gi, visibility)] == [True, True, False]
    wide = Point("radiance", "f", "bounce", "march", radius_factor=2.0)
    assert [p.judges(wide) for p in (near, gi, visibility)] == [False, True, False]
    paths = Point("radiance", "f", "reference-gi", spp=4)
    all_light = Point("radiance", "f", "gi", "march")
    for point in (paths, all_light):
        assert [p.judges(point) for p in (near, gi, visibility)] == [False, True, False]
    assert visibility.judges(Point("visibility", "f", "ssao", "hemisphere"))


def test_what_is_converged_has_the_light_that_the_reference_has():
    near, gi, visibility = error_panels()
    methods = [converged_march(panel).method for panel in (near, gi, visibility)]
    assert methods == ["bounce", "gi", "ssao"]


def test_all_light_is_part_of_the_sweep_and_of_its_quick_form():
    points = [p for p in read_grid() if p.method == "gi" and p.estimator == "march"]
    assert {p.resolution_scale for p in points} == {0.5, 1.0}
    assert {p.resolution_scale for p in points if p.quick} == {0.5, 1.0}


def test_an_effect_appears_in_panels_grid_and_report_by_being_registered():
    before = read_grid()
    with registered(Toy()):
        near = error_panels()[0]
        assert near.parts == ("direct", "specular", "directional", "bounce", "glow")
        toy = error_panels()[-1]
        assert (toy.name, toy.method, toy.aov) == ("openness", "reference-near", "openness")
        added = [point for point in read_grid() if point not in before]
        assert {(p.kind, p.method, p.wanted) for p in added} == {
            ("openness", "bounce", ("openness",))
        }
        assert any(p.quick for p in added)
        assert all(toy.judges(p) for p in added)
        assert converged_march(toy).method == "bounce"
        found = bench()
        assert "openness error" in report_html(found) and ">glow<" in report_html(found)
        assert "openness_error" in as_row(found.results[0])
    assert read_grid() == before
    assert "glow" not in error_panels()[0].parts

"""The declared grid: products, names and settings."""

from __future__ import annotations

from ssdo_gl.bench.measure.panels import error_panels
from ssdo_gl.bench.measure.points import Point, read_grid
from ssdo_gl.bench.presets import FIELDS, read_ladder
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS

BASE = Settings(size=(64, 36), radius=0.3, seed=5)


def grid_of(tmp_path, text: str) -> tuple[Point, ...]:
    path = tmp_path / "grid.toml"
    path.write_text(text, encoding="utf-8")
    return read_grid(path)


def test_every_point_of_the_shipped_grid_can_be_rendered():
    grid = read_grid()
    assert len({point.key for point in grid}) == len(grid)
    for point in grid:
        settings = point.settings(BASE)
        assert settings.method == point.method
        assert settings.antialias == 1


def test_the_shipped_grid_covers_every_estimator_and_the_axes():
    grid = read_grid()
    for name, method in METHODS.items():
        measured = {point.estimator for point in grid if point.method == name}
        every = set(method.estimators or [None])
        assert measured == every, "the file names most, the registry the rest"
    for axis in ("samples", "steps", "resolution_scale", "filter", "radius_factor"):
        assert len({getattr(point, axis) for point in grid}) > 1, axis
    quick = [point for point in grid if point.quick]
    assert 10 <= len(quick) < len(grid)
    assert {point.kind for point in quick} == {panel.kind for panel in error_panels()}


def test_the_quick_sweep_holds_the_presets():
    ladder = read_ladder()
    quick = [point for point in read_grid() if point.quick and point.method == "bounce"]
    measured = [{name: getattr(point, name) for name in FIELDS} for point in quick]
    for name, number in ladder.presets.items():
        assert ladder.rungs[number].fields() in measured, name


def test_a_family_is_the_product_of_its_lists(tmp_path):
    grid = grid_of(
        tmp_path,
        """
        [[family]]
        name = "f"
        kind = "radiance"
        method = "bounce"
        estimator = "march"
        samples = [4, 8, 16]
        steps = [4, 8]
        filter = "edge"
        [family.quick]
        samples = [8]
        """,
    )
    # 4 samples cannot hold 8 steps: 3 * 2 - 1.
    assert [(p.samples, p.steps) for p in grid] == [(4, 4), (8, 4), (8, 8), (16, 4), (16, 8)]
    assert [p.quick for p in grid] == [False, True, True, False, False]


def test_a_shared_point_is_measured_once(tmp_path):
    family = '[[family]]\nname = "{}"\nkind = "radiance"\nmethod = "direct"\n'
    grid = grid_of(tmp_path, family.format("a") + family.format("b") + "[family.quick]\n")
    assert [(p.family, p.quick) for p in grid] == [("a", True)]


def test_overrides_reach_the_settings_and_the_name(tmp_path):
    (point,) = grid_of(
        tmp_path,
        '[[family]]\nname = "f"\nkind = "radiance"\nmethod = "bounce"\nestimator = "rgs09"\n'
        'samples = 8\nset = { "bounce.thickness" = 0.2 }\n',
    )
    assert point.settings(BASE).overrides == {"bounce.thickness": 0.2}
    assert "thickness=0.2" in point.label
    assert "bounce.thickness=0.2" in point.key


def test_settings_of_a_point():
    point = Point("radiance", "f", "bounce", "march", 32, 8, 0.5, "edge", radius_factor=2.0)
    settings = point.settings(BASE, seed_offset=3)
    assert (settings.samples, settings.steps, settings.resolution_scale) == (32, 8, 0.5)
    assert (settings.filter, settings.radius, settings.seed) == ("edge", 0.6, 8)
    assert settings.size == BASE.size
    assert point.label == "bounce march 4x8 half edge R x2"
    assert point.wanted == ("beauty",)

"""The panel's controls come from the settings: same fields, same ranges, same checks."""

from __future__ import annotations

import dataclasses
import math

import pytest

from ssdo_gl.effects.registry import pass_settings
from ssdo_gl.options.flags import build_parser
from ssdo_gl.options.resolve import resolved
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import Kind, SettingError, describe
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.window.panel.control_rows import (
    ControlRow,
    default_of,
    first_value,
    ignored_because,
    main_rows,
    pass_rows,
    value_of,
    with_value,
)

ALL_ROWS = [*main_rows(Settings()), *(row for rows in pass_rows().values() for row in rows)]


def ids(row: ControlRow) -> str:
    return row.key


def test_every_setting_has_a_control_or_a_reason_to_have_none() -> None:
    shown = {row.key for row in main_rows(Settings())}
    assert set(describe(Settings)) - shown == {"method", "size", "overrides", "antialias"}
    for name, settings_class in pass_settings().items():
        own = set(describe(settings_class)) - set(describe(Settings))
        assert {row.field for row in pass_rows().get(name, [])} == own


@pytest.mark.parametrize("row", ALL_ROWS, ids=ids)
def test_both_ends_of_a_control_are_allowed(row: ControlRow) -> None:
    values = {
        Kind.TEXT: row.choices,
        Kind.BOOLEAN: (True, False),
        Kind.INTEGER: (int(row.low), int(row.high)),
        Kind.NUMBER: (row.low, row.high),
    }[row.kind]
    assert values
    for value in values:
        changed = with_value(Settings(), row, value)
        assert value_of(changed, row) == value


@pytest.mark.parametrize(
    "row", [row for row in ALL_ROWS if row.kind in (Kind.INTEGER, Kind.NUMBER)], ids=ids
)
def test_what_the_command_line_refuses_the_panel_refuses(row: ControlRow) -> None:
    settings_class = pass_settings()[row.pass_name] if row.pass_name else Settings
    info = describe(settings_class)[row.field]
    beyond = [(info.low, -1), (info.high, 1)]
    beyond = [(bound, step) for bound, step in beyond if bound is not None]
    assert beyond
    for bound, step in beyond:
        with pytest.raises(SettingError, match=row.field):
            with_value(Settings(), row, type(bound)(bound + step))


@pytest.mark.parametrize("row", ALL_ROWS, ids=ids)
def test_default_is_a_value_of_the_control(row: ControlRow) -> None:
    default = default_of(row)
    assert value_of(Settings(), row) == default
    if default is None:
        assert row.is_optional
        assert with_value(Settings(), row, first_value(row)) != Settings()
    elif row.kind in (Kind.INTEGER, Kind.NUMBER) and math.isfinite(default):
        assert row.low <= default <= row.high


@pytest.mark.parametrize("row", main_rows(Settings()), ids=ids)
def test_hint_names_a_flag_that_exists(row: ControlRow) -> None:
    flag = row.hint.splitlines()[-1]
    known = {option for action in build_parser()._actions for option in action.option_strings}
    assert flag in known


def test_going_back_to_the_default_leaves_no_override() -> None:
    row = next(row for row in ALL_ROWS if row.key == "bounce.strength")
    changed = with_value(Settings(), row, 2.0)
    assert changed.overrides == {"bounce.strength": 2.0}
    assert with_value(changed, row, default_of(row)) == Settings()


@pytest.mark.parametrize("method", METHODS)
def test_estimators_are_those_of_the_method(method: str) -> None:
    rows = [row for row in main_rows(Settings(method=method)) if row.key == "estimator"]
    choices = [row.choices for row in rows]
    estimators = METHODS[method].estimators
    assert choices == ([estimators] if estimators else [])


def test_unit_is_part_of_the_label() -> None:
    labels = {row.key: row.label for row in ALL_ROWS}
    assert labels["radius"] == "radius (scene units)"
    assert labels["exposure"] == "exposure (EV)"


def test_wide_ranges_are_logarithmic() -> None:
    by_key = {row.key: row for row in ALL_ROWS}
    assert by_key["samples"].is_log
    assert not by_key["exposure"].is_log
    assert dataclasses.astuple(by_key["exposure"])[3:5] == (-10.0, 10.0)


def test_going_back_to_a_default_is_going_back_to_the_scene() -> None:
    scene = dataclasses.replace(load_scene("corner"), render={"radius": 0.2, "samples": 16})
    settings = resolved(Settings(radius=0.7, samples=32), scene)
    row = next(row for row in ALL_ROWS if row.key == "radius")
    again = resolved(with_value(settings, row, None), scene)
    assert (again.radius, again.samples) == (0.2, 32)


@pytest.mark.parametrize(
    ("method", "ignored", "used"),
    [
        ("bounce", ("spp", "bounces", "shadow_rays", "combine"), ("samples", "radius", "filter")),
        ("direct", ("samples", "radius", "far_field.tile"), ("exposure", "seed", "direct.x")),
        ("gi", ("spp", "ssao.x", "reference_gi.x"), ("far_field.x", "surface_cache.x", "bounce.x")),
        ("bounce", ("surface_cache.x", "traced_shadows.x"), ("shadow_map.x", "tone_map.x")),
        ("reference-near", ("samples", "filter"), ("spp", "radius", "shadow_rays")),
        ("reference-gi", ("radius", "steps", "temporal.x", "shadow_map.x"), ("bounces", "spp")),
    ],
)
def test_settings_without_effect_say_why(
    method: str, ignored: tuple[str, ...], used: tuple[str, ...]
) -> None:
    settings = Settings(method=method)
    assert all(ignored_because(settings, name) for name in ignored)
    # Another image may ask for what the picture does without; that of references is by rays.
    by_ssao = ignored_because(settings, "ssao.x", image="visibility")
    assert bool(by_ssao) == settings.is_reference
    assert not any(ignored_because(settings, name) for name in used)

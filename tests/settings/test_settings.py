"""Each setting is declared once: flags, scenes, presets, panel and docs say the same of it."""

from __future__ import annotations

import dataclasses
import math
import pydoc

import pytest
from documentation.pages import settings_table

from ssdo_gl.effects.registry import image_names, pass_settings
from ssdo_gl.options.flags import build_parser, read_command
from ssdo_gl.options.pass_settings import passes_without_settings
from ssdo_gl.options.preset_files import preset_fields, preset_text
from ssdo_gl.options.run_options import RunOptions
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings import Settings, modes
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.fields import (
    FLOAT32_MAX,
    Kind,
    SettingError,
    describe,
    from_file,
    value_text,
)
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.settings.settings import same_as
from ssdo_gl.window.panel.control_rows import default_of, main_rows

FIELDS = describe(Settings)
PLAIN = [name for name, info in FIELDS.items() if info.kind is not Kind.MAPPING]
SPHERE = '[[object]]\nshape = "sphere"\nradius = 1\n'


def toml(value):
    if isinstance(value, tuple):
        return f"[{value[0]}, {value[1]}]"
    return f"'{value}'" if isinstance(value, str) else repr(value)


def method_of(estimator):
    """Return a method that has an estimator."""
    return next((name for name, m in METHODS.items() if estimator in m.estimators), "ssao")


def in_scene(name, value):
    """Return what a scene's [render] table makes of a value; SettingError where refused."""
    method = ""
    if name == "estimator":
        method = f"method = '{method_of(value)}'\n"
    try:
        text = f"[render]\n{method}{name} = {toml(value)}\n{SPHERE}"
        return read_description(text, "a.toml").render[name]
    except SceneError as error:
        raise SettingError(str(error)) from None


def by_flag(name, value):
    """Return what a flag makes of a value; SettingError where refused."""
    info = FIELDS[name]
    mode = ["--snapshot", "a.png"] if modes.SNAPSHOT in info.modes else []
    return read_command([*mode, f"{info.flag}={value_text(value)}"]).settings[name]


def in_python(name, value):
    return getattr(Settings(**{name: value}), name)


def in_preset(name, value):
    return from_file(Settings, name, list(value) if isinstance(value, tuple) else value)


READERS = (by_flag, in_scene, in_python, in_preset)


def good_values(info):
    if info.choices:
        return info.choices
    low = -FLOAT32_MAX if info.low is None else info.low
    high = FLOAT32_MAX if info.high is None else info.high
    if info.kind is Kind.SIZE:
        return (low, low), (high, low)
    return low, high, *info.also


def bad_values(info):
    if info.kind is Kind.TEXT:
        return ("nonsense",)
    if info.choices:
        return 0.7, -1.0
    if info.kind is Kind.SIZE:
        return (info.low - 1, info.low), (info.high + 1, info.low)
    beyond = {math.nan, -math.inf, math.inf} - set(info.also)
    if info.kind is Kind.INTEGER:
        return info.low - 1, info.high + 1
    return *beyond, info.low - max(1.0, abs(info.low)), info.high * 2.0, 1e300


@pytest.mark.parametrize("name", PLAIN)
@pytest.mark.parametrize("read", READERS)
def test_every_way_takes_the_same_values(name, read):
    for value in good_values(FIELDS[name]):
        assert read(name, value) == value


@pytest.mark.parametrize("name", PLAIN)
@pytest.mark.parametrize("read", READERS)
def test_every_way_refuses_the_same_values_in_the_same_words(name, read):
    for value in bad_values(FIELDS[name]):
        with pytest.raises(SettingError) as caught:
            read(name, value)
        message = str(caught.value)
        assert f"expected {FIELDS[name].expected}" in message, message
        assert "\n" not in message


@pytest.mark.parametrize("name", PLAIN)
def test_panel_has_the_declared_ends_and_choices(name):
    rows = {row.key: row for row in main_rows(Settings())}
    if name not in rows:
        assert name in ("method", "size", "antialias"), "the window has a place for these"
        return
    row, info = rows[name], FIELDS[name]
    assert set(row.choices) <= set(info.choices)
    assert default_of(row) == info.default
    assert info.doc in row.hint and info.range_text in row.hint
    assert row.hint.endswith(info.flag)


@pytest.mark.parametrize("name", list(FIELDS))
def test_help_and_docs_tell_of_every_setting(name):
    info = FIELDS[name]
    action = next(a for a in build_parser()._actions if info.flag in a.option_strings)
    assert action.help.replace("%%", "%").startswith(info.doc)
    if info.default is not None and info.kind is not Kind.MAPPING:
        assert f"default {value_text(info.default)}" in action.help
    starts = f"| `{info.flag} ", f"| `{info.flag}`"
    row = next(r for r in settings_table().splitlines() if r.startswith(starts))
    assert info.doc in row
    assert all(f"`{value_text(choice)}`" in row for choice in info.choices)


@pytest.mark.parametrize("name", PLAIN)
def test_presets_hold_what_is_quality(name):
    info = FIELDS[name]
    assert (name in preset_fields(Settings())) == info.is_quality
    value = good_values(info)[-1]
    text = preset_text(Settings(**{name: value}), {"method": "ssao"})
    is_written = any(line.startswith(f"{name} =") for line in text.splitlines())
    assert is_written == (info.is_quality and (name == "method" or value != info.default))


def test_every_setting_of_a_rendering_can_stand_in_a_scene():
    assert [name for name, info in FIELDS.items() if not info.in_scene] == ["overrides"]


@pytest.mark.parametrize("owner", [Settings, RunOptions, *dict.fromkeys(pass_settings().values())])
def test_declarations_are_whole(owner):
    for name, info in describe(owner).items():
        assert info.doc and info.name == name
        if info.kind is Kind.INTEGER and not info.choices:
            assert info.low is not None and info.high is not None, name
        assert info.default is None or info.allows(info.default), name
        if owner in (Settings, RunOptions):
            assert info.modes and info.group, name
            assert info.kind is Kind.BOOLEAN or info.metavar or info.choices, name


@pytest.mark.parametrize("owner", list(dict.fromkeys(pass_settings().values())))
def test_passes_repeat_no_range(owner):
    """What a pass has in common with the rendering has its unit, range and choices, too."""
    for name, info in describe(owner).items():
        if name in FIELDS and name != "estimator":
            common = FIELDS[name]
            for part in ("unit", "low", "high", "choices", "also", "kind"):
                assert getattr(info, part) == getattr(common, part), (name, part)


def test_a_field_of_a_pass_may_have_a_default_and_words_of_its_own():
    @dataclasses.dataclass(frozen=True)
    class Example:
        radius: float = same_as("radius", 0.3, "how far")

    info = describe(Example)["radius"]
    assert (Example().radius, info.default, info.doc, info.unit) == (
        0.3,
        0.3,
        "how far",
        "scene units",
    )
    assert not info.is_optional and FIELDS["radius"].is_optional


def test_names_agree_with_one_another():
    assert {name for method in METHODS.values() for name in method.estimators} == set(ESTIMATORS)
    assert len(set(image_names())) == len(image_names())
    assert not set(pass_settings()) & set(passes_without_settings())


def test_help_says_range_default_and_effect_of_every_field():
    text = pydoc.render_doc(Settings, renderer=pydoc.plaintext)
    for name, info in describe(Settings).items():
        assert f"{name} : {info.expected}, default {info.default!r}" in text
        assert " ".join(info.doc.split()) in " ".join(text.replace("|", " ").split())


def test_settings_are_hashed_as_they_are_compared():
    first, second = (Settings(size=(8, 8), overrides={"bounce.strength": 2.0}) for _ in range(2))
    assert len({first, second, Settings(samples=48), Settings()}) == 2
    changed = dataclasses.replace(first, overrides={"bounce.strength": 3.0})
    assert hash(changed) != hash(first) and {first: 1}[second] == 1

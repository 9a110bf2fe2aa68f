"""Presets that the window saves are what the command line reads."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import Any

import pytest

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.images.files import OutputError
from ssdo_gl.options.preset_files import (
    is_preset,
    preset_fields,
    preset_text,
    read_preset,
    write_preset,
)
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError, describe


@pytest.mark.parametrize(
    "settings",
    [
        Settings(),
        Settings(method="ssao", estimator="hemisphere", combine="report"),
        Settings(samples=24, steps=6, radius=2.0, resolution_scale=0.5, filter="none"),
        Settings(method="reference-gi", spp=32, bounces=3, shadows="traced", max_error=0.01),
        Settings(exposure=-1.5, seed=7, effects="full"),
        Settings(radius=float("inf")),
        Settings(overrides={"bounce.strength": 2.0, "tone_map.curve": "aces"}),
        Settings(overrides={"directional.thickness": None}),
    ],
)
@pytest.mark.parametrize("scene_settings", [{}, {"samples": 16, "radius": 0.3}])
def test_saved_preset_gives_the_settings_back(
    tmp_path: Path, settings: Settings, scene_settings: dict[str, Any]
) -> None:
    path = tmp_path / "p.toml"
    write_preset(path, settings, scene_settings)
    assert is_preset(path)
    read = settings_for(scene_settings, read_preset(path))
    expected = settings
    if settings.radius is None and "radius" in scene_settings:
        expected = dataclasses.replace(settings, radius=scene_settings["radius"])
    assert read == expected


def test_only_what_was_chosen_is_written() -> None:
    text = preset_text(Settings(samples=32, size=(10, 10), antialias=9), {})
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert lines == ["[settings]", 'method = "gi"', "samples = 32"]


def test_every_quality_is_kept(tmp_path: Path) -> None:
    """A new setting comes into presets by itself: those of the window alone stay out."""
    kept = {name for name, info in describe(Settings).items() if info.is_quality}
    assert set(preset_fields(Settings())) == kept
    assert set(describe(Settings)) - kept == {"size", "antialias", "background", "temporal"}


def test_folder_that_cannot_be_written_to(tmp_path: Path) -> None:
    with pytest.raises(OutputError):
        write_preset(tmp_path / "nowhere" / "p.toml", Settings(), {})


@pytest.mark.parametrize(
    "text",
    [
        "samples = 32\nresolution-scale = 0.5",
        "[settings]\nsamples = 32\nresolution_scale = 0.5",
    ],
)
def test_names_stand_at_the_top_or_in_a_table(tmp_path: Path, text: str) -> None:
    (tmp_path / "p.toml").write_text(text)
    assert read_preset(tmp_path / "p.toml") == {"samples": 32, "resolution_scale": 0.5}


@pytest.mark.parametrize("key", ['"bounce.strength"', "bounce.strength"])
def test_overrides_may_be_dotted(tmp_path: Path, key: str) -> None:
    (tmp_path / "p.toml").write_text(f"[settings.overrides]\n{key} = 2\n")
    assert read_preset(tmp_path / "p.toml") == {"overrides": {"bounce.strength": 2.0}}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sampels = 3", "unknown setting 'sampels'; did you mean 'samples'?"),
        ("samples = 1_000_000", "samples = 1000000: expected a whole number from 1 to 1024"),
        ("samples = '8'", "samples = '8'"),
        ("settings = 3", "settings: expected a table"),
        ("[settings]\n[setings]", "unknown key 'setings' beside [settings]"),
        ("[settings]\n[" + "s" * 800 + "]", "sss... beside [settings]"),
        ("method = 'ssdo'\nestimator = 'zbuffer'", "estimator = 'zbuffer' for method ssdo"),
        ("overrides = 3", "overrides = 3: expected a table"),
        ("overrides = {a = 3}", "overrides: 'a': expected a key like"),
        ("[overrides]\n'bounce.strenght' = 2", "bounce: unknown setting 'strenght'"),
        ("[overrides]\n'bunce.strength' = 2", "unknown pass 'bunce'; did you mean 'bounce'?"),
        ("[overrides]\n'bounce.strength' = -2", "bounce: strength = -2: expected a number"),
        ("[overrides]\n'bounce.strength' = 'x'", "bounce: strength = 'x'"),
        ("[overrides.bounce.strength]\nx = 1", "bounce: strength = {'x': 1}"),
        ("[overrides]\n'gbuffer.x' = 1", "the pass gbuffer has no settings"),
        ("samples = " + "9" * 5000, "a whole number has thousands of digits"),
        ("samples = 0x" + "f" * 5000, "samples = a whole number of thousands of digits"),
        ("samples = " + "[" * 5000 + "]" * 5000, "nested too deeply"),
        ("samples =", "line 1, column 10: not valid TOML"),
    ],
)
def test_whole_file_is_checked_when_it_is_read(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(SettingError) as caught:
        read_preset(path)
    message = str(caught.value)
    assert message.startswith(f"--preset {path}: ") and said in message, message
    assert "\n" not in message
    # A window looks first whether it is one at all.
    assert isinstance(is_preset(path), bool)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("missing.toml", "No such file"),
        ("folder.toml", "Is a directory"),
        ("latin.toml", "byte 9 is not UTF-8 text"),
    ],
)
def test_unreadable_files_are_named(tmp_path: Path, name: str, said: str) -> None:
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes(b"title = '\xe9'")
    with pytest.raises(SettingError, match=f"{name}: {said}"):
        read_preset(tmp_path / name)
    assert not is_preset(tmp_path / name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    os.mkfifo(path)
    assert not is_preset(path)
    with pytest.raises(SettingError, match="is a pipe or device: expected a file"):
        read_preset(path)


def test_the_suffix_may_be_in_capitals(tmp_path: Path) -> None:
    path = tmp_path / "A.TOML"
    path.write_text("[settings]\nsamples = 3")
    assert is_preset(path)
    assert load_preset(str(path)) == {"samples": 3}

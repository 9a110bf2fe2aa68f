"""Presets that the window saves are what the command line reads."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.images.files import OutputError
from ssdo_gl.settings import Settings
from ssdo_gl.settings.resolve import settings_for
from ssdo_gl.window.preset_files import preset_text, save_preset


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
    ],
)
@pytest.mark.parametrize("wishes", [{}, {"samples": 16, "radius": 0.3}])
def test_saved_preset_gives_the_settings_back(
    tmp_path: Path, settings: Settings, wishes: dict[str, Any]
) -> None:
    fields = load_preset(str(save_preset(tmp_path, settings, wishes)))
    overrides = fields.pop("overrides", {})
    read = settings_for(wishes, fields, [f"{key}={value}" for key, value in overrides.items()])
    expected = settings
    if settings.radius is None and "radius" in wishes:
        expected = dataclasses.replace(settings, radius=wishes["radius"])
    assert read == expected


def test_only_what_was_chosen_is_written() -> None:
    text = preset_text(Settings(samples=32, size=(10, 10), antialias=9), {})
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert lines == ["[settings]", 'method = "bounce"', "samples = 32"]


def test_no_preset_is_overwritten(tmp_path: Path) -> None:
    first = save_preset(tmp_path, Settings(), {})
    second = save_preset(tmp_path, Settings(samples=8), {})
    assert (first.name, second.name) == ("preset-001.toml", "preset-002.toml")


def test_folder_that_cannot_be_written_to(tmp_path: Path) -> None:
    with pytest.raises(OutputError):
        save_preset(tmp_path / "nowhere", Settings(), {})

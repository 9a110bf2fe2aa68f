"""What the window copies, the command line reads back as the same settings."""

from __future__ import annotations

import dataclasses
import shlex
from typing import Any

import pytest

from ssdo_gl.options.command_line import camera_text, command_line
from ssdo_gl.options.flags import read_command
from ssdo_gl.options.idle import idle_in_pictures
from ssdo_gl.options.resolve import camera_from_text, settings_for
from ssdo_gl.scene.camera import Camera
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import describe, number_text
from ssdo_gl.settings.loading import LoadOptions


def read_back(command: str, scene_settings: dict[str, Any]) -> Settings:
    """Return the settings that the command line makes of `command`."""
    return settings_for(scene_settings, read_command(shlex.split(command)[1:]).settings)


@pytest.mark.parametrize(
    "settings",
    [
        Settings(),
        Settings(method="ssao", estimator="hemisphere", combine="report"),
        Settings(samples=24, steps=6, radius=0.375, resolution_scale=0.5),
        Settings(size=(640, 360), exposure=-1.5, filter="none", antialias=16, seed=7),
        Settings(method="reference-gi", spp=32, bounces=3),
        Settings(method="reference-near", spp=32, shadows="traced", shadow_rays=4),
        Settings(overrides={"bounce.strength": 2.0, "tone_map.curve": "aces"}),
        Settings(overrides={"directional.thickness": None}),
    ],
)
@pytest.mark.parametrize("scene_settings", [{}, {"radius": 0.3}, {"method": "ssao", "samples": 16}])
def test_settings_survive_the_round_trip(
    settings: Settings, scene_settings: dict[str, Any]
) -> None:
    command = command_line("room", settings, scene_settings=scene_settings, camera=None)
    expected = settings
    for name in ("radius", "estimator", "combine", "exposure"):
        # None means "as the scene scene_settings", which no flag can contradict.
        if getattr(settings, name) is None and name in scene_settings:
            expected = dataclasses.replace(expected, **{name: scene_settings[name]})
    read = read_back(command, scene_settings)
    for name in describe(Settings):
        is_idle = idle_in_pictures(expected, name, ("beauty",))
        assert is_idle or getattr(read, name) == getattr(expected, name), name


def test_defaults_need_no_flags() -> None:
    command = command_line("room", Settings(), scene_settings={}, camera=None)
    assert command == "ssdo-gl room --snapshot view.png"


def test_method_of_the_scene_is_overruled() -> None:
    command = command_line("room", Settings(), scene_settings={"method": "ssao"}, camera=None)
    assert "--method gi" in command


def test_view_is_named_exactly() -> None:
    camera = Camera((-1e5 - 1 / 3, -2.0, 0.1 + 0.2), (1e5, 0.0, -1.0), fov_y=39.6)
    command = command_line(
        "my room.toml", Settings(), scene_settings={}, camera=camera, aov="visibility", seconds=2.5
    )
    read_back = read_command(shlex.split(command)[1:])
    assert read_back.scene == "my room.toml"
    assert (read_back.run.aov, read_back.run.time) == ("visibility", 2.5)
    assert read_back.run.camera is not None
    position, *rest = camera_from_text(read_back.run.camera)
    assert position == pytest.approx(camera.position, rel=5e-15)
    assert (rest, read_back.run.projection) == ([camera.target, 39.6], "perspective")


def test_view_of_parallel_rays_is_named_with_its_height() -> None:
    camera = Camera((0.0, 1.0, 2.0), (0.0, 0.0, 0.0), height=3.5)
    command = command_line("room", Settings(), scene_settings={}, camera=camera)
    assert "--projection orthographic --camera '0,1,2 0,0,0 3.5'" in command


def test_numbers_are_short_and_exact_enough() -> None:
    assert number_text(0.1 + 0.2) == "0.3"
    assert number_text(-0.0) == "0"
    assert camera_text(Camera((0, 0, 3.6), (0, 0, 0))) == "0,0,3.6 0,0,0 40"


def test_the_camera_of_a_file_is_named():
    loading = LoadOptions(camera="from above", two_sided=True)
    command = command_line("a.glb", Settings(), scene_settings={}, camera=None, loading=loading)
    assert "--camera 'from above'" in command
    assert read_command(shlex.split(command)[1:]).loading == loading

"""The TOML scene format."""

from __future__ import annotations

from collections.abc import Callable

from ssdo_gl.scene.formats.scene_format import SceneFormat, lazily
from ssdo_gl.scene.scene import Scene

_DESCRIPTION = f"{__name__}.description"

TOML = SceneFormat("TOML scene", (".toml",), read_scene=lazily(_DESCRIPTION, "read_file"))
# What the built-in scenes are written in, from text that need not be in a file.
read_description: Callable[..., Scene] = lazily(_DESCRIPTION, "read_description")

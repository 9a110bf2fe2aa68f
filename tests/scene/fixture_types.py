"""Types of the fixtures that write and read scene files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from ssdo_gl.scene.scene import Scene

# Writes files by name; returns the path of the last one.
Write = Callable[[Mapping[str, str | bytes]], Path]
# From the text of a scene file, to which a box is added.
SceneOf = Callable[[str], Scene]
# The one line that refuses a source.
ErrorOf = Callable[..., str]

"""Fixtures that write small scene and model files."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from glb_writer import GlbWriter

from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError

BOX = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 2, 3]\n'


@pytest.fixture
def scene_of() -> Callable[[str], Scene]:
    """Return a function from TOML text (a box is added) to the scene."""
    return lambda text: read_description(f"{text}\n{BOX}", "scene.toml")


@pytest.fixture
def error_of() -> Callable[..., str]:
    """Return a function from a source to the one line that refuses it."""

    def error(source: str | Path, *, text: str | None = None) -> str:
        with pytest.raises(SceneError) as caught:
            if text is None:
                load_scene(source)
            else:
                read_description(text, str(source))
        message = str(caught.value)
        assert "\n" not in message
        assert len(message) < 400
        # A cause would be shown to a user as a traceback of somebody else's code.
        assert caught.value.__cause__ is None
        return message

    return error


@pytest.fixture
def glb() -> GlbWriter:
    """An empty .glb with one node that shows mesh 0."""
    return GlbWriter()


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes files by name and returns the last one's path."""

    def save(files: Mapping[str, str | bytes]) -> Path:
        path = tmp_path
        for name, content in files.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return save

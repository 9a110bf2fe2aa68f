"""The TOML scene format: the file as a whole, its names and its example."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from scene.fixture_types import Write

from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene


def scene(text: str) -> Scene:
    return read_description(text, "scene.toml")


def test_a_scene_file_may_start_with_a_byte_order_mark(write: Write) -> None:
    file = write({"s.toml": b"\xef\xbb\xbf" + b'[[object]]\r\nshape = "sphere"\r\nradius = 1\r\n'})
    assert load_scene(file).triangle_count > 0


def test_the_example_of_the_documentation_is_a_scene() -> None:
    page = Path(__file__).parents[4] / "docs" / "scene-format.md"
    example, *_ = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    result = scene(example)
    assert result.notes == ()
    # Six boxes that spin, each about itself, a plane, and the body of the lamp.
    assert sum(item.motion is not None for item in result.objects) == 6
    assert len(result.objects) == 8


@pytest.mark.parametrize(
    "text",
    [
        f"{'a' * 900} = 1\n",
        f'[[object]]\nshape = "sphere"\nradius = 1\nname = "{"a" * 900}"\nmaterial = "x"\n',
        f'[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "{"a" * 900}"\n',
        f'[[object]]\nshape = "sphere"\nradius = 1\n{"a" * 900} = 1\n',
    ],
)
def test_names_of_any_length_leave_errors_short(text: str, error_of: Callable[..., str]) -> None:
    assert len(error_of("scene.toml", text=text)) < 400

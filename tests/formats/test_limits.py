"""What is ordinary is drawn in seconds, and what is not is refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl.scene import batching
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import SceneError

SPHERE = "[[object]]\nshape = 'sphere'\nradius = 1\n"
SPIN = "animate = { spin = [0, 9, 0] }\n"
GLOW = "[materials.glow]\nemission = [1, 1, 1]\n"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (
            f"{SPHERE}repeat = {{ count = 1000000, step = [3, 0, 0] }}\n{SPIN}",
            "1000000 copies that spin, each about itself: at most 10000",
        ),
        (
            f"{GLOW}{SPHERE}material = 'glow'\nrepeat = {{ count = 100000, step = [3, 0, 0] }}\n",
            "triangles, copies included: at most 1048576",
        ),
        (
            SPHERE + "[[light]]\nkind='point'\nposition=[0,0,3]\nintensity=[1,1,1]\n" * 1025,
            "1025 lights: at most 1024",
        ),
    ],
)
def test_what_would_take_minutes_is_refused_by_name(text: str, named: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_description(text, "scene.toml")
    assert named in str(caught.value)


def write_tiles(path: Path, count: int) -> Path:
    """Write a square of count x count tiles in front of the camera, a material for each."""
    lines, materials = [f"mtllib {path.stem}.mtl"], []
    for row in range(count):
        for column in range(count):
            index = row * count + column
            shade = f"{row / count:.3f} {column / count:.3f} 0.5"
            materials.append(f"newmtl m{index}\nKd {shade}\n")
            for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1)):
                lines.append(f"v {column + dx} {row + dy} 0")
            first = 4 * index + 1
            lines.append(f"usemtl m{index}\nf {first} {first + 1} {first + 2} {first + 3}")
    path.with_suffix(".mtl").write_text("".join(materials))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_many_plain_materials_are_drawn_together(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_tiles(tmp_path / "a.obj", 24)
    together = load_scene(path)
    assert len(together.objects) == 1
    assert together.triangle_count == 2 * 24 * 24
    picture = ssdo_gl.render(together, size=(64, 64), aov="albedo")
    monkeypatch.setattr(batching, "MIN_OBJECTS", 10_000)
    apart = load_scene(path)
    assert len(apart.objects) == 24 * 24
    expected = ssdo_gl.render(apart, size=(64, 64), aov="albedo")
    assert np.abs(picture - expected).max() <= 1.0 / 65535.0
    assert expected.max() > 0.5


def test_thousands_of_materials_are_a_matter_of_seconds(tmp_path: Path) -> None:
    scene = load_scene(write_tiles(tmp_path / "a.obj", 71))
    assert len(scene.objects) == 1
    assert len(scene.materials) == 1

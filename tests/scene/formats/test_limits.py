"""What is ordinary is drawn in seconds, and what is not is refused by name."""

from __future__ import annotations

import dataclasses
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter
from PIL import Image

import ssdo_gl
from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.scene.formats import model
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.geometry import batching
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

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


def write_tiles(path: Path, count: int, more: str = "") -> Path:
    """Write a square of count x count tiles in front of the camera, a material for each.

    `more` stands in each material; the texture's coordinates are the same for each tile.
    """
    lines, materials = [f"mtllib {path.stem}.mtl"], []
    lines += [f"vt {x} {y}" for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for row in range(count):
        for column in range(count):
            index = row * count + column
            shade = f"{row / count:.3f} {column / count:.3f} 0.5"
            materials.append(f"newmtl m{index}\nKd {shade}\n{more}")
            for dx, dy in ((0, 0), (1, 0), (1, 1), (0, 1)):
                lines.append(f"v {column + dx} {row + dy} 0")
            first = 4 * index + 1
            corners = " ".join(f"{first + i}/{i + 1}" for i in range(4))
            lines.append(f"usemtl m{index}\nf {corners}")
    path.with_suffix(".mtl").write_text("".join(materials))
    path.write_text("\n".join(lines) + "\n")
    return path


MORE = [
    "",
    "map_Kd t.png\n",
    "map_Kd -clamp on t.png\n",
    "map_Kd -mm 0.1 0.5 t.png\n",
    "map_Kd t.png\nmap_d t.png\n",
    "map_d t.png\nd 0.9\n",
    "Ke 0.1 0.2 0.3\n",
    "Ks 0.5 0.5 0.5\nNs 50\n",
]


@pytest.mark.parametrize("more", MORE)
def test_many_plain_materials_are_drawn_together(
    more: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ramp = np.arange(0, 256, 4, dtype=np.uint8).reshape(8, 8)
    Image.fromarray(ramp).save(tmp_path / "t.png")
    path = write_tiles(tmp_path / "a.obj", 24, more)
    together = load_scene(path)
    # What glows may become a few rectangle lights with bodies of their own.
    assert len(together.objects) <= 33
    assert together.triangle_count == 2 * 24 * 24
    picture = ssdo_gl.render(together, size=(64, 64), aov="albedo")
    monkeypatch.setattr(batching, "MIN_OBJECTS", 10_000)
    apart = load_scene(path)
    assert len(apart.objects) == 24 * 24
    expected = ssdo_gl.render(apart, size=(64, 64), aov="albedo")
    # One step of the sixteen bits that albedo is kept in.
    assert np.abs(picture - expected).max() < 1.01 / 65535.0
    assert expected.max() > 0.15


def test_thousands_of_materials_are_a_matter_of_seconds(tmp_path: Path) -> None:
    scene = load_scene(write_tiles(tmp_path / "a.obj", 71))
    assert len(scene.objects) == 1
    assert len(scene.materials) == 1


def test_images_of_a_model_have_a_limit_in_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model, "MAX_MODEL_TEXELS", 150)
    lines = ["mtllib a.mtl", "v 0 0 0", "v 1 0 0", "v 0 1 0", "vt 0 0"]
    library = ""
    for name in "abab":
        Image.new("L", (10, 10), 255).save(tmp_path / f"{name}.png")
        library += f"newmtl {name}\nmap_Kd {name}.png\n"
        lines += [f"usemtl {name}", "f 1/1 2/1 3/1"]
    (tmp_path / "a.mtl").write_text(library)
    (tmp_path / "a.obj").write_text("\n".join(lines))
    scene = load_scene(tmp_path / "a.obj")
    assert [m.albedo_texture is not None for m in scene.materials] == [True, False]
    notes = [note for note in scene.notes if note.startswith("texture not used")]
    assert len(notes) == 1
    assert "'b.png' is one too many" in notes[0]


def test_triangles_of_a_model_have_a_limit_in_all(
    glb: GlbWriter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model, "MAX_TRIANGLES", 3)
    primitive = glb.triangle()
    glb.json["meshes"] = [{"primitives": [primitive] * 3}]
    assert load_scene(glb.save(tmp_path / "a.glb")).triangle_count == 3
    glb.json["meshes"] = [{"primitives": [primitive] * 4}]
    with pytest.raises(SceneError, match="4 triangles: at most 3 in a file"):
        load_scene(glb.save(tmp_path / "a.glb"))


def test_too_many_triangles_for_rays_are_refused_before_memory_is_taken() -> None:
    scene = read_description(SPHERE, "a.toml")
    copies = np.broadcast_to(np.eye(4), (1 << 20, 4, 4))
    item = dataclasses.replace(scene.objects[0], world_from_object=copies)
    scene = dataclasses.replace(scene, objects=(item,))
    tracemalloc.start()
    try:
        with pytest.raises(SceneError, match="ray tracing takes up to some sixteen million"):
            build_bvh(scene)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1 << 20

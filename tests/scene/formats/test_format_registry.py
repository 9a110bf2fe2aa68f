"""The registry of formats: one row makes a format known everywhere."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.cli import build_parser
from ssdo_gl.scene.formats import FORMATS, Model, SceneFormat
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material

Write = Callable[[dict[str, str | bytes]], Path]
PAGE = Path(__file__).parents[3] / "docs" / "formats.md"


def read_corners(path: Path, where: str) -> Model:
    """Return one triangle: nine numbers."""
    positions = np.array(path.read_text().split(), dtype=np.float64).reshape(3, 3)
    model = Model(materials=[Material(name="toy")])
    mesh = model.add_mesh(positions, np.array([[0, 1, 2]]))
    if mesh is not None:
        model.objects.append(SceneObject(mesh, 0))
    return model


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> None:
    row = SceneFormat("toy", (".toy",), read_corners)
    monkeypatch.setattr("ssdo_gl.scene.formats.format_registry.FORMATS", [*FORMATS, row])


@pytest.mark.usefixtures("toy")
def test_a_row_is_all_that_a_format_needs(write: Write, error_of: Callable[..., str]) -> None:
    files = {
        "a.TOY": "0 0 0 1 0 0 0 1 0",
        "flat.toy": "0 0 0 1 0 0 2 0 0",
        "a.xyz": "",
        "s.toml": '[[object]]\nshape = "mesh"\npath = "a.TOY"\ntransform = { scale = 2 }\n',
    }
    folder = write(files).parent
    assert load_scene(folder / "a.TOY").materials[0].name == "toy"
    assert load_scene(folder / "s.toml").bounds()[1].tolist() == [2, 2, 0]
    assert "no triangle" in error_of(folder / "flat.toy")
    assert error_of(folder / "a.xyz").endswith(".off, .toy")
    assert ".toy" in build_parser().format_help()


def test_a_scene_cannot_place_a_scene(write: Write, error_of: Callable[..., str]) -> None:
    scene = '[[object]]\nshape = "mesh"\npath = "s.toml"\n'
    assert "expected one of .glb, .gltf, .obj" in error_of(write({"s.toml": scene}))


def test_the_documentation_names_every_format() -> None:
    suffixes = [suffix for kind in FORMATS for suffix in kind.suffixes]
    assert len(set(suffixes)) == len(suffixes)
    text = PAGE.read_text(encoding="utf-8")
    named = [f"{kind.title} ({', '.join(f'`{s}`' for s in kind.suffixes)})" for kind in FORMATS]
    assert [title for title in named if title not in text] == []


def test_every_row_reads_models_or_scenes() -> None:
    assert all((kind.read_model is None) != (kind.read_scene is None) for kind in FORMATS)

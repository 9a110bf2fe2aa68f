"""The registry of formats: one module makes a format known everywhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from scene.fixture_types import Write

from ssdo_gl.cli import build_parser
from ssdo_gl.scene import formats
from ssdo_gl.scene.formats import FORMATS, format_registry
from ssdo_gl.scene.load import load_scene

PAGE = Path(__file__).parents[3] / "docs" / "formats.md"


# Reads one triangle: nine numbers.
TOY = """
from pathlib import Path
import numpy as np
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.scene_format import SceneFormat
from ssdo_gl.scene.geometry import Mesh, SceneObject
from ssdo_gl.scene.material import Material

def read_corners(path: Path, where: str) -> Model:
    positions = np.array(path.read_text().split(), dtype=np.float64).reshape(3, 3)
    model = Model(materials=[Material(name="toy")])
    mesh = model.add_mesh(Mesh(positions, np.array([[0, 1, 2]])))
    if mesh is not None:
        model.objects.append(SceneObject(mesh, 0))
    return model

TOY = SceneFormat("toy", (".toy",), read_corners)
"""


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    """A module in the folder of formats, which is all that makes it one."""
    folder = tmp_path / "formats"
    folder.mkdir()
    (folder / "toy.py").write_text(TOY, encoding="utf-8")
    monkeypatch.setattr(formats, "__path__", [*formats.__path__, str(folder)])
    monkeypatch.setattr(format_registry, "FORMATS", format_registry.found_formats())
    yield
    del sys.modules["ssdo_gl.scene.formats.toy"]


@pytest.mark.usefixtures("toy")
def test_a_module_is_all_that_a_format_needs(write: Write, error_of: Callable[..., str]) -> None:
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


def test_every_format_reads_models_or_scenes() -> None:
    assert all((kind.read_model is None) != (kind.read_scene is None) for kind in FORMATS)

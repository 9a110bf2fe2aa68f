"""Options of texture statements: scale, offset, range and clamping, for each image alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from image_bytes import GREYS
from numpy.typing import NDArray
from PIL import Image

import ssdo_gl
from ssdo_gl.color import linear_from_srgb
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 90.0)
LINEAR = linear_from_srgb(GREYS / 255.0)


def card(folder: Path, library: str) -> Scene:
    """Return a square of -1..1 whose texture coordinates run from 0 to 1, seen from in front."""
    Image.fromarray(np.kron(GREYS, np.ones((8, 8), np.uint8))).save(folder / "g.png")
    (folder / "a.mtl").write_text(f"newmtl m\nKd 1 1 1\n{library}")
    (folder / "a.obj").write_text(
        "mtllib a.mtl\nusemtl m\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n"
    )
    return dataclasses.replace(load_scene(folder / "a.obj"), camera=CAMERA)


def shown(scene: Scene, aov: str) -> NDArray[np.float64]:
    """Return what the middles of 4 x 4 squares show."""
    image = ssdo_gl.render(scene, size=(32, 32), aov=aov)
    return np.asarray(image[4::8, 4::8, 0], dtype=np.float64)


@pytest.mark.parametrize(
    ("options", "rows", "columns"),
    [
        ("", [0, 0, 1, 1], [0, 0, 1, 1]),
        ("-s 2 2 1", [0, 1, 0, 1], [0, 1, 0, 1]),
        ("-s 2", [0, 0, 1, 1], [0, 1, 0, 1]),
        ("-o 0.5", [0, 0, 1, 1], [1, 1, 0, 0]),
        ("-o 0 0.25 0", [1, 0, 0, 1], [0, 0, 1, 1]),
        ("-s 2 1 1 -o 0.5 0 0", [0, 0, 1, 1], [1, 0, 1, 0]),
        ("-clamp on -s 2 1 1", [0, 0, 1, 1], [0, 1, 1, 1]),
        ("-clamp on -o 0.5 -0.5", [1, 1, 1, 1], [1, 1, 1, 1]),
        ("-blendu off -bm 1 -s 2 2 -imfchan m", [0, 1, 0, 1], [0, 1, 0, 1]),
    ],
)
def test_scale_offset_and_clamp(
    options: str, rows: list[int], columns: list[int], tmp_path: Path
) -> None:
    scene = card(tmp_path, f"map_Kd {options} g.png\n")
    assert shown(scene, "albedo") == pytest.approx(LINEAR[rows][:, columns], abs=3e-3)


def test_base_and_gain(tmp_path: Path) -> None:
    scene = card(tmp_path, "map_Kd -mm 0.25 0.5 g.png\n")
    expected = linear_from_srgb(np.rint(0.25 * 255 + 0.5 * GREYS) / 255.0)
    assert shown(scene, "albedo")[::2, ::2] == pytest.approx(expected, abs=3e-3)


def test_each_image_has_its_own_options(tmp_path: Path) -> None:
    scene = card(tmp_path, "map_Kd g.png\nmap_Ke -s 2 2 g.png\n")
    assert shown(scene, "albedo") == pytest.approx(np.kron(LINEAR, np.ones((2, 2))), abs=3e-3)
    assert shown(scene, "emission") == pytest.approx(np.tile(LINEAR, (2, 2)), abs=3e-3)


@pytest.mark.parametrize("options", ["-s", "-o", "-mm", "-s 1e39", "-clamp", "-o nan", "-s on"])
def test_options_without_usable_numbers_do_not_stop_a_model(options: str, tmp_path: Path) -> None:
    scene = card(tmp_path, f"map_Kd {options} g.png\n")
    assert np.isfinite(shown(scene, "albedo")).all()

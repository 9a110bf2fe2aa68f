"""Models placed by the earth's centre stand upright."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter

from ssdo_gl.math3d import FloatArray, frame_from_z, normalized
from ssdo_gl.scene.load import load_scene

BERLIN = 6.365e6 * normalized((3.78, 0.9, 5.04))
# East, north and height of a place in a map's grid, as far from the origin.
SWEDEN = np.array([5.0e5, 6.345e6, 120.0])
SAID = "away from the earth's centre"


def tile(folder: Path, glb: GlbWriter, place: FloatArray) -> Path:
    """Return a file with a triangle that lies across the direction to `place`."""
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = frame_from_z(place), place
    glb.json["nodes"][0]["matrix"] = matrix.T.reshape(-1).tolist()
    return glb.save(folder / "tile.glb")


def height(path: Path, **choices: str) -> float:
    low, high = load_scene(path, **choices).bounds()
    return float(high[1] - low[1])


def test_a_tile_lies_flat_unless_up_is_given(glb: GlbWriter, tmp_path: Path) -> None:
    path = tile(tmp_path, glb, BERLIN)
    assert height(path) < 1e-6
    assert any(SAID in note for note in load_scene(path).notes)
    assert height(path, up="y") > 0.1
    assert height(path, up="z") > 0.1


@pytest.mark.parametrize("place", [0.5 * BERLIN, SWEDEN, np.array([0.0, 6.365e6, 0.0])])
def test_what_may_be_elsewhere_stands_as_the_file_has_it(
    glb: GlbWriter, tmp_path: Path, place: FloatArray
) -> None:
    path = tile(tmp_path, glb, place)
    assert not any(SAID in note for note in load_scene(path).notes)
    assert height(path) == pytest.approx(height(path, up="y"))


def test_a_light_of_the_file_says_that_up_is_y(glb: GlbWriter, tmp_path: Path) -> None:
    path = tile(tmp_path, glb, BERLIN)
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}}
    glb.json["nodes"] += [{"extensions": {"KHR_lights_punctual": {"light": 0}}}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    assert height(glb.save(path)) > 0.1

"""All light in rooms that nothing was tuned to: never farther away than the near field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from benchmarks import all_light
from benchmarks.all_light import Distance, Row
from benchmarks.rooms import model_room, random_room
from ssdo_gl.bench.measure.reference_cache import ReferenceCache
from ssdo_gl.gpu.context import create_context

pytest.importorskip("flip_evaluator")

TETRAHEDRON = """v 0 0 0
v 40 0 0
v 0 0 40
v 0 30 0
f 1 2 3
f 1 4 2
f 1 3 4
f 2 4 3
"""
# A box seen from the front, and a small lamp behind it that shines away: nothing seen is lit.
LIT_FROM_BEHIND = """
[camera]
position = [0, 1, 3]
target = [0, 1, 0]
[[object]]
shape = "box"
min = [-1, 0, -1]
max = [1, 2, 1]
[[light]]
kind = "area"
corner = [0, 0.5, -3]
edge_u = [0, 0.1, 0]
edge_v = [0.1, 0, 0]
radiance = [1, 1, 1]
"""


def depth(scene) -> np.ndarray:
    return ssdo_gl.render(scene, size=(48, 27), method="direct", aov="depth")


@pytest.mark.parametrize("seed", [1, 4, 9])
def test_drawn_rooms_are_closed_and_the_same_by_seed(seed):
    first = depth(random_room(seed))
    assert (first > 0.0).all(), "a closed room has no background"
    assert first.min() > 0.3, "the camera is in no body"
    assert (first == depth(random_room(seed))).all()
    assert (first != depth(random_room(seed + 1))).any()


def test_a_model_stands_in_a_room_of_its_size(tmp_path):
    file = tmp_path / "solid.obj"
    file.write_text(TETRAHEDRON)
    scene = model_room(file)
    low, high = scene.bounds()
    assert (high - low) / 40.0 == pytest.approx([3.6, 2.4, 3.6])
    assert (depth(scene) > 0.0).all()
    assert 4 in [len(mesh.triangles) for mesh in scene.meshes]


def test_of_a_drawn_room_gi_knows_the_light(tmp_path):
    device = create_context("auto")
    try:
        cache = ReferenceCache(tmp_path)
        row = all_light.measure("room-5", (80, 45), device, 0.02, 20.0, cache)
    finally:
        device.release()
    gi, bounce = row.by_method["gi"], row.by_method["bounce"]
    assert not row.is_worse
    assert gi.rel_mse < 0.005 and abs(gi.mean_error) < 0.02
    assert gi.rel_mse < 0.1 * bounce.rel_mse and gi.flip < 0.5 * bounce.flip


def test_of_black_no_share_is_taken(tmp_path):
    scene = tmp_path / "black.toml"
    scene.write_text(LIT_FROM_BEHIND)
    device = create_context("auto")
    try:
        row = all_light.measure(str(scene), (48, 27), device, 0.02, 2.0, ReferenceCache(tmp_path))
    finally:
        device.release()
    assert not row.is_worse
    assert all(str(distance) == "0.0000 | +0.0% | 0.000" for distance in row.by_method.values())


def test_a_scene_in_which_gi_is_worse_is_named(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    Path("x").mkdir()
    Path("x/door.toml").touch()
    distances = {"gi": Distance(0.2, 0.1, 0.1), "bounce": Distance(0.1, 0.1, 0.1)}
    rest = 0.01, 2.0, 0.3
    monkeypatch.setattr(all_light, "measure", lambda name, *_, **__: Row(name, distances, *rest))
    assert all_light.main(["corner", "x/door.toml"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert (
        lines[2]
        == "| corner | 0.1000 | +10.0% | 0.100 | 0.2000 | +10.0% | 0.100 | 1.0% | 2 | 1.5 |"
    )
    assert lines[-1] == "gi is worse than bounce in: corner, x/door.toml"
    distances["gi"] = distances["bounce"]
    assert all_light.main(["corner"]) == 0

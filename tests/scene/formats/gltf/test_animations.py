"""glTF animations: nodes, joints, morph targets, lights and cameras at a time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_writer import GlbWriter, load

from ssdo_gl import Renderer, Settings
from ssdo_gl.bench.measure.fingerprints import scene_fingerprint
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene


def animate(
    glb: GlbWriter,
    path: str,
    values: list[Any],
    times: tuple[float, ...] = (0.0, 1.0),
    *,
    node: int = 0,
    interpolation: str = "LINEAR",
    name: str = "",
) -> None:
    """Add an animation of one property of one node."""
    kind = {"translation": "VEC3", "scale": "VEC3", "rotation": "VEC4", "weights": "SCALAR"}[path]
    sampler = {
        "input": glb.accessor(np.array(times, "<f4"), "SCALAR"),
        "output": glb.accessor(np.array(values, "<f4"), kind),
        "interpolation": interpolation,
    }
    channel = {"sampler": 0, "target": {"node": node, "path": path}}
    glb.json.setdefault("animations", []).append(
        {"name": name, "channels": [channel], "samplers": [sampler]}
    )


def join(glb: GlbWriter) -> None:
    """Make the last animation a channel of the one before."""
    last = glb.json["animations"].pop()
    glb.json["animations"][-1]["samplers"] += last["samplers"]
    glb.json["animations"][-1]["channels"] += [{**last["channels"][0], "sampler": 1}]


def one_triangle(glb: GlbWriter, **node: Any) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0, **node}]


def corners(scene: Scene, seconds: float) -> FloatArray:
    """Return the corners of all triangles at a time, (3 T, 3), world space."""
    moment = scene_at(scene, seconds)
    found = [np.zeros((0, 3))]
    for item in moment.objects:
        mesh = moment.meshes[item.mesh]
        points = mesh.positions[mesh.triangles.reshape(-1)]
        found += [points @ m[:3, :3].T + m[:3, 3] for m in item.world_from_object]
    return np.concatenate(found)


TRIANGLE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])


@pytest.mark.parametrize(
    ("seconds", "x"), [(0.0, 2.0), (0.25, 3.0), (0.5, 4.0), (1.25, 3.0), (-0.5, 4.0), (1e6, 2.0)]
)
def test_a_node_moves_evenly_and_again(seconds: float, x: float, glb: Any, tmp_path: Path) -> None:
    one_triangle(glb, translation=[9, 9, 9])
    animate(glb, "translation", [[2, 0, 0], [6, 0, 0]])
    assert corners(load(glb, tmp_path), seconds) == pytest.approx(TRIANGLE + [x, 0, 0])


def test_keys_before_the_first_and_after_the_last_hold(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    animate(glb, "translation", [[1, 0, 0], [2, 0, 0]], (1.0, 2.0))
    # The period of an animation is that of its longest channel.
    glb.json["nodes"].append({})
    animate(glb, "translation", [[0, 0, 0], [0, 0, 0]], (0.0, 4.0), node=1)
    join(glb)
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load(glb, tmp_path)
    xs = [corners(scene, seconds)[0, 0] for seconds in (0.5, 1.5, 3.0, 4.5)]
    assert xs == pytest.approx([1.0, 1.5, 2.0, 1.0])


def test_steps_and_splines(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    animate(glb, "translation", [[2, 0, 0], [6, 0, 0]], interpolation="STEP")
    assert corners(load(glb, tmp_path), 0.99)[0, 0] == 2.0
    glb.json["animations"] = []
    # In-tangent, value, out-tangent; tangents count per second, here over two of them.
    keys = [[9, 9, 9], [0, 0, 0], [4, 0, 0], [0, 2, 0], [1, 0, 0], [9, 9, 9]]
    animate(glb, "translation", keys, (0.0, 2.0), interpolation="CUBICSPLINE")
    # Hermite at u = 1/4: h10 = 9/64, h01 = 10/64, h11 = -3/64.
    expected = [2 * 9 / 64 * 4 + 10 / 64, 2 * -3 / 64 * 2, 0.0]
    assert corners(load(glb, tmp_path), 0.5)[0] == pytest.approx(expected)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rotations_take_the_shorter_arc(sign: float, glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    turn = math.radians(120.0) / 2
    end = [0.0, 0.0, sign * math.sin(turn), sign * math.cos(turn)]
    animate(glb, "rotation", [[0, 0, 0, 1], end])
    x_axis = corners(load(glb, tmp_path), 0.25)[1]
    assert x_axis == pytest.approx([math.cos(math.pi / 6), math.sin(math.pi / 6), 0.0], abs=1e-6)


def test_children_follow_and_the_rest_is_shared(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"children": [1]}, {"mesh": 0, "translation": [0, 5, 0]}, {"mesh": 0}]
    glb.json["scenes"] = [{"nodes": [0, 2]}]
    animate(glb, "scale", [[1, 1, 1], [3, 3, 3]])
    scene = load(glb, tmp_path)
    still = next(item for item in scene.objects if item.motion is None)
    later = scene_at(scene, 0.5)
    assert still in later.objects
    assert later.meshes is scene.meshes
    both = corners(scene, 0.5)
    assert sorted(map(tuple, both)) == sorted(
        map(tuple, np.concatenate([TRIANGLE, 2 * (TRIANGLE + [0, 5, 0])]))
    )


def test_what_has_no_size_is_left_out_until_it_has(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    animate(glb, "scale", [[0, 0, 0], [2, 2, 2]], interpolation="STEP", times=(0.0, 1.0))
    animate(glb, "translation", [[0, 0, 0], [0, 0, 0]], (0.0, 2.0))
    join(glb)
    scene = load(glb, tmp_path)
    # All that is left stands for nothing at all: a speck.
    assert np.ptp(corners(scene, 0.5), axis=0).max() < 1e-5
    assert corners(scene, 1.5) == pytest.approx(2 * TRIANGLE)
    for method in ("direct", "ssao", "bounce", "gi", "reference-gi"):
        with Renderer(scene, Settings(size=(16, 16), method=method)) as renderer:
            seen = [renderer.render(["depth", "beauty"], seconds=s).images for s in (0.5, 1.5)]
        assert seen[0]["depth"].max() == 0.0
        assert seen[1]["depth"].max() > 0.0
        assert np.isfinite(seen[0]["beauty"]).all()


def test_a_node_may_be_flat_for_a_while(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    animate(glb, "scale", [[1, 1, 0], [1, 1, 2]], interpolation="STEP")
    scene = load(glb, tmp_path)
    (item,) = scene_at(scene, 0.5).objects
    assert np.linalg.det(item.world_from_object[0, :3, :3]) > 0.0
    assert corners(scene, 0.5) == pytest.approx(TRIANGLE)


def skinned(glb: GlbWriter) -> None:
    joints = glb.accessor(np.array([[0, 1, 0, 0]] * 3, dtype="|u1"), "VEC4")
    weights = glb.accessor(np.array([[1, 0, 0, 0]] * 2 + [[1, 1, 0, 0]], dtype="<f4"), "VEC4")
    normals = glb.accessor(np.array([[0, 0, 1]] * 3, dtype="<f4"), "VEC3")
    glb.json["scenes"] = [{"nodes": [0, 1, 2]}]
    glb.json["nodes"] = [{"mesh": 0, "skin": 0, "translation": [100, 0, 0]}, {}, {}]
    glb.json["skins"] = [{"joints": [1, 2]}]
    primitive = glb.triangle(JOINTS_0=joints, WEIGHTS_0=weights, NORMAL=normals)
    glb.json["meshes"] = [{"primitives": [primitive]}]


def test_skins_follow_their_joints(glb: GlbWriter, tmp_path: Path) -> None:
    skinned(glb)
    animate(glb, "translation", [[0, 0, 0], [0, 8, 0]], node=2)
    scene = load(glb, tmp_path)
    # Half of the third corner is the second joint's.
    assert corners(scene, 0.0) == pytest.approx(TRIANGLE)
    assert corners(scene, 0.5) == pytest.approx(TRIANGLE + [[0, 0, 0], [0, 0, 0], [0, 2, 0]])


def test_normals_turn_with_the_joints(glb: GlbWriter, tmp_path: Path) -> None:
    skinned(glb)
    animate(glb, "rotation", [[0, 0, 0, 1], [1, 0, 0, 0]], node=1)  # half a turn about x
    scene = load(glb, tmp_path)
    normals = scene_at(scene, 0.5).meshes[0].normals
    assert normals is not None
    assert normals[0] == pytest.approx([0, -1, 0], abs=1e-6)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)


def test_morph_targets_of_each_node(glb: GlbWriter, tmp_path: Path) -> None:
    lift = glb.accessor(np.array([[0, 0, 4]] * 3, dtype="<f4"), "VEC3")
    widen = glb.accessor(np.array([[0, 0, 0], [2, 0, 0], [0, 0, 0]], dtype="<f4"), "VEC3")
    primitive = {**glb.triangle(), "targets": [{"POSITION": lift}, {"POSITION": widen}]}
    glb.json["meshes"] = [{"primitives": [primitive], "weights": [0.25, 0.0]}]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "scale": [-1, 1, 1]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    animate(glb, "weights", [0, 0, 1, 0.5], node=1)
    scene = load(glb, tmp_path)
    still, moved = np.split(corners(scene, 0.5), 2)
    assert still == pytest.approx(TRIANGLE + [0, 0, 1])
    expected = (TRIANGLE + [[0, 0, 2], [0.5, 0, 2], [0, 0, 2]]) * [-1, 1, 1]
    assert np.array(sorted(moved.tolist())) == pytest.approx(np.array(sorted(expected.tolist())))


def test_triangles_that_collapse_are_left_out_for_a_while(glb: GlbWriter, tmp_path: Path) -> None:
    shut = glb.accessor(np.array([[0, 0, 0], [-1, 0, 0], [0, 0, 0]], dtype="<f4"), "VEC3")
    primitive = {**glb.triangle(), "targets": [{"POSITION": shut}]}
    glb.json["meshes"] = [{"primitives": [primitive]}]
    animate(glb, "weights", [1, 0], interpolation="STEP", times=(0.0, 1.0))
    animate(glb, "translation", [[0, 0, 0], [0, 0, 0]], (0.0, 2.0))
    join(glb)
    scene = load(glb, tmp_path)
    assert np.ptp(corners(scene, 0.5), axis=0).max() < 1e-5
    assert corners(scene, 1.5) == pytest.approx(TRIANGLE)


def test_pictures_follow_the_pose_and_come_back(glb: GlbWriter, tmp_path: Path) -> None:
    skinned(glb)
    animate(glb, "translation", [[0, 0, 0], [0, 1, 0]], node=1)
    scene = load(glb, tmp_path)
    with Renderer(scene, Settings(size=(32, 24), method="direct")) as renderer:
        images = [renderer.render(["depth"], seconds=s).images["depth"] for s in (0.0, 0.9, 0.0)]
    assert np.array_equal(images[0], images[2])
    assert np.mean((images[0] > 0) != (images[1] > 0)) > 0.05
    # Poses are no data: the cache of references knows the scene at rest.
    assert scene_fingerprint(scene)


def test_lights_and_the_camera_move_with_their_nodes(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot"}]}}
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    lamp = {"KHR_lights_punctual": {"light": 0}}
    glb.json["nodes"] = [
        {"mesh": 0},
        {"children": [2], "translation": [0, 0, 4]},
        {"camera": 0, "extensions": lamp, "scale": [2, 3, 4]},
    ]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    quarter = [0, math.sqrt(0.5), 0, math.sqrt(0.5)]
    animate(glb, "rotation", [[0, 0, 0, 1], quarter], node=1)
    later = scene_at(load(glb, tmp_path), 1.0 - 1e-9)
    light = later.lights[0]
    assert light.place == pytest.approx((0, 0, 4))
    # From -z, a quarter turn about y, to -x.
    assert light.direction == pytest.approx((-1, 0, 0), abs=1e-6)  # type: ignore[attr-defined]
    forward = np.subtract(later.camera.target, later.camera.position)
    assert forward / np.linalg.norm(forward) == pytest.approx([-1, 0, 0], abs=1e-6)
    assert later.camera.up == pytest.approx((0, 1, 0))


def test_a_camera_that_a_scene_file_places_stands_still(glb: GlbWriter, tmp_path: Path) -> None:
    glb.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 1}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 4]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    animate(glb, "translation", [[0, 0, 4], [0, 0, 8]], node=1)
    glb.save(tmp_path / "a.glb")
    file = tmp_path / "mine.toml"
    file.write_text('base = "a.glb"\n[camera]\nexposure = 1.0\n')
    assert scene_at(load_scene(file), 0.5).camera.position == pytest.approx((0, 0, 6))
    file.write_text('base = "a.glb"\n[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n')
    assert scene_at(load_scene(file), 0.5).camera.position == (0, 0, 5)


def test_the_first_animation_is_played_and_what_goes_with_it(
    glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 0}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    animate(glb, "translation", [[0, 0, 0], [2, 0, 0]], name="walk")
    animate(glb, "translation", [[0, 0, 0], [0, 6, 0]], name="wave", node=1)
    animate(glb, "translation", [[0, 0, 0], [9, 0, 0]], name="run")
    scene = load(glb, tmp_path)
    first, second = np.split(corners(scene, 0.5), 2)
    assert first == pytest.approx(TRIANGLE + [1, 0, 0])
    assert second == pytest.approx(TRIANGLE + [0, 3, 0])
    (note,) = [note for note in scene.notes if "not played" in note]
    assert "run" in note
    assert "wave" not in note


@pytest.mark.parametrize(
    "damage",
    [
        lambda glb: glb.json["animations"][0].pop("samplers"),
        lambda glb: glb.json["animations"].insert(0, 5),
        lambda glb: glb.json["animations"][0]["channels"][0]["target"].update(node=7),
        lambda glb: glb.json["animations"][0]["samplers"][0].update(output=0),
        lambda glb: animate(glb, "translation", [[0, 0, 0], [np.nan, 0, 0]]),
        lambda glb: animate(glb, "translation", [[0, 0, 0], [1, 0, 0]], (1.0, 0.0)),
    ],
)
def test_a_damaged_animation_is_a_note(damage: Any, glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb, translation=[1, 0, 0])
    animate(glb, "scale", [[1, 1, 1], [2, 2, 2]])
    damage(glb)
    scene = load(glb, tmp_path)
    assert any(note.startswith("animation not played") for note in scene.notes)
    assert len(corners(scene, 0.5)) == 3


def test_a_scene_may_place_and_move_what_moves(glb: GlbWriter, tmp_path: Path) -> None:
    one_triangle(glb)
    animate(glb, "translation", [[0, 0, 0], [4, 0, 0]])
    glb.save(tmp_path / "a.glb")
    (tmp_path / "s.toml").write_text(
        """[[object]]
shape = "mesh"
path = "a.glb"
transform = { rotate = [0, 0, 90], translate = [0, 0, 3] }
repeat = { count = 2, step = [10, 0, 0] }
animate = { sway = [0, 0, 2], period = 2.0 }
"""
    )
    moved = corners(load_scene(tmp_path / "s.toml"), 0.5)
    turned = TRIANGLE @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + [0, 2, 3 + 2]
    assert moved == pytest.approx(np.concatenate([turned, turned + [10, 0, 0]]))

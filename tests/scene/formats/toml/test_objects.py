"""Objects of scene files: shapes, transforms, copies, motion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.math3d import transform_points
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError


def scene(text: str) -> Scene:
    return read_description(text, "scene.toml")


def only_bounds(text: str) -> tuple[list[float], list[float]]:
    low, high = scene(f"[[object]]\n{text}").bounds()
    return low.round(12).tolist(), high.round(12).tolist()


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ('shape = "box"\nmin = [-1, 0, 2]\nmax = [1, 5, 3]', [-1, 0, 2], [1, 5, 3]),
        (
            'shape = "quad"\ncorner = [1, 1, 1]\nedge_u = [2, 0, 0]\nedge_v = [0, 0, -3]',
            [1, 1, -2],
            [3, 1, 1],
        ),
        (
            'shape = "plane"\npoint = [0, 1, 0]\nnormal = [0, 5, 0]\nsize = 4',
            [-2, 1, -2],
            [2, 1, 2],
        ),
        ('shape = "sphere"\ncenter = [0, 3, 0]\nradius = 2', [-2, 1, -2], [2, 5, 2]),
        ('shape = "sphere"\nradius = 2', [-2, -2, -2], [2, 2, 2]),
        (
            'shape = "cylinder"\nbase = [0, 0, 0]\ntop = [0, 5, 0]\nradius = 1',
            [-1, 0, -1],
            [1, 5, 1],
        ),
        ('shape = "cone"\nbase = [0, 4, 0]\ntop = [0, 1, 0]\nradius = 2', [-2, 1, -2], [2, 4, 2]),
        (
            'shape = "torus"\ncenter = [0, 1, 0]\naxis = [0, 0, 2]\nradius = 2\nthickness = 1',
            [-2.5, -1.5, -0.5],
            [2.5, 3.5, 0.5],
        ),
    ],
)
def test_shapes_have_the_size_they_ask_for(text: str, low: list[float], high: list[float]) -> None:
    assert only_bounds(text) == (low, high)


def test_an_unknown_material_is_named_without_what_a_terminal_obeys() -> None:
    with pytest.raises(SceneError, match=r"no \[materials\.\\x1b\[31m\] in this file"):
        scene('[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "\\u001b[31m"')


def test_front_of_quads_and_planes() -> None:
    result = scene(
        '[[object]]\nshape = "quad"\ncorner = [0, 0, 0]\nedge_u = [0, 0, 2]\nedge_v = [1, 0, 0]\n'
        '[[object]]\nshape = "plane"\npoint = [0, 0, 0]\nnormal = [1, 2, -3]\nsize = [1, 2]\n'
    )
    matrices = result.objects[0].world_from_object
    assert len(matrices) == 2  # one mesh serves both
    a, b = (np.cross(m[:3, 0], m[:3, 1]) for m in matrices)
    assert a.tolist() == [0.0, 2.0, 0.0]
    assert b / np.linalg.norm(b) == pytest.approx(np.array([1, 2, -3]) / np.sqrt(14))
    assert np.linalg.norm(b) == pytest.approx(2.0)


@pytest.mark.parametrize(("from_", "low"), [("[1, 0, 0]", [0.0, 0.0]), ("[0, 1, 0]", [-1.25, 0.0])])
def test_an_arc_starts_where_it_is_told(from_: str, low: list[float]) -> None:
    bounds = only_bounds(
        'shape = "torus"\naxis = [0, 0, 1]\nradius = 1\nthickness = 0.5\n'
        f"arc = {{ from = {from_}, degrees = 90 }}"
    )
    assert bounds[0][:2] == pytest.approx(low, abs=0.01)


def test_bumps_make_a_mesh_of_their_own() -> None:
    result = scene(
        '[[object]]\nshape = "sphere"\nradius = 1\n[[object]]\nshape = "sphere"\nradius = 1\n'
        "bump = { amplitude = 0.1 }\n"
    )
    assert len(result.meshes) == 2


def test_transform_scales_then_rotates_then_moves() -> None:
    bounds = only_bounds(
        'shape = "box"\nmin = [0, 0, 0]\nmax = [1, 2, 3]\n'
        "transform = { translate = [10, 0, 0], rotate = [0, 90, 0], scale = [2, 1, 1] }"
    )
    # x 0..2 and z 0..3 turn about +y into z -2..0 and x 0..3.
    assert bounds == ([10, 0, -2], [13, 2, 0])


def test_a_mirrored_object_keeps_its_front() -> None:
    result = scene(
        '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 2, 3]\n'
        "transform = { scale = [1, -1, 1] }"
    )
    assert result.bounds()[0].tolist() == [0, -2, 0]
    for item in result.objects:
        mesh = result.meshes[item.mesh]
        assert np.linalg.det(item.world_from_object[0][:3, :3]) > 0.0
        points = transform_points(item.world_from_object[0], mesh.positions)[mesh.triangles]
        volume = np.einsum("ij,ij->", points[:, 0], np.cross(points[:, 1], points[:, 2])) / 6
        assert volume == pytest.approx(6.0)


def test_repeat_is_a_nested_grid_of_instances() -> None:
    result = scene(
        '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'
        "repeat = { count = [2, 1, 3], step = [10, 5, 100] }"
    )
    (item,) = result.objects
    offsets = item.world_from_object[:, :3, 3] - 0.5
    assert offsets.tolist() == [[x, 0, z] for x in (0.0, 10.0) for z in (0.0, 100.0, 200.0)]
    assert len(result.meshes) == 1


def test_repeat_with_one_count_follows_the_step() -> None:
    result = scene(
        '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'
        "repeat = { count = 3, step = [1, 2, -4] }"
    )
    offsets = result.objects[0].world_from_object[:, :3, 3] - 0.5
    assert offsets.tolist() == [[0, 0, 0], [1, 2, -4], [2, 4, -8]]


def test_still_objects_of_one_shape_and_material_are_one() -> None:
    box = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nmaterial = "{}"\n'
    result = scene("[materials.a]\n[materials.b]\n" + "".join(box.format(name) for name in "abab"))
    assert [len(item.world_from_object) for item in result.objects] == [2, 2]
    assert [result.materials[item.material].name for item in result.objects] == ["a", "b"]


def test_moving_and_shining_objects_stay_apart() -> None:
    box = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'
    result = scene(
        "[materials.glow]\nemission = [1, 1, 1]\n"
        f"{box}animate = {{ spin = [0, 1, 0] }}\n{box}{box}material = 'glow'\n{box}"
        f"{box}material = 'glow'\n"
    )
    assert [len(item.world_from_object) for item in result.objects] == [1, 2, 1, 1]
    # Six rectangles each: every body refers to the first of its own.
    assert [item.light for item in result.objects] == [None, None, 0, 6]


def test_spin_turns_about_the_middle_of_each_copy() -> None:
    result = scene(
        '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [2, 2, 2]\n'
        "repeat = { count = 2, step = [10, 0, 0] }\nanimate = { spin = [0, 90, 0] }"
    )
    pivots = [item.motion.pivot for item in result.objects if item.motion]
    assert pivots == [(1, 1, 1), (11, 1, 1)]


def test_animate_reads_every_key_and_may_be_still() -> None:
    box = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'
    (item,) = scene(
        box + "animate = { spin = [1, 2, 3], pivot = [4, 5, 6], orbit = [7, 8, 9],"
        " orbit_center = [1, 1, 1], sway = [0, 2, 0], period = 3 }"
    ).objects
    assert item.motion is not None
    assert dataclasses.astuple(item.motion) == (
        (1, 2, 3),
        (7, 8, 9),
        (4, 5, 6),
        (1, 1, 1),
        (0, 2, 0),
        3.0,
    )
    (still,) = scene(box + "animate = { spin = [0, 0, 0] }").objects
    assert still.motion is None


number = st.floats(-1e3, 1e3, allow_nan=False).map(lambda x: round(x, 6))


@given(low=st.tuples(number, number, number), size=st.tuples(*[st.floats(1e-3, 1e3)] * 3))
def test_boxes_round_trip(low: tuple[float, ...], size: tuple[float, ...]) -> None:
    high = np.add(low, size)
    text = f'[[object]]\nshape = "box"\nmin = {list(low)}\nmax = {high.tolist()}\n'
    bounds = scene(text).bounds()
    assert bounds[0] == pytest.approx(low, abs=1e-9)
    assert bounds[1] == pytest.approx(high, abs=1e-9)

"""Scans stand upright and are smooth, unless one asks for something else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.cli import main
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.load import load_scene


def stl(mesh: Mesh) -> bytes:
    rows = np.zeros(
        len(mesh.triangles), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]
    )
    rows["c"] = mesh.positions[mesh.triangles]
    return bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()


def off(mesh: Mesh) -> str:
    lines = [f"OFF\n{len(mesh.positions)} {len(mesh.triangles)} 0"]
    lines += [" ".join(map(str, p)) for p in mesh.positions.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in mesh.triangles.tolist()]
    return "\n".join(lines) + "\n"


@pytest.fixture
def cone(tmp_path: Path) -> Path:
    """Return a cone that stands on the plane z = 0."""
    path = tmp_path / "cone.stl"
    path.write_bytes(stl(shapes.cone(24)))
    return path


def test_a_cone_on_the_plane_z_stands_upright(cone: Path) -> None:
    scene = load_scene(cone)
    assert any("up is +z, guessed (its flat foot): --up y turns it" in n for n in scene.notes)
    for choice, axis in (({}, 1), ({"up": "z"}, 1), ({"up": "y"}, 2)):
        points = load_scene(cone, **choice)
        mesh, item = points.meshes[0], points.objects[0]
        tip = mesh.positions[np.argmax(mesh.positions[:, 2])] @ item.world_from_object[0, :3, :3].T
        low, high = points.bounds()
        assert tip[axis] == pytest.approx(high[axis], abs=1e-6) and high[axis] > low[axis]


@pytest.mark.parametrize(("width", "axis"), [(0.3, "y"), (2.5, "z")])
def test_what_a_scan_would_fall_over_from_is_no_foot(
    tmp_path: Path, width: float, axis: str
) -> None:
    """A shell of front, roof and a strip that looks along -z: cars were stood on bumpers."""
    rows = [(0, 5), (3, 5), (3, 0), (3 - width, 0)]
    corners = np.array([(x, y, z) for y, z in rows for x in (0, 4)], dtype=float)
    faces = np.array(
        [(k, k + 1, k + 3) for k in (0, 2, 4)] + [(k, k + 3, k + 2) for k in (0, 2, 4)]
    )
    path = tmp_path / "a.off"
    path.write_text(off(Mesh(corners, faces)))
    assert any(f"up is +{axis}, guessed" in note for note in load_scene(path).notes)


def test_a_plate_with_a_hole_does_not_stand_on_its_rim(tmp_path: Path) -> None:
    box = shapes.box()
    bars = [([10, 4, 3], [0, -7, 0]), ([10, 4, 3], [0, 10, 0])]
    bars += [([3, 13, 3], [x, -3, 0]) for x in (0, 7)]
    corners = [(box.positions + 0.5) * size + place for size, place in bars]
    triangles = [box.triangles + len(box.positions) * i for i in range(len(bars))]
    path = tmp_path / "a.stl"
    path.write_bytes(stl(Mesh(np.concatenate(corners), np.concatenate(triangles))))
    assert any("up is +z, guessed (it stands on z = 0)" in n for n in load_scene(path).notes)


def test_the_y_axis_is_up_where_the_foot_is_there(tmp_path: Path) -> None:
    box = shapes.cone(24)
    turned = Mesh(box.positions @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0.0]]).T, box.triangles)
    (tmp_path / "a.stl").write_bytes(stl(turned))
    assert any("up is +y" in note for note in load_scene(tmp_path / "a.stl").notes)


def test_formats_have_customs(tmp_path: Path) -> None:
    ball = shapes.sphere(16, 0.0, 8.0)
    (tmp_path / "a.stl").write_bytes(stl(ball))
    (tmp_path / "a.off").write_text(off(ball))
    assert any("up is +z" in note for note in load_scene(tmp_path / "a.stl").notes)
    assert any("up is +y" in note for note in load_scene(tmp_path / "a.off").notes)


@pytest.mark.parametrize(("axes", "said"), [([0, 1, 2], True), ([0, 2, 1], False)])
def test_an_obj_that_seems_to_lie_is_drawn_as_it_is_and_said(
    tmp_path: Path, axes: list[int], said: bool
) -> None:
    cone = shapes.cone(24)
    lines = ["v {} {} {}".format(*p) for p in cone.positions[:, axes].tolist()]
    # Two axes that change places turn the corners around.
    lines += ["f {} {} {}".format(*t[:: 1 if said else -1]) for t in (cone.triangles + 1).tolist()]
    (tmp_path / "a.obj").write_text("\n".join(lines) + "\n")
    scene = load_scene(tmp_path / "a.obj")
    hint = "up is +y, the custom of its format; if that is a side (its flat foot), --up z turns it"
    assert (hint in scene.notes) == said
    assert np.array_equal(scene.objects[0].world_from_object[0], np.eye(4))


def test_scans_are_smooth_unless_asked(cone: Path) -> None:
    assert load_scene(cone).meshes[0].normals is not None
    for choice in ("flat", "file"):
        assert load_scene(cone, normals=choice).meshes[0].normals is None
    flat = load_scene(cone, crease_angle=0.0).meshes[0]
    assert flat.normals is None


def test_other_models_are_as_their_file_is(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 .1\nf 1 2 3\nf 2 4 3\n")
    assert load_scene(path).meshes[0].normals is None
    assert load_scene(path, normals="smooth").meshes[0].normals is not None


def test_scene_files_say_it_for_each_mesh(cone: Path) -> None:
    scene = '[[object]]\nshape = "mesh"\npath = "cone.stl"\n'
    path = cone.with_name("s.toml")
    for more, is_smooth in (("", True), ('normals = "flat"\n', False)):
        path.write_text(scene + more)
        assert (load_scene(path).meshes[0].normals is not None) is is_smooth


@pytest.mark.parametrize("flag", [["--up", "z"], ["--normals", "flat"], ["--crease-angle", "9"]])
def test_a_scene_takes_no_flag_of_models(
    flag: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["corner", "--explain", *flag]) == 2
    assert f"{flag[0]} belongs to model files: corner is a scene" in capsys.readouterr().err

"""The floor under a lone model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter

import ssdo_gl
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.defaults.default_light import BACKDROP
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

CORNERS = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
SIDES = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
FLOOR = "v -2 0 -2\nv -2 0 3\nv 3 0 3\nv 3 0 -2\nf 9 10 11 12\n"


@pytest.fixture
def box(tmp_path: Path) -> Path:
    path = tmp_path / "box.obj"
    path.write_text(CORNERS + SIDES)
    return path


def grounds(scene: Scene) -> int:
    return sum(item.is_ground for item in scene.objects)


def test_a_lone_model_stands_on_a_ground_that_its_size_does_not_count(box: Path) -> None:
    scene, bare = load_scene(box, ground="auto"), load_scene(box)
    assert (grounds(scene), grounds(bare)) == (1, 0)
    assert scene.camera == bare.camera
    assert scene.default_radius() == bare.default_radius()
    np.testing.assert_array_equal(scene.bounds(), bare.bounds())
    (mesh,) = (scene.meshes[item.mesh] for item in scene.objects if item.is_ground)
    # Just below the box, by less than one sees.
    assert -1e-3 < mesh.positions[:, 1].max() < 0.0
    assert (mesh.face_normals()[:, 1] > 0.99).all()


def test_no_ground_where_something_else_serves(box: Path) -> None:
    box.write_text(CORNERS + SIDES + FLOOR)
    assert grounds(load_scene(box, ground="auto")) == 0
    box.write_text(CORNERS + SIDES)
    assert grounds(load_scene(box, light="file", ground="auto")) == 0
    assert grounds(load_scene(box, light="studio", ground="auto")) == 1
    assert load_scene("corner", light="studio").has_ground is False


def test_no_ground_between_the_light_and_what_is_seen_from_below(
    glb: GlbWriter, tmp_path: Path
) -> None:
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    glb.json["nodes"][0]["rotation"] = [2**-0.5, 0, 0, 2**-0.5]
    scene = load_scene(glb.save(tmp_path / "on_its_face.glb"), ground="auto")
    assert scene.camera.position[1] < 0.0
    assert grounds(scene) == 0


def test_a_cut_out_stands_on_nothing(box: Path) -> None:
    image = ssdo_gl.render(str(box), size=(48, 27), background="transparent")
    assert image[-1, 0, 3] == 0.0
    assert ssdo_gl.render(str(box), size=(48, 27))[-1, 0, 3] == 1.0


@pytest.mark.parametrize("light", ["auto", "studio"])
def test_the_ground_has_no_edge(box: Path, light: str) -> None:
    """Unshaded it shows the backdrop: to a twentieth, which is what SSDO leaves of noise."""
    scene = load_scene(box, light=light, ground="auto")
    with Renderer(scene, Settings(size=(96, 54))) as renderer:
        images = renderer.render(["beauty", "position_ws"]).images
    position = images["position_ws"]
    is_ground = (position[..., 1] < -1e-6) & (images["beauty"][..., 3] > 0.0)
    far = is_ground & (np.hypot(position[..., 0] - 0.5, position[..., 2] - 0.5) > 1.2)
    # On the side of the light, where the box throws no shadow.
    lit = far & (position[..., 2] > 0.5)
    shown = images["beauty"][lit][:, :3]
    assert len(shown) > 20
    assert np.median(shown) == pytest.approx(BACKDROP[0], rel=0.05)
    assert shown[is_ground[lit]].min() > 0.5 * BACKDROP[0]


def test_the_ground_does_not_decide_the_exposure(box: Path, tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl lamp\nKd 0.001 0.001 0.001\n")
    box.write_text(f"mtllib a.mtl\nusemtl lamp\n{CORNERS}{SIDES}")
    with Renderer(load_scene(box, ground="auto"), Settings(size=(48, 27))) as renderer:
        exposure = renderer.render(["display"]).settings.exposure
    # Black as it is, it is raised as far as the grey behind it allows; that grey alone would
    # leave exposure at 0.
    assert exposure == 1.0

"""Single-sided surfaces of glTF show their front only: to the camera, to lights and to rays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from glb_writer import GlbWriter
from numpy.typing import NDArray

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

QUAD = shapes.quad()
SIZE = (48, 32)


def two_sided(scene: Scene) -> Scene:
    """Return the scene with both sides of all surfaces drawn."""
    return replace(scene, materials=tuple(replace(m, single_sided=False) for m in scene.materials))


def card(*turn: float, mirrored: bool = False) -> NDArray[np.float64]:
    """Return the matrix of a unit card about the origin, its front at +z before the turn."""
    flip = math3d.scaling((-1.0, 1.0, 1.0)) if mirrored else np.eye(4)
    return math3d.rotation_euler(turn) @ flip @ math3d.translation((-0.5, -0.5, 0.0))


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("turn", [0.0, 180.0])
def test_the_camera_sees_fronts_only(turn: float, mirrored: bool) -> None:
    scene = Scene(
        (QUAD,),
        (Material(single_sided=True),),
        (SceneObject(0, 0, card(0.0, turn, 0.0, mirrored=mirrored)[None]),),
        Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0)),
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
    )
    for method in ("direct", "bounce", "reference-near"):
        depth = ssdo_gl.render(scene, size=SIZE, aov="depth", method=method, spp=1)
        # Mirroring leaves the front of a mesh its front.
        assert bool((depth > 0.0).any()) == (turn == 0.0)
    both = ssdo_gl.render(two_sided(scene), size=SIZE, aov="depth")
    assert (both > 0.0).any()


def floor_under_card(faces_up: bool) -> Scene:
    """Return a floor at y = 0, seen from above at a slant, and a card over its middle."""
    floor = math3d.rotation_euler((-90.0, 0.0, 0.0)) @ math3d.scaling(4.0) @ card(0.0, 0.0, 0.0)
    over = math3d.translation((0.0, 1.0, 0.0)) @ card(-90.0 if faces_up else 90.0, 0.0, 0.0)
    return Scene(
        (QUAD,),
        (Material(name="floor"), Material(name="card", single_sided=True)),
        (SceneObject(0, 0, floor[None]), SceneObject(0, 1, over[None])),
        # Below the card's plane, so that nothing hides the floor's middle.
        Camera((0.0, 0.9, 3.0), (0.0, 0.0, 0.0)),
        lights=(DirectionalLight((0.0, -1.0, 0.0), (np.pi, np.pi, np.pi)),),
    )


@pytest.mark.parametrize("faces_up", [True, False])
@pytest.mark.parametrize(
    "more",
    [
        {"shadows": "map"},
        {"shadows": "traced", "shadow_rays": 4},
        {"method": "reference-near", "spp": 4},
        {"method": "reference-gi", "spp": 4, "bounces": 0, "aov": "beauty"},
    ],
)
def test_a_light_behind_a_single_sided_card_shines_through(
    faces_up: bool, more: dict[str, object]
) -> None:
    scene = floor_under_card(faces_up)
    wanted = {"aov": "direct", "size": SIZE, **more}
    middle = ssdo_gl.render(scene, **wanted)[15:18, 23:26, :3].mean()
    expected = 0.0 if faces_up else 0.8
    assert middle == pytest.approx(expected, abs=0.03)
    # As a surface with two sides it blocks either way.
    assert ssdo_gl.render(two_sided(scene), **wanted)[15:18, 23:26, :3].mean() < 0.03


@pytest.mark.parametrize("faces_up", [True, False])
def test_rays_pass_from_behind(faces_up: bool) -> None:
    scene = replace(
        floor_under_card(faces_up), lights=(), environment=ConstantEnvironment((1.0, 1.0, 1.0))
    )
    image = ssdo_gl.render(
        scene, size=SIZE, aov="visibility", method="reference-ao", spp=64, radius=50.0
    )
    middle = float(image[15:18, 23:26].mean())
    # From the floor the card's back is above if it faces up, and rays pass.
    assert (middle > 0.999) == faces_up


def test_what_a_file_says_of_sides(glb: GlbWriter, tmp_path: Path) -> None:
    primitives = [{**glb.triangle(), "material": index} for index in range(3)]
    glb.json["meshes"] = [{"primitives": primitives}]
    glb.json["materials"] = [{}, {"doubleSided": True}, {"doubleSided": False}]
    materials = load_scene(glb.save(tmp_path / "a.glb")).materials
    assert [material.single_sided for material in materials] == [True, False, True]
    asked = load_scene(tmp_path / "a.glb", two_sided=True)
    assert not any(material.single_sided for material in asked.materials)
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert not load_scene(tmp_path / "a.obj").materials[0].single_sided

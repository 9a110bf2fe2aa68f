"""Lights that stand for emissive surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.scene import emissive_meshes as emitters
from ssdo_gl.scene.emissive_meshes import MAX_LIGHTS, SAMPLE_COUNT, emitter_lights
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.geometry import Surfaces, shapes
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.material import Material, Texture

GLOW = Material(name="glow", emission=(3.0, 2.0, 1.0))


def lights_of(
    mesh: Mesh, matrices: np.ndarray | None = None, material: Material = GLOW
) -> tuple[list[RectangleLight], tuple[str, ...]]:
    item = SceneObject(0, 0, np.eye(4)[None] if matrices is None else matrices)
    made = emitter_lights(Surfaces([mesh], [item], [material]), {}, 5)
    assert made.objects[0].light == (5 if made.lights else None)
    return [light for light in made.lights if isinstance(light, RectangleLight)], made.notes


def power(light: RectangleLight) -> np.ndarray:
    return np.linalg.norm(np.cross(light.edge_u, light.edge_v)) * np.array(light.radiance)


def area(mesh: Mesh, matrix: np.ndarray) -> float:
    a, b, c = (
        math3d.transform_points(matrix, mesh.positions)[mesh.triangles[:, i]] for i in range(3)
    )
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_a_quad_is_one_exact_light() -> None:
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = (2, 0, 0), (1, 0, 3), (0, -1, 0)
    (light,), notes = lights_of(shapes.quad(), matrix[None])
    assert np.linalg.norm(np.cross(light.edge_u, light.edge_v)) == pytest.approx(6.0)
    normal = np.cross(light.edge_u, light.edge_v)
    assert normal / 6.0 == pytest.approx([0, -1, 0])  # edge_u x edge_v of the quad
    corners = {
        tuple(
            np.round(
                np.array(light.corner) + u * np.array(light.edge_u) + v * np.array(light.edge_v), 9
            )
        )
        for u in (0, 1)
        for v in (0, 1)
    }
    assert corners == {(0, 0, 0), (2, 0, 0), (3, 0, 3), (1, 0, 3)}
    assert light.radiance == (3.0, 2.0, 1.0)
    assert light.visible
    assert notes == ()


def test_a_box_is_six_exact_lights_that_face_outward() -> None:
    lights, notes = lights_of(shapes.box())
    assert len(lights) == 6
    assert notes == ()
    for light in lights:
        middle = np.array(light.corner) + 0.5 * (np.array(light.edge_u) + np.array(light.edge_v))
        assert np.cross(light.edge_u, light.edge_v) @ middle > 0.0
    assert sum(power(light) for light in lights) == pytest.approx(6.0 * np.array([3, 2, 1]))


@pytest.mark.parametrize("shape", [shapes.sphere(), shapes.torus(0.3), shapes.cone()])
def test_other_shapes_keep_their_power_in_eight_samples(shape: Mesh) -> None:
    matrix = math3d.translation((5, 0, 0)) @ math3d.scaling((1, 2, 0.5))
    lights, notes = lights_of(shape, matrix[None])
    assert len(lights) == SAMPLE_COUNT
    assert not any(light.visible for light in lights)
    expected = area(shape, matrix) * np.array(GLOW.emission)
    assert sum(power(light) for light in lights) == pytest.approx(expected, rel=1e-9)
    (note,) = notes
    assert "8 sample rectangles of the same total power" in note


def test_samples_of_a_sphere_lie_on_it_and_look_every_way() -> None:
    lights, _ = lights_of(shapes.sphere())
    normals = []
    for light in lights:
        middle = np.array(light.corner) + 0.5 * (np.array(light.edge_u) + np.array(light.edge_v))
        assert np.linalg.norm(middle) == pytest.approx(1.0, abs=0.01)  # a facet's depth
        normal = math3d.normalized(np.cross(light.edge_u, light.edge_v))
        assert normal @ middle > 0.99
        normals.append(normal)
    # Eight even directions leave no point of the sphere farther than 75 degrees away.
    everywhere = shapes.sphere(24).positions
    assert (everywhere @ np.array(normals).T).max(axis=1).min() > np.cos(np.radians(75.0))


def test_samples_of_a_sphere_are_as_large_as_they_look_from_afar() -> None:
    lights, _ = lights_of(shapes.sphere())
    areas = [np.linalg.norm(np.cross(light.edge_u, light.edge_v)) for light in lights]
    # An octant has the surface pi / 2 and, along its mean normal, the projected area
    # sqrt(3) pi / 4 = 1.36. The clusters are octants only on average.
    assert np.mean(areas) == pytest.approx(np.sqrt(3.0) * np.pi / 4.0, rel=0.03)
    assert max(areas) < np.pi / 2.0


def test_samples_are_the_same_every_time() -> None:
    assert lights_of(shapes.torus(0.3)) == lights_of(shapes.torus(0.3))


def test_fine_meshes_are_thinned_without_losing_power(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(emitters, "MAX_CLUSTERED", 500)
    shape = shapes.sphere()
    lights, _ = lights_of(shape)
    expected = area(shape, np.eye(4)) * np.array(GLOW.emission)
    assert sum(power(light) for light in lights) == pytest.approx(expected, rel=1e-9)


def test_radiance_follows_the_emission_texture() -> None:
    pixels = np.zeros((1, 2, 4), dtype=np.float32)
    pixels[0, 1] = (1.0, 0.5, 0.0, 1.0)
    material = Material(emission=(2.0, 2.0, 2.0), emission_texture=Texture(pixels))
    (light,), notes = lights_of(shapes.quad(), material=material)
    # Half of the quad is black. 45 x 45 lookups of each triangle find half within 2 %.
    assert light.radiance == pytest.approx((1.0, 0.5, 0.0), rel=0.02)
    assert "mean radiance" in notes[0]


def test_a_black_emission_texture_makes_no_light() -> None:
    texture = Texture(np.zeros((1, 1, 4), dtype=np.uint8))
    lights, notes = lights_of(
        shapes.quad(), material=Material(emission=(1, 1, 1), emission_texture=texture)
    )
    assert lights == []
    assert notes == ()


def test_instances_of_a_panel_are_a_light_each() -> None:
    matrices = np.stack([math3d.translation((x, 0, 0)) for x in range(4)])
    lights, _ = lights_of(shapes.quad(), matrices)
    assert [light.corner[0] - lights[0].corner[0] for light in lights] == [0, 1, 2, 3]


def test_too_many_lights_are_told() -> None:
    items = [SceneObject(0, 0, name=f"lamp {index}") for index in range(MAX_LIGHTS + 3)]
    made = emitter_lights(Surfaces([shapes.quad()], items, [GLOW]), {}, 0)
    assert len(made.lights) == MAX_LIGHTS
    assert [item.light is None for item in made.objects].count(True) == 3
    assert f"'lamp {MAX_LIGHTS}'" in made.notes[0]


def test_scene_files_say_how_emitters_are_shadowed() -> None:
    scene = read_description(
        "[materials.glow]\nemission = [1, 1, 1]\ntwo_sided_emission = true\n"
        '[[object]]\nshape = "quad"\ncorner = [0, 0, 0]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\n'
        'material = "glow"\nshadow = "none"\nanimate = { orbit = [0, 9, 0] }\n',
        "scene.toml",
    )
    (light,) = scene.lights
    assert isinstance(light, RectangleLight)
    assert light.shadow == "none"
    assert light.two_sided
    assert light.motion is scene.objects[0].motion
    assert light.motion is not None


def test_an_inverted_solid_is_turned_to_shine_outward() -> None:
    inverted = Mesh(shapes.sphere(16).positions, shapes.sphere(16).triangles[:, ::-1], closed=True)
    ((index, turned, note),) = emitters.turned_to_scene(
        Surfaces([inverted], [SceneObject(0, 0)], [GLOW])
    )
    assert index == 0
    assert np.array_equal(turned.triangles, shapes.sphere(16).triangles)
    assert "turned around" in note
    assert list(emitters.turned_to_scene(Surfaces([turned], [SceneObject(0, 0)], [GLOW]))) == []

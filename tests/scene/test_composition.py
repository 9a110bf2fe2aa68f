"""Scenes made in Python: of arrays, by adding and changing parts."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl import (
    ConstantEnvironment,
    MapEnvironment,
    Material,
    Mesh,
    PointLight,
    RectangleLight,
    Scene,
)
from ssdo_gl.scene import defaults
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.motion import Motion
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError

QUAD = [[-1.0, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]
HALVES = [[0, 1, 2], [0, 2, 3]]
SMALL = ssdo_gl.Settings(size=(32, 18), samples=8, radius=1.0)
LAMP = PointLight((0, 2, 0), (5, 5, 5), name="lamp")
TEXELS = np.full((2, 2, 4), 255, np.uint8)
PANEL = RectangleLight((-0.5, 2, -0.5), (1, 0, 0), (0, 0, 1), (9, 9, 9), name="panel")


def picture(scene: Scene, aov: str = "beauty") -> np.ndarray:
    with ssdo_gl.Renderer(scene, SMALL) as renderer:
        return renderer.render([aov]).images[aov]


def test_arrays_make_the_picture_of_their_file(tmp_path):
    box = shapes.box()
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in box.positions)
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in box.triangles + 1)
    (tmp_path / "box.obj").write_text(rows + faces)
    made = Scene.from_arrays(box.positions, box.triangles)
    np.testing.assert_array_equal(picture(made), picture(ssdo_gl.load_scene(tmp_path / "box.obj")))
    assert made.is_framed and made.notes and made.environment is not None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"positions": [[0, 0], [1, 1]]}, r"positions: expected shape \(V, 3\), got \(2, 2\)"),
        ({"positions": None}, "positions: expected an array of numbers, got one without rows"),
        ({"triangles": []}, r"triangles: expected shape \(T, 3\), T from 1 on, got \(0,\)"),
        ({"positions": [["a", 0, 0]]}, "positions: expected an array of numbers, got one of <U"),
        ({"positions": [[0, 0, 0], [1]]}, "positions: .* of rows that differ in length"),
        ({"positions": [[0, 0, np.nan], *QUAD[1:]]}, r"positions\[0\] = .*: expected finite"),
        ({"triangles": [[0, 1, 4]]}, r"triangles\[0\] = \[0, 1, 4\]: there are 4 positions"),
        ({"triangles": [[0.5, 1, 2]]}, "triangles: expected an array of whole numbers"),
        ({"triangles": [[0, 1]]}, r"triangles: expected shape \(T, 3\)"),
        ({"triangles": [[0, 0, 1]]}, "triangles: none has an area"),
        ({"normals": [[0, 1, 0]]}, r"normals: expected shape \(4, 3\), got \(1, 3\)"),
        ({"normals": "sharp"}, "normals = 'sharp': expected an array, 'smooth' or None"),
        ({"uvs": QUAD}, r"uvs: expected shape \(4, 2\), got \(4, 3\)"),
        (
            {"colors": [[0, 1, 0]] * 3 + [[0, 200, 30]]},
            r"colors\[3\] = \[0.0, 200.0, 30.0\]: expected numbers from 0 to 1, or uint8",
        ),
        ({"colors": [[1, 1]]}, r"colors: expected numbers of shape \(V, 3\) or \(V, 4\)"),
        ({"transform": np.eye(3)}, r"transform: expected affine matrices, .* got shape \(3, 3\)"),
        ({"transform": np.zeros((4, 4))}, "another last row than 0 0 0 1"),
        ({"transform": np.diag([1, 1, 0, 1])}, "finite matrices that have an inverse"),
        ({"positions": 3}, "positions: expected an array of numbers, got one without rows"),
        ({"lights": ["sun"]}, "lights: expected a light, got a str"),
        ({"lights": 3}, "lights: expected a list of lights, got an int"),
        ({"environment": 3}, "environment: expected an environment, got an int"),
        ({"render": 3}, "render: expected a mapping, got an int"),
        ({"material": "red"}, "material: expected a Material, got a str"),
        ({"camera": 5}, "camera: expected a Camera, got an int"),
    ],
)
def test_a_wrong_argument_is_named(changes, message):
    arguments = {"positions": QUAD, "triangles": HALVES, **changes}
    with pytest.raises((SceneError, SettingError), match=message) as caught:
        Scene.from_arrays(**arguments)
    assert "\n" not in str(caught.value) and "--" not in str(caught.value)


def test_columns_in_memory_make_the_same_picture():
    columns = Scene.from_arrays(np.asfortranarray(QUAD), np.asfortranarray(HALVES))
    rows = Scene.from_arrays(QUAD, HALVES)
    np.testing.assert_array_equal(picture(columns), picture(rows))


def test_bytes_are_srgb_and_floats_are_linear():
    codes = np.array([[188, 0, 255]] * 4, np.uint8)
    mesh = Mesh.from_arrays(QUAD, HALVES, colors=codes)
    # 188 / 255 stands for half of the light.
    np.testing.assert_allclose(mesh.colors[0], [0.5029, 0.0, 1.0, 1.0], atol=1e-4)
    linear = Mesh.from_arrays(QUAD, HALVES, colors=[[0.5, 0.0, 1.0, 0.25]] * 4)
    np.testing.assert_array_equal(linear.colors[0], [0.5, 0.0, 1.0, 0.25])
    assert Scene.from_arrays(QUAD, HALVES, colors=codes).materials[0].albedo == (1.0, 1.0, 1.0)


def test_smooth_normals_are_made():
    ball = shapes.sphere()
    mesh = Mesh.from_arrays(ball.positions, ball.triangles, normals="smooth")
    unit = mesh.positions / np.linalg.norm(mesh.positions, axis=1, keepdims=True)
    # Chords of a sphere lean from its normal by less than a segment.
    assert np.einsum("ij,ij->i", unit, mesh.normals).min() > 0.99
    assert Mesh.from_arrays(ball.positions, ball.triangles).normals is None


def test_given_light_is_all_the_light():
    lit = Scene.from_arrays(QUAD, HALVES, lights=[LAMP])
    assert lit.lights == (LAMP,) and lit.environment is None
    sky = Scene.from_arrays(QUAD, HALVES, environment=ConstantEnvironment((1, 1, 1)))
    assert sky.lights == () and sky.environment == ConstantEnvironment((1, 1, 1))


def test_what_is_added_is_framed_and_replaces_added_light():
    start = Scene.from_arrays(QUAD, HALVES, name="floor")
    assert start.added_light_count == 1 and start.has_added_sky
    more = start.add(shapes.box(), name="box", transform=ssdo_gl.transform_matrix((5, 0, 0)))
    assert [item.name for item in more.objects] == ["floor", "box"]
    assert more.camera.distance > 1.5 * start.camera.distance
    assert len(more.lights) == 1 and more.environment == start.environment
    lit = more.add(LAMP, PANEL)
    assert lit.lights == (LAMP, PANEL) and lit.environment is None
    body = next(item for item in lit.objects if item.light is not None)
    assert lit.lights[body.light] is PANEL and body.name == "panel"
    later = lit.add(shapes.box(), material=lit.materials[0])
    assert later.lights == lit.lights and len(later.materials) == len(lit.materials)
    # A camera of one's own stays.
    seen = start.with_camera(ssdo_gl.Camera.look_at((0, 1, 9)))
    assert seen.add(shapes.box()).camera == seen.camera


def test_what_was_told_of_a_file_stays_told(tmp_path):
    for name, rest in {"lines": "l 1 2\n", "curves": "curv 0 1 2\n"}.items():
        (tmp_path / f"{name}.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + rest)
    lines, curves = (ssdo_gl.load_scene(tmp_path / f"{n}.obj") for n in ("lines", "curves"))
    assert len(lines.notes) > 1  # of light that is added, too
    assert lines.add(LAMP).add(curves).notes == ("not drawn: 1 line", "not drawn: 1 curve")


def test_a_part_has_the_same_bytes_however_it_came():
    """A floor with a box on it: in one go, and one after the other."""
    camera = ssdo_gl.Camera.look_at((2, 3, 6), fov_y=40.0)
    lifted = ssdo_gl.transform_matrix((0, 1, 0), (0, 30, 0), 0.5)
    red = Material("red", albedo=(0.7, 0.1, 0.1))
    floor, box = Mesh.from_arrays(QUAD, HALVES), shapes.box()
    by_hand = Scene(
        meshes=(floor, box),
        materials=(Material(), red),
        objects=(ssdo_gl.SceneObject(0, 0), ssdo_gl.SceneObject(1, 1, lifted)),
        camera=camera,
        lights=(LAMP,),
    )
    added = Scene.from_arrays(QUAD, HALVES, lights=[LAMP], camera=camera)
    added = added.add(box, material=red, transform=lifted)
    np.testing.assert_array_equal(picture(added), picture(by_hand))


def test_emissive_surfaces_become_lights_and_mirrored_ones_keep_their_front():
    glow = Material("glow", albedo=(0, 0, 0), emission=(4, 4, 4))
    scene = Scene.from_arrays(QUAD, HALVES).add(shapes.quad(), material=glow, name="lamp")
    assert any(light.name == "lamp" and light.emitted == (4, 4, 4) for light in scene.lights)
    places = np.stack([np.eye(4), np.diag([-1.0, 1, 1, 1])])
    twice = Scene.from_arrays(QUAD, HALVES, transform=places)
    assert [len(item.world_from_object) for item in twice.objects] == [1, 1]
    for item in twice.objects:
        assert np.linalg.det(item.world_from_object[0, :3, :3]) > 0.0


def test_a_scene_is_placed_in_another():
    corner = ssdo_gl.load_scene("corner")
    moved = ssdo_gl.transform_matrix((10, 0, 0))
    scene = Scene.from_arrays(QUAD, HALVES).add(corner, transform=moved, name="corner")
    assert scene.triangle_count == 2 + corner.triangle_count
    _, high = corner.bounds()
    assert scene.bounds()[1][0] == pytest.approx(max(high[0] + 10.0, 1.0))
    with pytest.raises(SceneError, match=r"add: .* moves: it cannot be placed"):
        scene.add(ssdo_gl.load_scene("carousel"))
    with pytest.raises(SceneError, match=r"add: expected a Mesh, .* got a str"):
        scene.add("bunny.ply")


def test_changes_share_all_else():
    scene = Scene.from_arrays(QUAD, HALVES, name="floor", lights=[LAMP, PANEL])
    up = scene.with_transform("floor", ssdo_gl.transform_matrix((0, 0.5, 0)))
    assert up.meshes is scene.meshes and up.lights is scene.lights
    assert up.objects[0].world_from_object[0, 1, 3] == 0.5
    red = Material("red", albedo=(1, 0, 0))
    painted = scene.with_material(0, red)
    assert painted.materials[painted.objects[0].material] is red
    dim = scene.with_light("lamp", dataclasses.replace(LAMP, intensity=(1, 1, 1)))
    assert dim.lights[0].emitted == (1, 1, 1) and dim.objects[0] is scene.objects[0]
    higher = scene.with_light(1, PANEL.moved_to((0, 3, 0)))
    body = next(item for item in higher.objects if item.light == 1)
    assert body.world_from_object[0, 1, 3] == 3.0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: s.with_transform("flor", np.eye(4)), "object 'flor': there is none.*floor"),
        (lambda s: s.with_transform(7, np.eye(4)), "object 7: expected an index from 0 to"),
        (lambda s: s.with_transform(0, np.diag([-1, 1, 1, 1])), "transform: it mirrors"),
        (lambda s: s.with_light("lamp", PANEL), "expected a PointLight, got a RectangleLight"),
        (lambda s: s.with_material(0, Material(emission=(1, 0, 0))), "what emits has lights"),
        (lambda s: s.with_material(0, "red"), "material: expected a Material, got a str"),
        (lambda s: s.with_camera(3), "camera: expected a Camera, got an int"),
        (lambda s: Scene(3, (), (), s.camera), "meshes: expected a tuple, got an int"),
        (lambda s: dataclasses.replace(s, render=3), "render: expected a mapping, got an int"),
        (lambda s: dataclasses.replace(s, camera_motion=3), "camera_motion = 3: expected a Traj"),
    ],
)
def test_a_change_that_cannot_be_is_refused(change, message):
    with pytest.raises(SceneError, match=message):
        change(Scene.from_arrays(QUAD, HALVES, name="floor", lights=[LAMP]))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"objects": (ssdo_gl.SceneObject(3, 5),)}, r"objects\[0\].mesh = 3: the scene has 1"),
        ({"objects": (ssdo_gl.SceneObject(0, 5),)}, r"objects\[0\].material = 5: the scene has 1"),
        ({"objects": (ssdo_gl.SceneObject(0, 0, np.eye(3)),)}, r"expected shape \(N, 4, 4\)"),
        ({"meshes": (Mesh(QUAD, [[0, 1, 9]]),)}, r"meshes\[0\].triangles\[0\] = \[0, 1, 9\]"),
        ({"meshes": (QUAD,)}, r"meshes\[0\]: expected a Mesh, got a list"),
        ({"camera": (0, 0, 4)}, "camera: expected a Camera, got a tuple"),
        ({"environment": (1, 1, 1)}, "environment: expected an environment, got a tuple"),
    ],
)
def test_a_renderer_refuses_a_scene_that_cannot_be_drawn(changes, message):
    scene = Scene.from_arrays(QUAD, HALVES, lights=[LAMP])
    faulty = dataclasses.replace(scene, **changes)
    assert repr(faulty).startswith("Scene(1 object, ")
    with pytest.raises(SceneError, match=message):
        ssdo_gl.Renderer(faulty, SMALL)
    with pytest.raises(SceneError, match="settings: expected a Settings, got a dict"):
        ssdo_gl.Renderer(ssdo_gl.load_scene("corner"), {"size": (8, 8)})
    with pytest.raises(SceneError, match="scene: expected a Scene, got a str"):
        ssdo_gl.Renderer("corner")
    with pytest.raises(SceneError, match="objects: expected at least one"):
        ssdo_gl.Renderer(dataclasses.replace(scene, objects=()), SMALL)
    with pytest.raises(SceneError, match="options: expected a LoadOptions, got a dict"):
        ssdo_gl.load_scene("corner", {"up": "z"})


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PointLight((0, 0), (1, 1, 1)), "position = .*: expected three numbers"),
        (lambda: PointLight((0, 0, 0), (1, -1, 1)), "intensity = .*: expected numbers from 0 on"),
        (lambda: ssdo_gl.DirectionalLight((0, 0, 0), (1, 1, 1)), "direction = .*: expected a dir"),
        (lambda: ssdo_gl.DirectionalLight((0, 1, 0), (1, 1, 1), 95.0), "angle = 95.0: expected"),
        (
            lambda: ssdo_gl.SpotLight((0, 0, 0), (0, -1, 0), (1, 1, 1), 50.0, 40.0),
            "0 <= inner <= outer < 90 degrees",
        ),
        (lambda: PointLight((0, 0, 0), (1, 1, 1), shadow="soft"), "shadow = 'soft': expected one"),
        (lambda: ssdo_gl.ConstantEnvironment(0.5), "radiance = 0.5: expected three numbers"),
        (lambda: ssdo_gl.ConstantEnvironment((-1, 0, 0)), "radiance = .* numbers from 0 on"),
        (
            lambda: ssdo_gl.GradientEnvironment((1, 1, 1), (1, 1, 1), (1, float("nan"), 1)),
            "ground = .*: expected finite numbers",
        ),
        (lambda: MapEnvironment("sky.hdr"), "image = 'sky.hdr': expected an array"),
        (lambda: MapEnvironment(np.ones((2, 4, 4))), "image = .*: expected an array"),
        (lambda: MapEnvironment(np.ones((0, 4, 3))), "image: expected finite numbers from 0 on"),
        (lambda: MapEnvironment(np.full((2, 4, 3), np.nan)), "image: expected finite numbers"),
        (lambda: MapEnvironment(-np.ones((2, 4, 3))), "image: expected finite numbers from 0 on"),
        (lambda: MapEnvironment(np.ones((2, 4, 3)), math.inf), "rotation_y = inf: expected deg"),
        (lambda: ssdo_gl.Texture("wood.png"), "pixels = 'wood.png': expected an array"),
        (
            lambda: ssdo_gl.Texture(np.ones((2, 2, 3))),
            r"pixels: got float64 of shape \(2, 2, 3\): expected \(height, width, 4\)",
        ),
        (lambda: ssdo_gl.Texture(np.ones((1, 20000, 4), np.uint8)), "each side 1 to 16384"),
        (lambda: ssdo_gl.Texture(np.ones((0, 2, 4), np.uint8)), "each side 1 to 16384"),
        (lambda: ssdo_gl.Texture(np.ones((2, 2, 4), np.uint16)), "expected uint8 or floats"),
        (lambda: ssdo_gl.Texture(TEXELS, wrap="repeat"), "wrap = 'repeat': expected a pair"),
        (lambda: ssdo_gl.Texture(TEXELS, wrap=("clamp", "mirror")), "wrap = .*: expected a pair"),
        (lambda: Material((1, 0, 0)), r"name = \(1, 0, 0\): expected text; colours have names"),
        (
            lambda: Material(albedo_texture="wood.png"),
            "albedo_texture = 'wood.png': expected a Texture",
        ),
        (lambda: Material(albedo="red"), "albedo = 'red': expected three numbers"),
        (lambda: Material(emission=(1, -1, 1)), "emission = .*: expected numbers from 0 on"),
        (
            lambda: Material(albedo=(0, 2, 0)),
            "albedo = .*: expected numbers from 0 to 1",
        ),
        (lambda: Material(ior=0.5), "ior = 0.5: expected 0, or a number from 1 on"),
        (lambda: Material(ior=float("nan")), "ior = nan: expected a finite number"),
        (lambda: Material(normal_scale="1"), "normal_scale = '1': expected a finite number"),
        (
            lambda: Material(occlusion_strength=5),
            "occlusion_strength = 5: expected a number from 0",
        ),
        (lambda: Material(alpha_cutoff=float("nan")), "alpha_cutoff = nan: expected a finite"),
        (lambda: Material(specular_color=(1, 2e30, 1)), "specular_color = .*: expected at most"),
        (lambda: Material(is_unlit="no"), "is_unlit = 'no': expected a bool"),
        (lambda: SceneObject(-1, 0), "mesh = -1: expected an index from 0 on"),
        (lambda: SceneObject(0, "red"), "material = 'red': expected an index from 0 on"),
        (lambda: SceneObject(0, 0, light=0.5), "light = 0.5: expected an index from 0 on"),
        (lambda: SceneObject(0, 0, 3), "world_from_object: .* one without rows"),
        (lambda: SceneObject(0, 0, motion=3), "motion = 3: expected a Trajectory or None"),
        (lambda: Material(roughness=7), "roughness = 7: expected a number from 0 to 1"),
        (lambda: Material(metallic=float("nan")), "metallic = nan: expected a number from 0 to 1"),
    ],
)
def test_lights_and_materials_without_meaning_are_refused(make, message):
    with pytest.raises(SettingError, match=message):
        make()


@pytest.mark.parametrize("kind", [np.float16, np.float64])
def test_images_of_other_floats_are_kept_as_float32(kind):
    pixels = np.full((2, 2, 4), 0.5, kind)
    pixels[0, 0, 0] = np.nan
    texture = ssdo_gl.Texture(pixels)
    assert texture.pixels.dtype == np.float32 and texture.pixels.min() == 0.0
    assert np.isnan(pixels[0, 0, 0])
    scene = Scene.from_arrays(
        QUAD, HALVES, uvs=np.zeros((4, 2)) + 0.75, material=Material(albedo_texture=texture)
    )
    assert picture(scene, "albedo").max() == pytest.approx(0.4, abs=1e-3)


@pytest.mark.parametrize("source", [None, 5, b"corner", np.eye(4), []])
def test_what_names_no_scene_is_refused_in_one_line(source):
    with pytest.raises(SceneError, match=r"^scene: expected a name or path, got an? \w+$"):
        ssdo_gl.load_scene(source)


def test_a_turn_of_a_map_may_be_of_any_kind_of_number():
    assert MapEnvironment(np.ones((2, 4, 3)), np.float32(30)).rotation_y == 30
    assert MapEnvironment(np.ones((2, 4, 3)), np.int64(30)).rotation_y == 30


def test_directions_become_unit_vectors():
    assert ssdo_gl.DirectionalLight((0, -3, 4), (1, 1, 1)).direction == (0.0, -0.6, 0.8)


def test_a_renderer_keeps_what_a_change_leaves_alone():
    """Another light, place or camera: the picture of a new renderer, without its set-up."""
    scene = Scene.from_arrays(QUAD, HALVES, name="floor", lights=[LAMP])
    scene = scene.add(shapes.box(), name="box", transform=ssdo_gl.transform_matrix((0, 0.3, 0)))
    moved = scene.with_transform("box", ssdo_gl.transform_matrix((0.4, 0.3, 0), scale=0.5))
    dim = moved.with_light("lamp", dataclasses.replace(LAMP, intensity=(1, 2, 1)))
    seen = dim.with_camera(dim.camera.orbit(20.0))
    with ssdo_gl.Renderer(scene, SMALL) as renderer:
        renderer.render()
        compiled = renderer.shaders
        for changed, kept in ((moved, set()), (dim, {"gbuffer"}), (seen, {"shadow_map"})):
            renderer.use_scene(changed)
            result = renderer.render()
            np.testing.assert_array_equal(result.images["beauty"], picture(changed))
            assert kept <= {row.name for row in result.passes if "kept" in row.reason}
        assert renderer.shaders is compiled


@pytest.mark.parametrize(("moves", "most", "method"), [
    (False, 2, None), (False, 1, "bounce"), (True, 2, None), (True, 1, "bounce"),
])  # fmt: skip
def test_what_rays_take_long_for_asks_for_a_method_without(monkeypatch, moves, most, method):
    monkeypatch.setattr(defaults, "MOST_TRACED_MOVING" if moves else "MOST_TRACED", most)
    builder = SceneBuilder("quad")
    motion = Motion(spin=(0.0, 45.0, 0.0)) if moves else None
    mesh = builder.mesh("quad", lambda: Mesh.from_arrays(QUAD, HALVES))
    builder.add(SceneObject(mesh, builder.material(Material("grey")), np.eye(4)[None], motion))
    scene = builder.build(Scene, None, None)
    said = any("the usual method is bounce" in note for note in scene.notes)
    assert (scene.render.get("method"), said) == (method, method is not None)
    assert builder.build(Scene, None, None, render={"method": "gi"}).render["method"] == "gi"

"""The TOML scene format: every key arrives where it should."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ssdo_gl.math3d import transform_points
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene, SceneError

SceneOf = Callable[[str], Scene]
Write = Callable[[dict[str, str | bytes]], Path]


def scene(text: str) -> Scene:
    return read_description(text, "scene.toml")


def only_bounds(text: str) -> tuple[list[float], list[float]]:
    low, high = scene(f"[[object]]\n{text}").bounds()
    return low.round(12).tolist(), high.round(12).tolist()


def test_camera_title_and_settings(scene_of: SceneOf) -> None:
    result = scene_of(
        """
        title = "T"
        purpose = "P"
        [camera]
        position = [1, 2, 3]
        target = [0, 0.5, 0]
        up = [0, 0, 1]
        fov_y = 55
        exposure = -1.5
        [render]
        radius = 0.25
        method = "ssao"
        samples = 32
        size = [320, 200]
        """
    )
    assert (result.title, result.purpose) == ("T", "P")
    camera = result.camera
    assert (camera.position, camera.target, camera.up) == ((1, 2, 3), (0, 0.5, 0), (0, 0, 1))
    assert (camera.fov_y, camera.exposure) == (55.0, -1.5)
    assert result.render == {
        "radius": 0.25,
        "method": "ssao",
        "samples": 32,
        "size": (320, 200),
    }


def test_cameras_of_parallel_rays(scene_of: SceneOf) -> None:
    where = "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n"
    for word in ("orthographic", "ortho"):
        camera = scene_of(f'{where}projection = "{word}"\nheight = 3').camera
        assert (camera.position, camera.height) == ((0, 0, 5), 3.0)
    # As much as a pinhole would show at the target.
    camera = scene_of(f'{where}projection = "orthographic"\nfov_y = 90').camera
    assert camera.height == pytest.approx(10.0)
    assert scene_of(f'{where}projection = "perspective"').camera.height is None


def test_parallel_rays_frame_the_whole_scene(scene_of: SceneOf) -> None:
    scene = scene_of('[camera]\nprojection = "orthographic"')
    camera = scene.camera
    low, high = scene.bounds()
    corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, high, low)
    local = (corners - np.asarray(camera.position)) @ camera.view_from_world_rotation().T
    assert camera.height is not None
    assert np.all(np.abs(local[:, :2]) < 0.5 * camera.height) and np.all(local[:, 2] < 0.0)
    assert camera.height < 1.1 * float(np.ptp(local[:, :2], axis=0).max())


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("height = 3", "belongs to projection"),
        ('projection = "ortho"\nheight = 0', "height = 0: expected a number at least 1e-15"),
        ('projection = "ortho"\nheight = -1', "height = -1"),
        ('projection = "isometric"', "projection = 'isometric': expected one of perspective"),
        ("projection = 3", "projection = 3: expected one of"),
    ],
)
def test_bad_projections_are_refused(scene_of: SceneOf, text: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        scene_of(f"[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n{text}")


def test_without_a_camera_the_scene_is_framed_with_its_settings(scene_of: SceneOf) -> None:
    camera = scene_of("[camera]\nfov_y = 70\nexposure = 2").camera
    assert (camera.fov_y, camera.exposure) == (70.0, 2.0)
    # The box [0, 1] x [0, 2] x [0, 3] is looked at.
    assert np.all(np.abs(np.subtract(camera.target, (0.5, 1.0, 1.5))) < 0.5)


def test_no_light_at_all_gets_a_sky_and_a_key_and_says_so(scene_of: SceneOf) -> None:
    result = scene_of("")
    assert isinstance(result.environment, GradientEnvironment)
    assert len(result.lights) == 1
    assert result.lights[0].name == "key light"
    assert any("soft sky" in note for note in result.notes)


def test_a_black_environment_is_a_choice(scene_of: SceneOf) -> None:
    result = scene_of('[environment]\nkind = "constant"\nradiance = [0, 0, 0]')
    assert result.environment == ConstantEnvironment((0.0, 0.0, 0.0))
    assert result.lights == ()
    assert result.notes == ()


def test_gradient_environment(scene_of: SceneOf) -> None:
    result = scene_of(
        '[environment]\nkind = "gradient"\nzenith = [1, 2, 3]\nhorizon = [4, 5, 6]\n'
        "ground = [7, 8, 9]"
    )
    assert result.environment == GradientEnvironment((1, 2, 3), (4, 5, 6), (7, 8, 9))


def test_map_environment(write: Write) -> None:
    header = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
    file = write(
        {
            "sky.hdr": header + bytes([128, 64, 0, 129, 0, 0, 0, 0]),
            "s.toml": '[environment]\nkind = "map"\npath = "sky.hdr"\nrotation_y = 90\nscale = 3\n'
            '[[object]]\nshape = "sphere"\nradius = 1\n',
        }
    )
    environment = load_scene(file).environment
    assert isinstance(environment, MapEnvironment)
    assert environment.rotation_y == 90.0
    assert environment.name == "sky.hdr"
    # 128 and 64 of 256 at exponent 1, times the scale.
    assert environment.image.tolist() == [[[3.0, 1.5, 0.0], [0.0, 0.0, 0.0]]]


def test_point_spot_and_directional_lights(scene_of: SceneOf) -> None:
    result = scene_of(
        """
        [[light]]
        kind = "point"
        position = [1, 2, 3]
        intensity = [4, 5, 6]
        shadow = "none"
        name = "bulb"
        [[light]]
        kind = "spot"
        position = [0, 1, 0]
        direction = [0, -2, 0]
        intensity = [1, 1, 1]
        inner_angle = 10
        outer_angle = 20
        [[light]]
        kind = "directional"
        direction = [3, 0, 4]
        irradiance = [2, 2, 2]
        shadow = "ssdo"
        """
    )
    point, spot, sun = result.lights
    assert point == PointLight((1, 2, 3), (4, 5, 6), shadow="none", name="bulb")
    assert spot == SpotLight((0, 1, 0), (0, -1, 0), (1, 1, 1), 10.0, 20.0)
    assert isinstance(sun, DirectionalLight)
    assert sun.direction == pytest.approx((0.6, 0.0, 0.8))
    assert sun.shadow == "ssdo"
    assert sun.angle == 0.0


def test_angle_of_a_directional_light(scene_of: SceneOf) -> None:
    sun = """
        [[light]]
        kind = "directional"
        direction = [0, -1, 0]
        irradiance = [2, 2, 2]
        angle = """
    (light,) = scene_of(sun + "0.53").lights
    assert light == DirectionalLight((0.0, -1.0, 0.0), (2.0, 2.0, 2.0), 0.53)
    for wrong in ("90", "-1", "nan", '"wide"'):
        with pytest.raises(ValueError, match="angle"):
            scene_of(sun + wrong)


AREA = """
[[light]]
kind = "area"
corner = [0, 5, 0]
edge_u = [2, 0, 0]
edge_v = [0, 0, 3]
radiance = [7, 8, 9]
"""


def test_a_visible_area_light_has_a_body(scene_of: SceneOf) -> None:
    result = scene_of(AREA)
    (light,) = result.lights
    assert light == RectangleLight((0, 5, 0), (2, 0, 0), (0, 0, 3), (7, 8, 9))
    (body,) = [item for item in result.objects if item.light is not None]
    assert body.light == 0
    material = result.materials[body.material]
    assert (material.albedo, material.emission) == ((0, 0, 0), (7, 8, 9))
    assert not material.two_sided_emission
    mesh = result.meshes[body.mesh]
    corners = transform_points(body.world_from_object[0], mesh.positions)
    assert corners.tolist() == [[0, 5, 0], [2, 5, 0], [2, 5, 3], [0, 5, 3]]
    # Its front is the side that shines: down.
    assert (np.linalg.inv(body.world_from_object[0])[:3, :3].T @ [0, 0, 1])[1] < 0.0


def test_an_invisible_area_light_has_none(scene_of: SceneOf) -> None:
    result = scene_of(AREA + "visible = false\ntwo_sided = true\n")
    assert [item.light for item in result.objects] == [None]
    light = result.lights[0]
    assert isinstance(light, RectangleLight)
    assert light.two_sided


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


def test_materials() -> None:
    result = scene(
        """
        [materials.m]
        albedo = [0.1, 0.2, 0.3]
        emission = [0, 0, 0]
        alpha = 0.5
        alpha_cutoff = 0.25
        [[object]]
        shape = "sphere"
        radius = 1
        material = "m"
        """
    )
    material = result.materials[0]
    assert material.name == "m"
    assert material.albedo == (0.1, 0.2, 0.3)
    assert (material.alpha, material.alpha_cutoff) == (0.5, 0.25)
    assert not material.emits


def test_a_mesh_file_takes_the_material_of_the_scene(write: Write) -> None:
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    file = write(
        {
            "models/tri.obj": obj,
            "s.toml": '[materials.red]\nalbedo = [1, 0, 0]\n[[object]]\nshape = "mesh"\n'
            'path = "models/tri.obj"\nmaterial = "red"\n[[object]]\nshape = "mesh"\n'
            'path = "models/tri.obj"\ntransform = { scale = 2 }\nname = "own"\n',
        }
    )
    result = load_scene(file)
    albedos = [result.materials[item.material].albedo for item in result.objects]
    assert albedos == [(1.0, 0.0, 0.0), (0.8, 0.8, 0.8)]
    assert result.bounds()[1].tolist() == [2.0, 2.0, 0.0]


def test_a_scene_file_may_start_with_a_byte_order_mark(write: Write) -> None:
    file = write({"s.toml": b"\xef\xbb\xbf" + b'[[object]]\r\nshape = "sphere"\r\nradius = 1\r\n'})
    assert load_scene(file).triangle_count > 0


def test_the_example_of_the_documentation_is_a_scene() -> None:
    page = Path(__file__).parents[4] / "docs" / "scene-format.md"
    example, *_ = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    result = scene(example)
    assert result.notes == ()
    # Six boxes that spin, each about itself, a plane, and the body of the lamp.
    assert sum(item.motion is not None for item in result.objects) == 6
    assert len(result.objects) == 8


number = st.floats(-1e3, 1e3, allow_nan=False).map(lambda x: round(x, 6))


@given(low=st.tuples(number, number, number), size=st.tuples(*[st.floats(1e-3, 1e3)] * 3))
def test_boxes_round_trip(low: tuple[float, ...], size: tuple[float, ...]) -> None:
    high = np.add(low, size)
    text = f'[[object]]\nshape = "box"\nmin = {list(low)}\nmax = {high.tolist()}\n'
    bounds = scene(text).bounds()
    assert bounds[0] == pytest.approx(low, abs=1e-9)
    assert bounds[1] == pytest.approx(high, abs=1e-9)


@pytest.mark.parametrize(
    "text",
    [
        f"{'a' * 900} = 1\n",
        f'[[object]]\nshape = "sphere"\nradius = 1\nname = "{"a" * 900}"\nmaterial = "x"\n',
        f'[[object]]\nshape = "sphere"\nradius = 1\nmaterial = "{"a" * 900}"\n',
        f'[[object]]\nshape = "sphere"\nradius = 1\n{"a" * 900} = 1\n',
    ],
)
def test_names_of_any_length_leave_errors_short(text: str, error_of: Callable[..., str]) -> None:
    assert len(error_of("scene.toml", text=text)) < 400


BOX = '[[object]]\nshape = "box"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\nmaterial = "m"\n'


@pytest.mark.parametrize(
    ("keys", "specular", "is_glossy"),
    [
        ("", 0.0, False),
        ("roughness = 0.2", 1.0, True),
        ("metallic = 1", 1.0, True),
        ("roughness = 0.2\nspecular = 0", 0.0, False),
        ("specular = 0.5", 0.5, True),
        ("ior = 1", 1.0, False),
    ],
)
def test_gloss_is_asked_for_by_any_of_its_keys(keys: str, specular: float, is_glossy: bool) -> None:
    result = scene(f"[materials.m]\n{keys}\n{BOX}")
    material = result.materials[result.objects[0].material]
    assert material.specular == specular
    assert material.is_glossy == is_glossy


def test_a_dielectric_of_ior_1_5_reflects_4_percent() -> None:
    result = scene(f"[materials.m]\nroughness = 1\n{BOX}")
    material = result.materials[result.objects[0].material]
    assert material.dielectric_color == pytest.approx((0.04,) * 3)

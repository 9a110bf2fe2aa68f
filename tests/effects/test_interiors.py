"""Rooms that light reaches by detours: all of it against paths.

Most of it arrives along per-pixel rays, `rays/arriving.glsl`.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.light_edits import with_lights
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

INTERIORS = Path(__file__).parent / "interiors"
SIZE = (160, 90)
MEAN_BOUND = 0.05
# With the noise of 256 paths, which is most of it in the cellar.
RELMSE_BOUND = 0.03
# Light from outside, with probes there, too: .89 too much where it is spread over all of the plane.
BESIDE_SKY_BOUND = 0.3
# .09 too little where what pictures cover counts as much as the wall between them.
PICTURES_BOUND = 0.03
# Part of the light of the lit room that may come through a wall of 1/1000 of its width.
LEAK_BOUND = 1e-3
# .17 too much where a glossy floor sends on as much of the spot as of light from everywhere.
GLOSS_BOUND = 0.06
# Of what a lamp brought, after so many frames without it; and in how many light comes to rest.
LEFT_BOUND, FRAMES_TO_GO, FRAMES_TO_REST = 0.02, 7, 12
# Rounding decides which of two surfaces a few rays meet.
PLACE_BOUND = 1e-4


def picture(name: str, method: str, **settings: object) -> np.ndarray:
    image = ssdo_gl.render(INTERIORS / f"{name}.toml", size=SIZE, method=method, **settings)
    return image[..., :3].astype(np.float64)


@pytest.mark.parametrize("name", ["attic", "cellar", "corridor", "door", "loft"])
def test_all_of_the_light_of_an_interior(name: str) -> None:
    reference = picture(name, "reference-gi", spp=256)
    found = picture(name, "gi")
    assert found.mean() == pytest.approx(reference.mean(), rel=MEAN_BOUND)
    error = np.mean((found - reference) ** 2 / (reference**2 + 0.01))
    assert error <= RELMSE_BOUND
    near = picture(name, "bounce")
    assert error < np.mean((near - reference) ** 2 / (reference**2 + 0.01))


def test_a_wall_that_goes_on_outside_is_not_lit_by_what_lies_there() -> None:
    """Beside the window a pixel shows the loft's end wall, or the same plane under the sky."""
    inside = np.s_[35:45, 78:95]
    found, reference = (
        picture("loft", method, **settings)[inside].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 256}))
    )
    assert found == pytest.approx(reference, rel=BESIDE_SKY_BOUND)


def test_a_glossy_floor_sends_on_less_of_what_arrives_upright() -> None:
    found, reference = (
        picture("spotlit_floor", method, **settings).mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 256}))
    )
    assert found == pytest.approx(reference, rel=GLOSS_BOUND)


def test_pictures_do_not_darken_what_the_wall_beside_them_sends_on() -> None:
    """Dark ones hang a millimetre before two walls and cover four ninths of them."""
    found, reference = (
        picture("panels", method, **settings).mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 128}))
    )
    assert found == pytest.approx(reference, rel=PICTURES_BOUND)


SHADED_LAMP = """
[camera]
position = [1.7, 1.4, 1.7]
target = [-0.4, 0.8, -0.5]
fov_y = 60
[materials.white]
albedo = [0.8, 0.8, 0.8]
[[light]]
kind = "point"
position = [0, 0.85, 0]
intensity = [1, 1, 1]
[[object]]
shape = "box"
min = [-2, 0, -2]
max = [2, 2.4, 2]
material = "white"
"""
# As wide above as below, so that each one's edges lie outside of the next ones.
SHEET = """
[[object]]
shape = "quad"
corner = [-0.036, 0.72, 0.16]
edge_u = [0.072, 0, 0]
edge_v = [0, 0.3, -0.05]
material = "white"
transform = {{ rotate = [0, {degrees}, 0] }}
"""


def test_sheets_that_overlap_send_on_the_light_within_them(tmp_path: Path) -> None:
    """Two thirds of the light leave the shade of a lamp by way of its sheets."""
    file = tmp_path / "lampshade.toml"
    file.write_text(SHADED_LAMP + "".join(SHEET.format(degrees=22.5 * k) for k in range(16)))
    found, reference = (
        ssdo_gl.render(file, size=SIZE, method=method, **settings)[..., :3].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 128}))
    )
    assert found == pytest.approx(reference, rel=MEAN_BOUND)


def test_next_to_nothing_comes_through_a_thin_wall() -> None:
    scene = load_scene(INTERIORS / "wall.toml")
    lit_side = Camera((-1.5, 1.0, 1.8), (-0.4, 0.8, -0.5), fov_y=80.0)
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=0.3)) as renderer:
        dark = renderer.render(("beauty",)).images["beauty"][..., :3].mean()
        lit = renderer.render(("beauty",), camera=lit_side).images["beauty"][..., :3].mean()
    assert lit > 0.1
    assert dark < LEAK_BOUND * lit


GROUND = """
[camera]
position = [0.9, 1.4, 1.6]
target = [-0.9, 0.9, -1.6]
fov_y = 70
[render]
radius = 0.3
[[light]]
kind = "directional"
direction = [-0.5, -1, 0.4]
irradiance = [20, 20, 20]
[[object]]
shape = "quad"
corner = [-6, 0, 7]
edge_u = [12, 0, 0]
edge_v = [0, 0, -14]
material = "grey"
[materials.grey]
albedo = [0.6, 0.6, 0.6]
"""


def closed_room(thickness: float) -> str:
    """Return two closed rooms beside each other on a wide ground in the sun, as a scene file."""
    half, lines = 0.5 * thickness, [GROUND]
    walls = [((x, x), (-2.0, 2.0), (0.0, 2.5)) for x in (-1.3, 1.3, 3.1)]
    walls += [((-1.3, 3.1), (z, z), (0.0, 2.5)) for z in (-2.0, 2.0)]
    walls += [((-1.3, 3.1), (-2.0, 2.0), (2.5, 2.5))]
    for (x0, x1), (z0, z1), (y0, y1) in walls:
        low, high = np.array([x0, y0, z0]), np.array([x1, y1, z1])
        if thickness:
            lines += ['[[object]]\nshape = "box"', f"min = {(low - half).tolist()}"]
            lines += [f"max = {(high + half).tolist()}"]
        else:
            edges = [e.tolist() for e in np.diag(high - low) if e.any()]
            lines += ['[[object]]\nshape = "quad"', f"corner = {low.tolist()}"]
            lines += [f"edge_u = {edges[0]}\nedge_v = {edges[1]}"]
        lines.append('material = "grey"')
    return "\n".join(lines)


@pytest.mark.parametrize("thickness", [0.0, 0.1])
def test_no_sun_comes_through_the_corners_of_a_dark_room(thickness: float, tmp_path: Path) -> None:
    # Pieces of the ground are half a metre wide: in corners they reach out of the room, and
    # where its walls meet those of the next room, into that, too.
    file = tmp_path / "room.toml"
    file.write_text(closed_room(thickness))
    settings = Settings(method="gi", size=SIZE, shadows="traced")
    with Renderer(load_scene(file), settings) as renderer:
        dark = renderer.render(("beauty",)).images["beauty"][..., :3]
    assert dark.max() < 1e-6


# Of 640x360 pixels of that room, by the sun's angle: where walls meet on less than a texel. 215
# and 258 were.
LIT_AT_JOINTS = {0.0: 30, 1.0: 160}


@pytest.mark.parametrize("angle", LIT_AT_JOINTS)
def test_hardly_any_sun_comes_through_joints_of_a_room_by_maps(
    angle: float, tmp_path: Path
) -> None:
    file = tmp_path / "room.toml"
    sun = 'kind = "directional"'
    file.write_text(closed_room(0.0).replace(sun, f"{sun}\nangle = {angle}"))
    settings = Settings(method="direct", size=(640, 360))
    with Renderer(load_scene(file), settings) as renderer:
        dark = renderer.render(("direct",)).images["direct"][..., :3]
    assert np.count_nonzero(dark.max(axis=-1) > 1e-6) <= LIT_AT_JOINTS[angle]


def placed(scene: Scene, scale: float, offset: float) -> Scene:
    """Return a scene without lamps, as large and as far away as that, seen alike."""
    matrix = math3d.translation((offset, -offset, offset)) @ math3d.scaling(scale)
    objects = tuple(
        dataclasses.replace(item, world_from_object=matrix @ item.world_from_object)
        for item in scene.objects
    )
    position, target = (
        tuple(math3d.transform_points(matrix, point))
        for point in (scene.camera.position, scene.camera.target)
    )
    camera = dataclasses.replace(scene.camera, position=position, target=target)
    return dataclasses.replace(scene, objects=objects, camera=camera)


@pytest.mark.parametrize(("scale", "offset"), [(1e-3, 0.0), (1e4, 0.0), (1.0, 1e5)])
def test_an_attic_is_as_bright_in_any_unit_and_place(scale: float, offset: float) -> None:
    scene = load_scene(INTERIORS / "attic.toml")
    assert not scene.lights
    found = []
    for where in ((1.0, 0.0), (scale, offset)):
        settings = Settings(method="gi", size=SIZE, radius=0.4 * where[0])
        with Renderer(placed(scene, *where), settings) as renderer:
            found.append(renderer.render(("beauty",)).images["beauty"][..., :3])
    assert found[1].mean() == pytest.approx(found[0].mean(), rel=PLACE_BOUND)
    assert np.mean(np.isclose(found[1], found[0], rtol=0.01)) > 0.98


@pytest.mark.parametrize("name", ["cornell_meso", "stairs"])
def test_a_lamp_that_goes_out_is_gone_within_seven_frames_of_a_window(name: str) -> None:
    """Direct light is gone in the first; the rest are bounces, which the surface cache adds up.

    The last frame is that of a view at rest: per-pixel rays find 1 % more.
    """
    lit = load_scene(name)
    brightest = max(lit.lights, key=lambda light: light.power)
    dark = with_lights(lit, lit.lights, [light is not brightest for light in lit.lights])
    settings = Settings(method="gi", size=(96, 54))

    def frame() -> np.ndarray:
        drawing = renderer.draw(("bounce", "directional"), camera=lit.camera)
        planes = (drawing.planes[name].texture for name in ("bounce", "directional"))
        return sum(read_texture(texture)[..., :3].astype(float) for texture in planes)

    with Renderer(lit, settings) as renderer:
        before = [frame() for _ in range(FRAMES_TO_REST)][-1]
        renderer.use_scene(dark)
        after = [frame() for _ in range(FRAMES_TO_GO)][-1]
    with Renderer(dark, settings) as renderer:
        never = [frame() for _ in range(FRAMES_TO_REST)][-1]
    assert (before - never).mean() > 0.01
    assert abs((after - never).mean()) < LEFT_BOUND * (before - never).mean()

"""Rooms that light reaches by detours: all of it against paths.

Most of it arrives along per-pixel rays, `rays/arriving.glsl`.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_text as text

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.formats.toml import read_description
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
# .0167 for .0076 where texels of the ground are as wide as the car.
GLOW_BOUND = 0.1
# Of what a lamp brought, after so many frames without it; and in how many light comes to rest.
LEFT_BOUND, FRAMES_TO_GO, FRAMES_TO_REST = 0.02, 7, 12
# Rounding decides which of two surfaces a few rays meet.
PLACE_BOUND = 1e-4


def sheet(turn: float) -> str:
    """Return one of a lampshade, as wide above as below: its edges lie outside of the next ones."""
    edges = [0.072, 0, 0], [0, 0.3, -0.05]
    return text.quad([-0.036, 0.72, 0.16], *edges, "white", **{"transform.rotate": [0, turn, 0]})


LAMPSHADE = (
    text.camera([1.7, 1.4, 1.7], [-0.4, 0.8, -0.5], 60)
    + text.material("white", 0.8, 0.8, 0.8)
    + text.light("point", position=[0, 0.85, 0], intensity=[1, 1, 1])
    + text.box([-2, 0, -2], [2, 2.4, 2], "white")
    + "".join(sheet(22.5 * k) for k in range(16))
)
WHEELS = {"repeat.count": [2, 1, 2], "repeat.step": [2.6, 0, 1.7]}
CAR = (
    text.camera([3.2, 0.7, 3.6], [0, 0.4, 0], 40)
    + text.constant_sky(0.1, 0.12, 0.15)
    + text.material("ground", 0.5, 0.5, 0.5)
    + text.material("blue", 0.1, 0.2, 0.5)
    + text.floor(200, "ground")
    + text.box([-2, 0.3, -0.85], [2, 0.9, 0.85], "blue")
    + text.box([-1.6, 0, -0.95], [-1, 0.6, -0.75], "ground", **WHEELS)
    + text.lamp([-1.5, 0.28, -0.5], [3, 0, 0], [0, 0, 1], [3, 0.15, 0.1])
)


def picture(room: str, method: str, **settings: object) -> np.ndarray:
    """Return a picture of a room, by the name of its file or by its text."""
    source = read_description(room, "room") if "\n" in room else INTERIORS / f"{room}.toml"
    return ssdo_gl.render(source, size=SIZE, method=method, **settings)[..., :3].astype(np.float64)


@pytest.mark.parametrize("name", ["attic", "cellar", "corridor", "door", "loft"])
def test_all_of_the_light_of_an_interior(name: str) -> None:
    reference = picture(name, "reference-gi", spp=256)
    found = picture(name, "gi")
    assert found.mean() == pytest.approx(reference.mean(), rel=MEAN_BOUND)
    error = np.mean((found - reference) ** 2 / (reference**2 + 0.01))
    assert error <= RELMSE_BOUND
    near = picture(name, "bounce")
    assert error < np.mean((near - reference) ** 2 / (reference**2 + 0.01))


@pytest.mark.parametrize(
    ("room", "spp", "bound", "where"),
    [
        # Beside the window a pixel shows the loft's end wall, or the same plane under the sky.
        pytest.param(
            "loft", 256, BESIDE_SKY_BOUND, np.s_[35:45, 78:95], id="a wall goes on outside"
        ),
        pytest.param("spotlit_floor", 256, GLOSS_BOUND, ..., id="gloss, light from above"),
        # Dark ones hang a millimetre before two walls and cover four ninths of them.
        pytest.param("panels", 128, PICTURES_BOUND, ..., id="pictures on walls"),
        # Two thirds of the light leave the shade of a lamp by way of its sheets, which overlap.
        pytest.param(LAMPSHADE, 128, MEAN_BOUND, ..., id="sheets that overlap"),
        # The front of its body hardly sees what is lit under it, on a wide ground.
        pytest.param(CAR, 128, GLOW_BOUND, np.s_[34:46, 123:138, 0], id="a glow under a car"),
    ],
)
def test_the_mean_is_that_of_paths(room: str, spp: int, bound: float, where: Any) -> None:
    found, reference = (
        picture(room, method, **settings)[where].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": spp}))
    )
    assert found == pytest.approx(reference, rel=bound)


def test_next_to_nothing_comes_through_a_thin_wall() -> None:
    scene = load_scene(INTERIORS / "wall.toml")
    lit_side = Camera((-1.5, 1.0, 1.8), (-0.4, 0.8, -0.5), fov_y=80.0)
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=0.3)) as renderer:
        dark = renderer.render(("beauty",)).images["beauty"][..., :3].mean()
        lit = renderer.render(("beauty",), camera=lit_side).images["beauty"][..., :3].mean()
    assert lit > 0.1
    assert dark < LEAK_BOUND * lit


def closed_room(thickness: float, **sun: float) -> Scene:
    """Return two closed rooms beside each other on a wide ground in the sun."""
    half = 0.5 * thickness
    lines = [
        text.camera([0.9, 1.4, 1.6], [-0.9, 0.9, -1.6], 70),
        text.light("directional", direction=[-0.5, -1, 0.4], irradiance=[20, 20, 20], **sun),
        text.quad([-6, 0, 7], [12, 0, 0], [0, 0, -14], "grey"),
        text.material("grey", 0.6, 0.6, 0.6),
    ]
    walls = [((x, x), (-2.0, 2.0), (0.0, 2.5)) for x in (-1.3, 1.3, 3.1)]
    walls += [((-1.3, 3.1), (z, z), (0.0, 2.5)) for z in (-2.0, 2.0)]
    walls += [((-1.3, 3.1), (-2.0, 2.0), (2.5, 2.5))]
    for (x0, x1), (z0, z1), (y0, y1) in walls:
        low, high = np.array([x0, y0, z0]), np.array([x1, y1, z1])
        if thickness:
            lines.append(text.box((low - half).tolist(), (high + half).tolist(), "grey"))
        else:
            edges = [edge.tolist() for edge in np.diag(high - low) if edge.any()]
            lines.append(text.quad(low.tolist(), *edges, "grey"))
    return read_description("".join(lines), "room")


@pytest.mark.parametrize("thickness", [0.0, 0.1])
def test_no_sun_comes_through_the_corners_of_a_dark_room(thickness: float) -> None:
    # Pieces of the ground are half a metre wide: in corners they reach out of the room, and
    # where its walls meet those of the next room, into that, too.
    settings = Settings(method="gi", size=SIZE, shadows="traced")
    with Renderer(closed_room(thickness), settings) as renderer:
        dark = renderer.render(("beauty",)).images["beauty"][..., :3]
    assert dark.max() < 1e-6


# Of 640x360 pixels of that room, by the sun's angle: where walls meet on less than a texel. 215
# and 258 were.
LIT_AT_JOINTS = {0.0: 30, 1.0: 160}


@pytest.mark.parametrize("angle", LIT_AT_JOINTS)
def test_hardly_any_sun_comes_through_joints_of_a_room_by_maps(angle: float) -> None:
    settings = Settings(method="direct", size=(640, 360))
    with Renderer(closed_room(0.0, angle=angle), settings) as renderer:
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

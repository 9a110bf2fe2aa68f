"""The sun of an image lights scenes as a light: its shadows are those of paths."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
import scene_text as text

from ssdo_gl.images.error import relative_mse
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.environment import MapEnvironment
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.loading import LoadOptions
from ssdo_gl.settings.settings import Settings

# Of a picture under a lamp of a studio, over its mean. Where no rays are aimed at it it is .04.
MOST_NOISE = 0.02
SIZE = (96, 54)
BODIES = (
    text.camera([3, 2.2, 4], [0, 0.4, 0], 40)
    + text.material("grey", 0.6, 0.6, 0.6)
    + text.floor(12, "grey")
    + text.box([-0.5, 0, -0.5], [0.5, 1.2, 0.5], "grey")
)
CUBE = "".join(f"v {i >> 2} {i >> 1 & 1} {i & 1}\n" for i in range(8)) + "".join(
    f"f {face}\n" for face in ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
)
MAP = text.table("environment", kind="map", path="sunny.exr", rotation_y=20)


def write_sky(
    path: Path, radiance: float, lamp: tuple[slice, slice], of_lamp: float, *, rows: int
) -> None:
    """Write an image of an even sky with a lamp in it, twice as wide as it is high."""
    image = np.full((rows, 2 * rows, 3), radiance, np.float32)
    image[lamp] = of_lamp
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": image}) as file:
        file.write(str(path))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder with an image of a sky and its sun, and a scene that it lights."""
    write_sky(tmp_path / "sunny.exr", 0.5, (slice(22, 24), slice(80, 82)), 1500.0, rows=64)
    (tmp_path / "scene.toml").write_text(MAP + BODIES)
    return tmp_path


def suns(scene: Scene) -> list[DirectionalLight]:
    return [light for light in scene.lights if isinstance(light, DirectionalLight)]


def test_its_shadows_are_those_of_paths(folder: Path) -> None:
    def beauty(**fields: object) -> np.ndarray:
        with Renderer(scene, Settings(size=SIZE, **fields)) as renderer:
            return renderer.render(("beauty",)).images["beauty"][..., :3]

    scene = load_scene(folder / "scene.toml")
    paths = beauty(method="reference-gi", spp=256)
    seen = paths.sum(axis=2) > 0.0
    # .02 where rays look for the sun in the image.
    assert relative_mse(beauty(method="gi"), paths, seen) < 2e-3


def test_a_scene_has_it_among_its_lights_and_says_so(folder: Path) -> None:
    scene = load_scene(folder / "scene.toml")
    (sun,) = suns(scene)
    assert sun.name == "sun"
    assert any("sunny.exr shines as a light of its own" in note for note in scene.notes)


def test_the_light_of_an_image_in_place_of_a_models_brings_it(folder: Path) -> None:
    (folder / "bare.obj").write_text(CUBE)
    options = LoadOptions(light=str(folder / "sunny.exr"))
    scene = load_scene(folder / "bare.obj", options)
    assert len(suns(scene)) == 1
    # The image is what is seen behind, and under, a model.
    assert not scene.has_ground and scene.backdrop is None
    assert any("sunny.exr shines as a light of its own" in note for note in scene.notes)


def test_it_turns_with_the_image_of_a_base(folder: Path) -> None:
    (folder / "turned.toml").write_text(
        'base = "scene.toml"\n' + text.table("environment", rotation_y=110)
    )
    (before,), (after,) = (suns(load_scene(folder / f"{n}.toml")) for n in ("scene", "turned"))
    x, y, z = before.direction
    # A quarter turn takes +x to -z.
    np.testing.assert_allclose(after.direction, (z, y, -x), atol=1e-6)


def test_another_image_than_that_of_a_base_brings_its_own(folder: Path) -> None:
    (folder / "dull.toml").write_text(text.constant_sky(1, 1, 1) + BODIES)
    (folder / "lit.toml").write_text('base = "dull.toml"\n' + MAP)
    scene = load_scene(folder / "lit.toml")
    assert isinstance(scene.environment, MapEnvironment)
    assert suns(scene) == suns(load_scene(folder / "scene.toml"))


@pytest.fixture
def studio(tmp_path: Path) -> Scene:
    """Return a box before a wall, under a lamp of an image that is too wide for a light."""
    write_sky(tmp_path / "studio.exr", 0.05, (slice(7, 13), slice(10, 17)), 12.0, rows=32)
    wall = text.box([-3, 0, -1.2], [3, 2, -1], "grey")
    light = text.table("environment", kind="map", path="studio.exr", rotation_y=20)
    (tmp_path / "scene.toml").write_text(light + BODIES + wall)
    scene = load_scene(tmp_path / "scene.toml")
    assert not suns(scene)
    return scene


def beauty(scene: Scene, **fields: object) -> np.ndarray:
    with Renderer(scene, Settings(size=SIZE, **fields)) as renderer:
        return renderer.render(("beauty",)).images["beauty"][..., :3]


def test_a_lamp_too_wide_for_a_light_brings_as_much_as_by_paths(studio: Scene) -> None:
    """Rays are aimed where the image is bright; what few find is as much as others miss."""
    paths = beauty(studio, method="reference-gi", spp=256)
    found = beauty(studio, method="gi")
    # .28 was missing where no pixel's rays brought more than an open sky would.
    assert abs(found.mean() / paths.mean() - 1.0) < 0.02
    other = beauty(studio, method="gi", seed=1)
    noise = np.sqrt(np.square(found - other).mean() / 2.0) / found.mean()
    assert noise < MOST_NOISE


def test_rays_aimed_at_a_lamp_of_an_image_leave_its_light_to_no_other(studio: Scene) -> None:
    """Many rays find as much without them."""
    many = {"far_field.pixel_rays": 64, "far_field.edge_rays": 64}
    aimed, others = (
        beauty(studio, method="gi", overrides={**many, "far_field.aimed_rays": n}) for n in (16, 0)
    )
    assert aimed.mean() == pytest.approx(others.mean(), rel=0.005)


def test_a_lamp_of_an_image_is_as_bright_while_the_camera_moves(studio: Scene) -> None:
    with Renderer(studio, Settings("gi", size=SIZE)) as renderer:
        for step in range(8):
            camera = dataclasses.replace(studio.camera, position=(3.0 + 0.01 * step, 2.2, 4.0))
            moved = renderer.draw(("beauty",), camera=camera).planes["beauty"].read()
        rest = renderer.render(("beauty",), camera=camera).images["beauty"]
    # A sixth was missing where all of the open sky counted alike.
    assert abs(moved[..., :3].mean() / rest[..., :3].mean() - 1.0) < 0.05

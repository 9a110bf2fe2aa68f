"""What gloss reflects of glowing bodies: by points of them and by rays of the lobe, once in all.

Both meet in `rays/glow_in_lobes.glsl` and `rays/glow_that_is_met.glsl`.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scene_text as text
from meshes import showing

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (48, 32)
# Pixel by pixel, what the filter does not blur.
UNFILTERED = {
    "emitters.rays": 32,
    "emitters_filter.filter": "none",
    "reflections_filter.filter": "none",
}
# Noise of 1024 paths and of one frame: relative, of all pixels and of blocks of 4 x 4, which was
# .006 to .028. Of rectangles within the balls the former was .03 to .06, the latter .16 to .44.
OF_ALL, OF_BLOCKS = 0.015, 0.05


def ball(x: float, z: float) -> str:
    return text.ball([x, 0.5, z], 0.2, "glow", segments=8)


def panel(x: float, z: float) -> str:
    return text.quad([x, 0.1, z], [0.7, 0, 0], [0, 0.8, 0], "glow")


def floor(roughness: float, metallic: float, shape: Callable[[float, float], str] = ball) -> Scene:
    """Return a glossy floor that reflects what glows towards the camera."""
    lines = [
        text.camera([0, 1, 2.5], [0, 0, -0.2], 40),
        text.material("floor", 0.6, 0.5, 0.4, roughness=roughness, metallic=metallic),
        text.material("glow", 0, 0, 0, emission=[6, 4, 2]),
        text.floor(5, "floor"),
        *(shape(0.9 * i - 0.4, -0.6 * i) for i in range(2)),
    ]
    return read_description("".join(lines), "floor")


def picture(scene: Scene, **fields: object) -> np.ndarray:
    """Return a picture of `scene` without what glows."""
    with Renderer(scene, Settings(size=SIZE, **fields)) as renderer:
        images = renderer.render(["beauty", "emission"]).images
    glows = images["emission"][..., :3].any(axis=-1, keepdims=True)
    return np.where(glows, 0.0, images["beauty"][..., :3]).astype(np.float64)


def blocks(image: np.ndarray) -> np.ndarray:
    """Return the means of 4 x 4 pixels."""
    return np.asarray(image.reshape(SIZE[1] // 4, 4, SIZE[0] // 4, 4, 3).mean(axis=(1, 3)))


def assert_alike(scene: Scene, points: int, directions: int) -> None:
    """Compare `gi` by so many rays of each kind with paths."""
    rays = {"reflections.glow_rays": points, "reflections.lobe_samples": directions}
    found = picture(scene, method="gi", overrides={**UNFILTERED, **rays})
    exact = picture(scene, method="reference-gi", spp=1024)
    assert found.mean() == pytest.approx(exact.mean(), rel=OF_ALL)
    error = blocks(found) - blocks(exact)
    assert np.sqrt((error**2).mean()) < OF_BLOCKS * np.sqrt((blocks(exact) ** 2).mean())


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize(
    ("roughness", "points", "directions"),
    [(0.1, 32, 64), (0.1, 4, 64), (0.3, 32, 64), (0.6, 32, 64), (0.6, 64, 16), (1.0, 32, 64)],
)
def test_gloss_reflects_balls_as_paths_do(
    roughness: float, metallic: float, points: int, directions: int
) -> None:
    """However many rays there are of each kind: their weights add up to one."""
    assert_alike(floor(roughness, metallic), points, directions)


@pytest.mark.parametrize("roughness", [0.1, 0.5])
def test_gloss_reflects_the_image_of_a_panel(roughness: float) -> None:
    scene = floor(roughness, 1.0, panel)
    pixels = np.zeros((8, 8, 4), np.float32)
    pixels[1:3, 4:7], pixels[..., 3] = 4.0, 1.0
    assert_alike(showing(scene, pixels), 32, 64)


def hall(roughness: float, beam: str = "") -> Scene:
    """Return a glossy floor under seven boxes that glow, more panels than are exact lights."""
    lines = [
        text.camera([0, 1, 4], [0, 0.6, 0], 45),
        text.material("wall", 0.5, 0.5, 0.5),
        text.material("floor", 0.3, 0.3, 0.3, roughness=roughness, specular=1),
        text.material("glow", 0, 0, 0, emission=[9, 8, 7]),
        text.box([-2, -0.1, -5], [2, 0, 4.5], "floor"),
        text.quad([-2, 0, -5], [4, 0, 0], [0, 2.5, 0], "wall"),
        *(text.box([-0.8, 2, z], [0.8, 2.05, z + 0.15], "glow") for z in range(-4, 3)),
        beam,
    ]
    return read_description("".join(lines), "hall")


@pytest.mark.parametrize("roughness", [0.1, 0.2])
def test_lamps_in_a_polished_floor_have_no_grain(roughness):
    scene = hall(roughness)
    found = picture(scene, method="gi", overrides={"reflections_filter.filter": "none"})
    rays = {"reflections.glow_rays": 16, "reflections.lobe_samples": 64}
    many = picture(scene, method="gi", overrides=UNFILTERED | rays)
    floor_of = np.s_[SIZE[1] // 2 :]
    error = np.sqrt(((found - many)[floor_of] ** 2).mean()) / many[floor_of].mean()
    # .012 and .016; .50 and .46 by points and rays alone.
    assert error < 0.05


@pytest.mark.parametrize("roughness", [0.1, 0.3, 0.6])
@pytest.mark.parametrize("beam", ["", text.box([-0.3, 0, -1.6], [0.3, 1.9, -1.5], "wall")])
def test_panels_in_gloss_are_as_bright_as_by_paths(roughness, beam):
    assert_alike(hall(roughness, beam), points=32, directions=64)

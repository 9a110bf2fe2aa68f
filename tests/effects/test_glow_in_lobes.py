"""What gloss reflects of glowing bodies: by points of them and by rays of the lobe, once in all."""

from __future__ import annotations

import numpy as np
import pytest

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
# Noise of 1024 paths and of two frames: relative, of all pixels and of blocks of 4 x 4, which was
# .006 to .028. Of rectangles within the balls the former was .03 to .06, the latter .16 to .44.
OF_ALL, OF_BLOCKS = 0.015, 0.05


def floor(roughness: float, metallic: float) -> Scene:
    """Return a glossy floor that reflects glowing balls and a tent towards the camera."""
    lit = "".join(
        f"""
[[object]]
shape = "sphere"
center = [{0.9 * i - 0.4}, 0.5, {-0.6 * i}]
radius = 0.2
segments = 8
material = "glow"
"""
        for i in range(2)
    )
    text = f"""
[camera]
position = [0, 1, 2.5]
target = [0, 0, -0.2]
fov_y = 40
[materials.floor]
albedo = [0.6, 0.5, 0.4]
roughness = {roughness}
metallic = {metallic}
[materials.glow]
albedo = [0, 0, 0]
emission = [6, 4, 2]
[[object]]
shape = "plane"
point = [0, 0, 0]
normal = [0, 1, 0]
size = 5
material = "floor"
{lit}"""
    return read_description(text, "floor")


def picture(scene: Scene, **fields: object) -> np.ndarray:
    """Return a picture of `scene` without what glows."""
    with Renderer(scene, Settings(size=SIZE, **fields)) as renderer:
        images = renderer.render(["beauty", "emission"]).images
    glows = images["emission"][..., :3].any(axis=-1, keepdims=True)
    return np.where(glows, 0.0, images["beauty"][..., :3]).astype(np.float64)


def blocks(image: np.ndarray) -> np.ndarray:
    """Return the means of 4 x 4 pixels."""
    return np.asarray(image.reshape(SIZE[1] // 4, 4, SIZE[0] // 4, 4, 3).mean(axis=(1, 3)))


@pytest.mark.parametrize("metallic", [0.0, 1.0])
@pytest.mark.parametrize(
    ("roughness", "points", "directions"),
    [(0.1, 32, 64), (0.1, 4, 64), (0.3, 32, 64), (0.6, 32, 64), (0.6, 64, 16), (1.0, 32, 64)],
)
def test_gloss_reflects_balls_as_paths_do(
    roughness: float, metallic: float, points: int, directions: int
) -> None:
    """However many rays there are of each kind: their weights add up to one."""
    scene = floor(roughness, metallic)
    rays = {"reflections.glow_rays": points, "reflections.lobe_samples": directions}
    found = picture(scene, method="gi", spp=2, overrides={**UNFILTERED, **rays})
    exact = picture(scene, method="reference-gi", spp=1024)
    assert found.mean() == pytest.approx(exact.mean(), rel=OF_ALL)
    error = blocks(found) - blocks(exact)
    assert np.sqrt((error**2).mean()) < OF_BLOCKS * np.sqrt((blocks(exact) ** 2).mean())

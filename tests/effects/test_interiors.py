"""Rooms that light reaches by detours: all of it against paths."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings.settings import Settings

INTERIORS = Path(__file__).parent / "interiors"
SIZE = (160, 90)
MEAN_BOUND = 0.05
# With the noise of 256 paths, which is most of it in the cellar.
RELMSE_BOUND = 0.03
# Part of the light of the lit room that may come through a wall of 1/1000 of its width.
LEAK_BOUND = 1e-3


def picture(name: str, method: str, **settings: object) -> np.ndarray:
    image = ssdo_gl.render(INTERIORS / f"{name}.toml", size=SIZE, method=method, **settings)
    return image[..., :3].astype(np.float64)


@pytest.mark.parametrize("name", ["attic", "cellar", "corridor", "door"])
def test_all_of_the_light_of_an_interior(name: str) -> None:
    reference = picture(name, "reference-gi", spp=256)
    found = picture(name, "gi")
    assert found.mean() == pytest.approx(reference.mean(), rel=MEAN_BOUND)
    error = np.mean((found - reference) ** 2 / (reference**2 + 0.01))
    assert error <= RELMSE_BOUND
    near = picture(name, "bounce")
    assert error < np.mean((near - reference) ** 2 / (reference**2 + 0.01))


def test_next_to_nothing_comes_through_a_thin_wall() -> None:
    scene = load_scene(INTERIORS / "wall.toml")
    lit_side = Camera((-1.5, 1.0, 1.8), (-0.4, 0.8, -0.5), fov_y=80.0)
    with Renderer(scene, Settings(method="gi", size=SIZE, radius=0.3)) as renderer:
        dark = renderer.render(("beauty",)).images["beauty"][..., :3].mean()
        lit = renderer.render(("beauty",), camera=lit_side).images["beauty"][..., :3].mean()
    assert lit > 0.1
    assert dark < LEAK_BOUND * lit

"""Where all is grey the bounce has one channel, and nobody can tell from the images."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from properties.planned_and_full import (
    AGREEMENT,
    BLACK,
    BOX,
    GREY,
    QUAD,
    TORUS,
    at,
    compare,
    make_scene,
    turned,
)

from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.environment import ConstantEnvironment, GradientEnvironment, MapEnvironment
from ssdo_gl.scene.light import DirectionalLight, PointLight, RectangleLight
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

LAMP = PointLight((1.5, 3.0, 2.5), (20.0, 20.0, 20.0))
TINTED = dataclasses.replace(LAMP, intensity=(20.0, 20.0, 19.98))
SUN = DirectionalLight((0.3, -0.8, -0.52), (0.7, 0.7, 0.7))
WINDOW = RectangleLight((-1.0, 2.5, -1.0), (2, 0, 0), (0, 0, 2), (3.0, 3.0, 3.0), shadow="ssdo")
FLOOR = (QUAD, at(-2.5, -1.0, 2.5) @ turned(-90.0, 0.0, 0.0) @ np.diag([5.0, 5.0, 1.0, 1.0]))
PLACES = (at(-0.6, -0.5, 0.0), at(0.8, -0.7, 0.2))
COLUMNS = np.random.default_rng(0).uniform(0.0, 4.0, (8, 16, 1)).astype(np.float32)
MAP = MapEnvironment(np.tile(COLUMNS, (1, 1, 3)), rotation_y=20.0)
WHITE_IMAGE = Texture(np.full((4, 4, 4), 255, np.uint8))


def pile(material: Material | None = None, *, shade=1.0) -> Scene:
    """Return two bodies on a floor, the first in `material`, whose vertices are `shade`."""
    shaded = np.linspace(0.2, 0.9, len(BOX.positions))[:, None] * [*np.broadcast_to(shade, 3), 1.0]
    box = dataclasses.replace(BOX, colors=shaded)
    first = material or Material(albedo=GREY)
    return make_scene(
        (*FLOOR, Material(albedo=(0.8, 0.8, 0.8))),
        (box, PLACES[0], first),
        (TORUS, PLACES[1], Material(albedo=BLACK)),
        lights=[LAMP],
        environment=ConstantEnvironment(GREY),
    )


@pytest.fixture
def both(device, shaders):
    """Compare the planned rendering of a scene with the full one; return the planned one."""

    def run(scene, **more):
        scene_parts = {f.name for f in dataclasses.fields(Scene)}
        parts = {key: more.pop(key) for key in tuple(more) if key in scene_parts}
        found = compare(device, shaders, dataclasses.replace(scene, **parts), **more)
        assert found.images["bounce"].max() > 1e-4, "there must be something to compare"
        return found

    return run


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"estimator": "rgs09"},
        {"resolution_scale": 0.5},
        {"filter": "none"},
        {"filter": "naive", "resolution_scale": 0.5},
        {"samples": 128, "steps": 4},  # too many directions to be shared
        {"shadows": "traced"},
    ],
    ids=str,
)
def test_under_every_setting(both, settings):
    assert both(pile(), **settings).effects.grey_bounce


GREY_SCENES = {
    "several lights": {"lights": (LAMP, SUN, WINDOW)},
    "no environment": {"environment": None},
    "gradient": {"environment": GradientEnvironment(GREY, (0.9, 0.9, 0.9), BLACK)},
    "map": {"environment": MAP},
    "a coloured light that is off": {
        "lights": (LAMP, dataclasses.replace(LAMP, intensity=BLACK)),
    },
}


@pytest.mark.parametrize("name", GREY_SCENES)
def test_grey_light_of_every_kind(both, name):
    found = both(pile(), **GREY_SCENES[name])
    assert found.effects.grey_bounce
    image = found.images["bounce"]
    assert np.array_equal(image[..., 0], image[..., 1])
    assert np.array_equal(image[..., 0], image[..., 2])


def test_grey_emission_that_no_light_stands_for(both):
    lit = pile(Material(albedo=GREY, emission=(2.0, 2.0, 2.0)))
    assert both(lit, lights=(), environment=None).effects.grey_bounce


TINTED_MAP = np.tile(COLUMNS, (1, 1, 3))
TINTED_MAP[-1, -1, 1] *= 1.001
ALMOST_GREY = {
    "an albedo a thousandth off": pile(Material(albedo=(0.5, 0.5, 0.5005))),
    "a textured material": pile(Material(albedo=GREY, albedo_texture=WHITE_IMAGE)),
    "tinted vertices": pile(shade=(1.0, 0.999, 1.0)),
    "tinted emission": pile(Material(emission=(0.5, 0.5, 0.5005))),
    "a tinted light": dataclasses.replace(pile(), lights=(LAMP, TINTED)),
    "a tinted window": dataclasses.replace(
        pile(), lights=(dataclasses.replace(WINDOW, radiance=(3.0, 2.997, 3.0)),)
    ),
    "a tinted sky": dataclasses.replace(pile(), environment=ConstantEnvironment((0.5, 0.5, 0.499))),
    "a tinted ground": dataclasses.replace(
        pile(), environment=GradientEnvironment(GREY, GREY, (0.1, 0.1, 0.101))
    ),
    "one tinted texel": dataclasses.replace(pile(), environment=MapEnvironment(TINTED_MAP)),
}


@pytest.mark.parametrize("name", ALMOST_GREY)
def test_what_is_almost_grey_keeps_its_colours(both, name):
    assert not both(ALMOST_GREY[name]).effects.grey_bounce


def test_a_light_that_is_tinted_while_the_program_runs(device, shaders):
    """And turned grey again: each frame is that of a fresh start."""
    grey, tinted = pile(), dataclasses.replace(pile(), lights=(TINTED,))
    wanted = ("beauty", "bounce")
    chosen = Settings(size=(48, 32), radius=0.5, samples=32, steps=4)
    with Renderer(grey, chosen, device=device, shaders=shaders) as renderer:
        for scene in (grey, tinted, grey):
            renderer.use_scene(scene)
            found = renderer.render(wanted).images
            with Renderer(scene, chosen, device=device, shaders=shaders) as fresh:
                for name, image in fresh.render(wanted).images.items():
                    assert np.array_equal(found[name], image), name
        with Renderer(
            grey, dataclasses.replace(chosen, effects="full"), device=device, shaders=shaders
        ) as full:
            image = full.render(wanted).images["bounce"]
        assert np.abs(image - found["bounce"]).max() <= AGREEMENT * max(1.0, image.max())


def test_references_keep_their_colours(device, shaders):
    settings = Settings(size=(16, 12), radius=0.5, method="reference-near", spp=1)
    with Renderer(pile(), settings, device=device, shaders=shaders) as renderer:
        assert renderer.render(("bounce",)).images["bounce"].shape == (12, 16, 3)
        assert not renderer._planned.effects.grey_bounce

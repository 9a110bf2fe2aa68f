"""Reflections of reflections: mirrors that face each other, and rooms of metal."""

from __future__ import annotations

import numpy as np
import pytest
from effects.glossy_floor import SIZE, picture
from scene_text import ball, box, camera, constant_sky, lamp, light, material, quad, table

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description


def facing_mirrors(ball_of: str, roughness: float = 0.05) -> str:
    return (
        material("mirror", 0.95, 0.9, 0.8, metallic=1, roughness=roughness)
        + material("matt", 0.7, 0.1, 0.1)
        + quad([-1.4, 0, 2], [0, 0, -3], [0, 1.8, 0], "mirror")
        + quad([1.3, 0, -1.2], [-2.4, 0, -0.4], [0, 1.8, 0], "mirror")
        + ball([0.4, 0.4, 0.2], 0.4, ball_of)
    )


POINT = light("point", position=[0.3, 2, 2], intensity=[6, 6, 6])
LAMPS = [
    lamp([-0.5, 2.2, 0], [1, 0, 0], [0, 0, 1], [3, 3, 3], visible=visible)
    for visible in (True, False)
]


def room_of_rough_metal(roughness: float) -> str:
    return (
        camera([0, 1, 1.9], [0, 0.8, 0], 50)
        + table("render", radius=0.2)
        + material("wall", 0.8, 0.6, 0.4)
        + material("metal", 0.9, 0.9, 0.9, metallic=1, roughness=roughness)
        + box([-2, 0, -2], [2, 2.5, 2], "wall")
        + ball([0, 0.8, 0], 0.5, "metal")
        + lamp([-0.3, 2.45, -0.3], [0.6, 0, 0], [0, 0, 0.6], [9, 9, 9])
    )


@pytest.mark.parametrize("roughness", [0.41, 0.7, 1.0])
def test_rough_metal_in_a_room_shows_its_walls_beyond_the_near_field(roughness):
    """What lies beyond R is not black: rays of the lobe find it."""
    scene = read_description(room_of_rough_metal(roughness), "room.toml")
    found, wanted = (
        np.asarray(ssdo_gl.render(scene, size=SIZE, **chosen), np.float64)[12:-12, 20:-20, :3]
        for chosen in ({"method": "gi"}, {"method": "reference-gi", "spp": 128})
    )
    # The lower half, which no lamp lights directly. Noise of the paths is 1 %.
    found, wanted = (image[12:].mean(axis=(0, 1)) for image in (found, wanted))
    np.testing.assert_allclose(found, wanted, rtol=0.04)


def shown(picture_):
    return np.clip(picture_[..., :3], 0.0, 1.0)


@pytest.mark.parametrize("ball_of", ["matt", "mirror"])
def test_a_mirror_in_a_mirror_shows_what_it_reflects(ball_of):
    # Nothing is clipped.
    scene = constant_sky(0.4, 0.6, 0.9) + facing_mirrors(ball_of)
    wanted = shown(picture(scene, method="reference-gi", spp=64))
    errors = {
        bounces: np.sqrt(np.mean((shown(picture(scene, method="gi", **once)) - wanted) ** 2))
        for bounces, once in ((0, {"overrides": {"reflections.mirror_bounces": 0}}), (3, {}))
    }
    # Along edges, where four directions stand for 64 paths: 0.004 and 0.002.
    assert errors[3] < 0.01
    assert errors[3] < 0.5 * errors[0], errors


@pytest.mark.parametrize("shining", [POINT, *LAMPS])
def test_a_light_in_a_mirror_in_a_mirror_is_as_bright_as_by_rays(shining):
    """Rough enough for paths to find the light; nothing else shines."""
    scene = shining + facing_mirrors("mirror", roughness=0.35)
    found, wanted = (
        picture(scene, method=method, spp=spp)[..., :3].mean(axis=(0, 1))
        for method, spp in (("gi", 1), ("reference-gi", 64))
    )
    direct = picture(scene, method="direct", shadows="traced")[..., :3].mean(axis=(0, 1))
    # What the first mirror shows of the light itself is exact. The rest comes out as 1.03, 0.90
    # and 1.03 of it by four directions a pixel, and as 0.01 to 0.04 without the second mirror's.
    np.testing.assert_allclose(found - direct, wanted - direct, rtol=0.2)


METAL_ROOM = (
    camera([0, 1, 2.9], [0, 1, 0], 45)
    + material("wall", 0.7, 0.6, 0.5, metallic=1, roughness=0.25)
    + box([-1, 0, -1], [1, 2, 3], "wall")
    + lamp([-0.25, 1.98, -0.25], [0.5, 0, 0], [0, 0, 0.5], [10, 10, 10])
)


def test_a_lamp_in_a_room_of_metal_leaves_no_blotches():
    scene = read_description(METAL_ROOM, "scene.toml")

    def drawn(**settings):
        return np.asarray(ssdo_gl.render(scene, size=SIZE, method="gi", **settings), np.float64)

    many = drawn(overrides={"reflections.lobe_samples": 64})
    for seed in (0, 1):
        found = drawn(seed=seed)
        # 0.010; 0.026 where only rays of the lobe find the lamp in the second wall.
        assert np.sqrt(np.mean((shown(found) - shown(many)) ** 2)) < 0.016
        assert abs(found.mean() / many.mean() - 1.0) < 0.03


UNFILTERED = {"reflections_filter.filter": "none"}
MANY = {"reflections.lobe_samples": 64}
GOLD_AND_CHROME = (
    material("wall", 0.6, 0.58, 0.55)
    + material("gold", 1, 0.77, 0.34, metallic=1, roughness=0.25)
    + material("chrome", 0.95, 0.95, 0.95, metallic=1, roughness=0.02)
    + box([-2, 0, -2], [2, 2.5, 3], "wall")
)


def test_a_lamp_in_a_mirror_leaves_no_specks_in_a_rougher_one():
    """Few rays of a wide lobe come upon a small lamp in the mirror behind the camera."""
    text = (
        camera([0, 1, 1], [0, 0.9, -1], 60)
        + GOLD_AND_CHROME
        + quad([-1.5, 0.1, -1.9], [3, 0, 0], [0, 2, 0], "gold")
        + quad([1.5, 0.1, 2.9], [-3, 0, 0], [0, 2, 0], "chrome")
        + lamp([-0.1, 2.4, -0.6], [0.2, 0, 0], [0, 0, 0.2], [150, 150, 150])
    )
    scene = read_description(text, "scene.toml")

    def drawn(seed, **overrides):
        return np.asarray(
            ssdo_gl.render(scene, size=SIZE, method="gi", seed=seed, overrides=overrides)
        )

    many = drawn(0, **UNFILTERED, **MANY)
    found = np.stack([drawn(seed, **UNFILTERED) for seed in range(3)])
    # .036; .545 where the mirror stays as smooth as it is, .060 of the best seed.
    assert np.sqrt(np.mean((found - many)[..., :3] ** 2)) < 0.05
    assert abs(found.mean() / many.mean() - 1.0) < 0.01


def test_images_in_curved_metal_are_not_blurred():
    text = (
        camera([0, 1, 2.8], [0, 0.6, 0], 45)
        + GOLD_AND_CHROME
        + quad([-1.5, 0.6, -1.9], [3, 0, 0], [0, 1.5, 0], "chrome")
        + "".join(ball([x, 0.5, 0], 0.4, "gold") for x in (-1, 0, 1))
        + lamp([-0.4, 2.48, -0.6], [0.8, 0, 0], [0, 0, 0.6], [14, 14, 14])
    )
    scene = read_description(text, "scene.toml")
    # Of so many directions a pixel that there is no noise to filter.
    sharp, found = (
        shown(np.asarray(ssdo_gl.render(scene, size=SIZE, method="gi", overrides=overrides)))
        for overrides in (UNFILTERED | MANY, MANY)
    )
    # .005; .019 where filtered as in a plane.
    assert np.sqrt(np.mean((found - sharp) ** 2)) < 0.01

"""Reflections of reflections: mirrors that face each other, and rooms of metal."""

from __future__ import annotations

import numpy as np
import pytest
from effects.glossy_floor import SIZE, picture

import ssdo_gl
from ssdo_gl.scene.formats.toml import read_description

FACING_MIRRORS = """
[materials.mirror]
albedo = [0.95, 0.9, 0.8]
metallic = 1
roughness = 0.05
[materials.matt]
albedo = [0.7, 0.1, 0.1]
[[object]]
shape = "quad"
corner = [-1.4, 0, 2]
edge_u = [0, 0, -3]
edge_v = [0, 1.8, 0]
material = "mirror"
[[object]]
shape = "quad"
corner = [1.3, 0, -1.2]
edge_u = [-2.4, 0, -0.4]
edge_v = [0, 1.8, 0]
material = "mirror"
[[object]]
shape = "sphere"
center = [0.4, 0.4, 0.2]
radius = 0.4
material = "BALL"
"""


POINT = '[[light]]\nkind = "point"\nposition = [0.3, 2, 2]\nintensity = [6, 6, 6]\n'


LAMP = """
[[light]]
kind = "area"
corner = [-0.5, 2.2, 0]
edge_u = [1, 0, 0]
edge_v = [0, 0, 1]
radiance = [3, 3, 3]
visible = VISIBLE
"""


ROOM_OF_ROUGH_METAL = """
[camera]
position = [0, 1, 1.9]
target = [0, 0.8, 0]
fov_y = 50
[render]
radius = 0.2
[materials.wall]
albedo = [0.8, 0.6, 0.4]
[materials.metal]
albedo = [0.9, 0.9, 0.9]
metallic = 1
roughness = {roughness}
[[object]]
shape = "box"
min = [-2, 0, -2]
max = [2, 2.5, 2]
material = "wall"
[[object]]
shape = "sphere"
center = [0, 0.8, 0]
radius = 0.5
material = "metal"
[[light]]
kind = "area"
corner = [-0.3, 2.45, -0.3]
edge_u = [0.6, 0, 0]
edge_v = [0, 0, 0.6]
radiance = [9, 9, 9]
"""


@pytest.mark.parametrize("roughness", [0.41, 0.7, 1.0])
def test_rough_metal_in_a_room_shows_its_walls_beyond_the_near_field(roughness):
    """What lies beyond R is not black: rays of the lobe find it."""
    scene = read_description(ROOM_OF_ROUGH_METAL.format(roughness=roughness), "room.toml")
    found, wanted = (
        np.asarray(ssdo_gl.render(scene, size=SIZE, **chosen), np.float64)[12:-12, 20:-20, :3]
        for chosen in ({"method": "gi"}, {"method": "reference-gi", "spp": 128})
    )
    # The lower half, which no lamp lights directly. Noise of the paths is 1 %.
    found, wanted = (image[12:].mean(axis=(0, 1)) for image in (found, wanted))
    np.testing.assert_allclose(found, wanted, rtol=0.04)


def shown(picture_):
    return np.clip(picture_[..., :3], 0.0, 1.0)


@pytest.mark.parametrize("ball", ["matt", "mirror"])
def test_a_mirror_in_a_mirror_shows_what_it_reflects(ball):
    # Nothing is clipped.
    sky = '[environment]\nkind = "constant"\nradiance = [0.4, 0.6, 0.9]\n'
    scene = sky + FACING_MIRRORS.replace("BALL", ball)
    wanted = shown(picture(scene, method="reference-gi", spp=64))
    errors = {
        bounces: np.sqrt(np.mean((shown(picture(scene, method="gi", **once)) - wanted) ** 2))
        for bounces, once in ((0, {"overrides": {"reflections.mirror_bounces": 0}}), (3, {}))
    }
    # Along edges, where four directions stand for 64 paths: 0.004 and 0.002.
    assert errors[3] < 0.01
    assert errors[3] < 0.5 * errors[0], errors


@pytest.mark.parametrize(
    "light", [POINT, LAMP.replace("VISIBLE", "true"), LAMP.replace("VISIBLE", "false")]
)
def test_a_light_in_a_mirror_in_a_mirror_is_as_bright_as_by_rays(light):
    """Rough enough for paths to find the light; nothing else shines."""
    scene = light + FACING_MIRRORS.replace("BALL", "mirror").replace("0.05", "0.35")
    found, wanted = (
        picture(scene, method=method, spp=spp)[..., :3].mean(axis=(0, 1))
        for method, spp in (("gi", 1), ("reference-gi", 64))
    )
    direct = picture(scene, method="direct", shadows="traced")[..., :3].mean(axis=(0, 1))
    # What the first mirror shows of the light itself is exact. The rest comes out as 1.03, 0.90
    # and 1.03 of it by four directions a pixel, and as 0.01 to 0.04 without the second mirror's.
    np.testing.assert_allclose(found - direct, wanted - direct, rtol=0.2)


METAL_ROOM = """
[camera]
position = [0, 1, 2.9]
target = [0, 1, 0]
fov_y = 45
[materials.wall]
albedo = [0.7, 0.6, 0.5]
metallic = 1
roughness = 0.25
[[object]]
shape = "box"
min = [-1, 0, -1]
max = [1, 2, 3]
material = "wall"
[[light]]
kind = "area"
corner = [-0.25, 1.98, -0.25]
edge_u = [0.5, 0, 0]
edge_v = [0, 0, 0.5]
radiance = [10, 10, 10]
"""


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

"""Translucent surfaces: alpha is the share of what is drawn, on average over frames."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from glb_writer import GlbWriter
from scene_text import camera, light, material, quad

import ssdo_gl
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.geometry import batching
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

SIZE = (48, 32)
FRAMES = 64
# Each of n frames takes another n-th of the thresholds: a pixel's share is off by at most
# 1 / FRAMES, and neighbours' errors differ.
TOLERANCE = 0.02
HEAD = camera([0, 0, 3], [0, 0, 0], 40, exposure=0)


def sheet(name, emission, z, alpha=1.0, blend=True):
    made_of = material(name, 0, 0, 0, emission=emission, alpha=alpha, blend=blend)
    return made_of + quad([-3, -3, z], [6, 0, 0], [0, 6, 0], name)


def picture(text, **settings):
    scene = read_description(HEAD + text, "scene.toml")
    options = {"method": "direct", "antialias": FRAMES, **settings}
    return np.asarray(ssdo_gl.render(scene, size=SIZE, **options), np.float64)[..., :3]


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("method", ["direct", "reference-gi"])
def test_alpha_mixes_what_is_in_front_and_behind(alpha, method):
    text = sheet("front", (1, 0, 0), 0.0, alpha) + sheet("back", (0, 0, 1), -1.0)
    # Black sheets show no light, and maps of them in each frame take most of the time.
    found = picture(text, method=method, spp=2, shadows="none").mean(axis=(0, 1))
    np.testing.assert_allclose(found, [alpha, 0.0, 1.0 - alpha], atol=TOLERANCE)


@pytest.mark.parametrize("frames", [4, 10, 16])
@pytest.mark.parametrize("alpha", [0.3, 0.85])
def test_no_frame_takes_the_thresholds_of_another(alpha, frames):
    # Turned from the camera, so that its depth differs between pixels, and between frames.
    pane = sheet("front", (1, 0, 0), 0.0, alpha).replace("[6, 0, 0]", "[6, 0, -4]")
    found = picture(pane + sheet("back", (0, 0, 1), -6.0), antialias=frames)[..., 0]
    middle = found[8:-8, 8:-8]
    # All but those where the pane's two triangles meet.
    assert np.mean(np.abs(middle - alpha) < 1.0 / frames) > 0.95


def test_opacity_is_alpha_that_blends():
    def read(keys):
        text = HEAD + sheet("front", (1, 0, 0), 0.0, blend=None).replace("alpha = 1.0", keys)
        return read_description(text, "scene.toml").materials[0]

    assert (read("opacity = 0.25").alpha, read("opacity = 0.25").is_translucent) == (0.25, True)
    assert not read("opacity = 1").blends
    assert not read("opacity = 0.25\nblend = false").blends
    with pytest.raises(SceneError, match=r"opacity: stands for alpha and blend"):
        read("opacity = 0.25\nalpha = 0.5")


def test_layers_over_each_other_mix_as_independent_ones():
    layers = [sheet("near", (1, 0, 0), 0.5, 0.5), sheet("middle", (0, 1, 0), 0.0, 0.5)]
    text = "".join(layers) + sheet("back", (0, 0, 1), -1.0)
    for order in (text, "".join(reversed(layers)) + sheet("back", (0, 0, 1), -1.0)):
        found = picture(order, shadows="none").mean(axis=(0, 1))
        np.testing.assert_allclose(found, [0.5, 0.25, 0.25], atol=0.06)


def test_half_a_shadow_falls_behind_half_a_pane():
    lit = material("wall", 1, 1, 1) + quad([-3, -3, -1], [6, 0, 0], [0, 6, 0], "wall")
    lit += light("directional", direction=[0, -0.5, -1], irradiance=[3, 3, 3])

    def pane(blends):
        made_of = material("pane", 0, 0, 0, alpha=0.5, blend=blends)
        return made_of + quad([-6, 0, 0.5], [12, 0, 0], [0, 6, 0], "pane")

    # Below the pane, where its shadow falls on the wall.
    rows = slice(SIZE[1] // 2 + 2, SIZE[1] // 2 + 6)
    without = picture(lit)[rows].mean()
    for shadows in ("map", "traced"):
        half = picture(lit + pane(blends=True), shadows=shadows)[rows].mean()
        whole = picture(lit + pane(blends=False), shadows=shadows)[rows].mean()
        assert whole < 0.05 * without
        assert half == pytest.approx(0.5 * without, rel=0.1)


@pytest.mark.parametrize("alpha", [0.1, 0.9])
@pytest.mark.parametrize("kind", ["sun", "lamp"])
def test_as_much_light_passes_a_pane_by_all_methods(alpha, kind):
    """With `gi` rays took the place of texels that disagree, by chance: .93 and .06 passed."""
    lit = {
        "sun": light("directional", irradiance=[3, 3, 3], direction=[0, -1, 0.001]),
        "lamp": light("point", intensity=[300, 300, 300], position=[0, 10, 0]),
    }[kind]
    floor = material("floor", 0.5, 0.5, 0.5) + quad([-4, 0, 4], [8, 0, 0], [0, 0, -8], "floor")
    scene = camera([0, 2, 0.4], [0, 0, 0], 40) + lit + floor
    pane = material("pane", 0, 0, 0, alpha=alpha, blend=True)
    pane += quad([-2, 3, 2], [4, 0, 0], [0, 0, -4], "pane")
    for method in ("bounce", "gi"):
        below, without = (
            ssdo_gl.render(
                read_description(text, "scene.toml"),
                aov="direct",
                size=SIZE,
                method=method,
                antialias=16,
            )
            for text in (scene + pane, scene)
        )
        passes = below.mean() / without.mean()
        assert passes == pytest.approx(1.0 - alpha, abs=TOLERANCE)


def test_what_is_opaque_throughout_is_not_drawn_by_chance():
    text = sheet("front", (1, 0, 0), 0.0, 1.0)
    assert np.array_equal(picture(text, antialias=1, seed=1), picture(text, antialias=1, seed=2))


def glowing_square(glb, **attributes):
    """Return a primitive of one red square two units wide that lets half of it through."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], "<f4")
    triangles = np.array([0, 1, 2, 0, 2, 3], "<u2")
    return {
        "attributes": {"POSITION": glb.accessor(corners, "VEC3"), **attributes},
        "indices": glb.accessor(triangles, "SCALAR"),
        "material": 0,
    }


def red_share(glb, folder, method):
    """Return the mean of a picture of the glowing squares of the file alone."""
    scene = load_scene(glb.save(folder / "a.glb"), light="file")
    scene = dataclasses.replace(scene, camera=Camera((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)))
    image = ssdo_gl.render(scene, size=SIZE, method=method, antialias=FRAMES, spp=2)
    return np.asarray(image, np.float64)[..., :3].mean(axis=(0, 1))


def glowing(alpha):
    return {
        "alphaMode": "BLEND",
        "emissiveFactor": [1, 0, 0],
        "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, alpha]},
    }


@pytest.mark.parametrize("method", ["direct", "reference-gi"])
def test_colours_of_vertices_let_light_through(method, tmp_path):
    glb = GlbWriter()
    half = np.tile(np.array([1, 1, 1, 0.5], "<f4"), (4, 1))
    glb.json["materials"] = [glowing(1.0)]
    glb.json["meshes"] = [{"primitives": [glowing_square(glb, COLOR_0=glb.accessor(half, "VEC4"))]}]
    np.testing.assert_allclose(red_share(glb, tmp_path, method), [0.5, 0, 0], atol=TOLERANCE)


def test_panes_stay_translucent_when_joined(tmp_path, monkeypatch):
    monkeypatch.setattr(batching, "MIN_OBJECTS", 2)
    glb = GlbWriter()
    glb.json["materials"] = [glowing(0.5) | {"emissiveFactor": [0, 0, 0]}]
    glb.json["meshes"] = [{"primitives": [glowing_square(glb)]} for _ in range(2)]
    glb.json["nodes"] = [{"mesh": 0}, {"mesh": 1, "translation": [0, 0, 9]}]
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    scene = load_scene(glb.save(tmp_path / "a.glb"))
    (item,) = scene.objects
    assert (item.name, scene.materials[item.material].alpha) == ("joined", 1.0)
    assert scene.materials[item.material].is_translucent

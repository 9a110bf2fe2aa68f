"""What the G-buffer takes from materials: textures, cut-outs, colours, emission."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.gbuffer_harness import NORMAL_TOLERANCE, draw, normals, rays_of
from passes.pass_harness import make_scene, quad

from ssdo_gl import math3d
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material, Texture


@pytest.fixture
def shaders(shaders_either_way):
    """What has holes is rasterized either way."""
    return shaders_either_way


def test_what_hides_a_lamp_hides_its_emission(gl, shaders):
    """Emission is written by lamps alone, whichever of a lamp and a card is nearer."""
    card = quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    materials = Material(), Material(emission=(4.0, 5.0, 6.0)), Material(is_unlit=True)
    colour = materials[2].albedo
    # Horizontal place, material, depth and what is put out there.
    cards = [
        (-2.0, 0, 4.0, (0, 0, 0)),
        (-2.0, 1, 5.0, (4, 5, 6)),
        (0.0, 1, 6.0, (4, 5, 6)),
        (0.6, 0, 7.0, (0, 0, 0)),
        (1.4, 2, 3.0, colour),
        (1.6, 0, 4.5, (0, 0, 0)),
    ]
    objects = [
        SceneObject(0, material, math3d.translation([x, 0.0, -z])[None])
        for x, material, z, _ in cards
    ]
    _, images = draw(gl, shaders, make_scene([card], materials=materials, objects=objects))
    z = images["z_vs"][..., 0]
    for *_, depth, emission in cards:
        shown = np.abs(z - depth) < 1e-5
        assert np.count_nonzero(shown) > 3
        found = images["emission"][shown][:, :3]
        np.testing.assert_allclose(found - np.array(emission), 0.0, atol=1e-7)
    assert not np.any(images["emission"][z == 0.0])


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("two_sided", [False, True])
def test_surfaces_face_the_camera_but_emit_from_the_front(gl, shaders, mirrored, two_sided):
    """A quad seen from its front at x < 0 and from its back at x > 0.

    Mirroring an instance leaves the outside of the mesh its front.
    """
    front = quad((-1.0, -0.5, -3.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    back = quad((1.0, -0.5, -3.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    slanted = np.array([0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
    meshes = [
        dataclasses.replace(front, normals=np.tile(slanted, (4, 1))),
        dataclasses.replace(back, normals=np.tile(-slanted, (4, 1))),
    ]
    place = np.diag([1.0, -1.0, 1.0, 1.0]) if mirrored else np.eye(4)
    scene = make_scene(
        meshes,
        materials=[Material(emission=(2.0, 3.0, 4.0), two_sided_emission=two_sided)],
        objects=[SceneObject(i, 0, place[None]) for i in range(2)],
    )
    frame, images = draw(gl, shaders, scene)
    seen = images["z_vs"][..., 0] > 0.0
    left = rays_of(frame)[..., 0] < 0.0
    shading, geometric = normals(images)
    np.testing.assert_allclose(
        geometric[seen], np.tile([0.0, 0.0, 1.0], (seen.sum(), 1)), atol=2e-7
    )
    np.testing.assert_allclose(
        shading[seen], np.tile(slanted, (seen.sum(), 1)), atol=NORMAL_TOLERANCE
    )
    emission = images["emission"][..., :3]
    assert np.all(emission[seen & left] == (2.0, 3.0, 4.0))
    assert np.all(emission[seen & ~left] == ((2.0, 3.0, 4.0) if two_sided else (0.0, 0.0, 0.0)))


def test_only_emission_without_a_light_counts_as_a_sender(gl, shaders):
    card = quad((-0.5, -0.5, -3.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    for light, alpha in ((None, 1.0), (0, 0.0)):
        scene = make_scene(
            [card],
            materials=[Material(emission=(2.0, 2.0, 2.0))],
            objects=[SceneObject(0, 0, light=light)],
        )
        _, images = draw(gl, shaders, scene)
        seen = images["z_vs"][..., 0] > 0.0
        assert np.all(images["emission"][seen] == (2.0, 2.0, 2.0, alpha))


def textured_card(**material):
    """A 2 x 2 card that faces the camera at distance 4, with v = 0 at its top."""
    card = quad((-1.0, -1.0, -4.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    card = dataclasses.replace(card, uvs=np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float64))
    return make_scene([card], materials=[Material(albedo=(1, 1, 1), **material)])


def quadrant_means(images, name, channel):
    """Means over the interior of the card's quadrants: top left, top right, bottom ..."""
    seen = images["z_vs"][..., 0] > 0.0
    rows, columns = np.flatnonzero(seen.any(1)), np.flatnonzero(seen.any(0))
    card = images[name][rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1, channel]
    h, w = card.shape[0] // 2, card.shape[1] // 2
    # Off the borders, where the linear filter mixes texels.
    return [
        [
            card[i * h + h // 3 : i * h + 2 * h // 3, j * w + w // 3 : j * w + 2 * w // 3].mean()
            for j in range(2)
        ]
        for i in range(2)
    ]


def test_textures_are_upright_and_linear(gl, shaders):
    """8-bit texels are sRGB-encoded, float texels linear; row 0 is the top."""
    code = np.zeros((64, 64, 4), np.uint8)
    code[:32, :32], code[:32, 32:] = (0, 10, 10, 255), (128, 10, 10, 255)
    code[32:, :32], code[32:, 32:] = (255, 10, 10, 255), (188, 10, 10, 255)
    scene = textured_card(albedo_texture=Texture(code))
    _, images = draw(gl, shaders, scene, (96, 72))

    def decode(c):
        return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4

    wanted = [[0.0, decode(128 / 255)], [1.0, decode(188 / 255)]]
    # Drivers decode sRGB with a table of about 8 bits of linear precision.
    np.testing.assert_allclose(quadrant_means(images, "albedo", 0), wanted, atol=2e-3)
    linear = code.astype(np.float32) / 255.0
    scene = textured_card(
        emission=(10.0, 0.0, 0.0),
        emission_texture=Texture(linear),
        albedo_texture=Texture(linear),
    )
    _, images = draw(gl, shaders, scene, (96, 72))
    wanted = np.array([[0.0, 128.0], [255.0, 188.0]]) / 255.0
    np.testing.assert_allclose(quadrant_means(images, "albedo", 0), wanted, atol=1e-4)
    np.testing.assert_allclose(quadrant_means(images, "emission", 0), 10.0 * wanted, atol=1e-3)


@pytest.mark.parametrize("wrap", ["repeat", "clamp"])
def test_texture_wrap(gl, shaders, wrap):
    pixels = np.ones((2, 64, 4), np.float32)
    pixels[:, 32:, 0] = 0.25
    scene = textured_card(albedo_texture=Texture(pixels, wrap=(wrap, "repeat")))
    mesh = scene.meshes[0]
    shifted = dataclasses.replace(mesh, uvs=np.add(mesh.uvs, (1.0, 0.0)))
    scene = dataclasses.replace(scene, meshes=(shifted,))
    _, images = draw(gl, shaders, scene, (96, 72))
    wanted = [[1.0, 0.25]] * 2 if wrap == "repeat" else [[0.25, 0.25]] * 2
    np.testing.assert_allclose(quadrant_means(images, "albedo", 0), wanted, atol=1e-4)


def test_distant_textures_are_filtered(gl, shaders):
    """A checkerboard of single texels, a hundredth of a pixel each, shows as its mean."""
    checker = np.ones((512, 512, 4), np.float32)
    checker[..., :3] = (np.indices((512, 512)).sum(0) % 2)[..., None]
    scene = textured_card(albedo_texture=Texture(checker))
    _, images = draw(gl, shaders, scene, (32, 24))
    seen = images["z_vs"][..., 0] > 0.0
    np.testing.assert_allclose(images["albedo"][seen][:, :3], 0.5, atol=1e-3)


@pytest.mark.parametrize("source", ["texture", "vertices", "factor"])
def test_cut_outs_let_the_background_through(gl, shaders, source):
    pixels = np.ones((64, 64, 4), np.float32)
    pixels[:, :32, 3] = 0.3
    material = Material(alpha_cutoff=0.5)
    mesh = textured_card().meshes[0]
    if source == "texture":
        material = dataclasses.replace(material, albedo_texture=Texture(pixels))
    elif source == "vertices":
        mesh = dataclasses.replace(
            mesh, colors=np.array([[1, 1, 1, a] for a in (0, 1, 1, 0)], float)
        )
    else:
        material = dataclasses.replace(material, alpha=0.3)
    frame, images = draw(gl, shaders, make_scene([mesh], materials=[material]), (96, 72))
    x = rays_of(frame)[..., 0] * 4.0
    y = rays_of(frame)[..., 1] * 4.0
    # The filter's texel and a half around the border may go either way.
    inside = (np.abs(x) < 0.95) & (np.abs(y) < 0.95) & (np.abs(x) > 0.06)
    seen = images["z_vs"][..., 0] > 0.0
    wanted = (x > 0.0) if source != "factor" else np.zeros_like(seen)
    np.testing.assert_array_equal(seen[inside], wanted[inside])


def test_vertex_colours_multiply_and_interpolate(gl, shaders):
    mesh = textured_card().meshes[0]
    colors = np.array([[0, 0, 1, 1], [1, 0, 1, 1], [1, 1, 1, 1], [0, 1, 1, 1]], np.float64)
    scene = make_scene(
        [dataclasses.replace(mesh, colors=colors)], materials=[Material(albedo=(0.8, 0.6, 0.5))]
    )
    frame, images = draw(gl, shaders, scene)
    seen = images["z_vs"][..., 0] > 0.0
    place = rays_of(frame)[..., :2] * 4.0 * 0.5 + 0.5
    np.testing.assert_allclose(images["albedo"][seen][:, 0], 0.8 * place[seen][:, 0], atol=1e-4)
    np.testing.assert_allclose(images["albedo"][seen][:, 1], 0.6 * place[seen][:, 1], atol=1e-4)
    np.testing.assert_allclose(images["albedo"][seen][:, 2], 0.5, atol=1e-4)

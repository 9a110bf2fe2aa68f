"""Tables of surfaces: what the corners carry, materials, and the atlas of textures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.packed import oct_words
from ssdo_gl.raytracing.surface_tables import (
    LIGHT_BODY_FLAG,
    SMOOTH_FLAG,
    RayFeatures,
    build_atlas,
    material_table,
    material_words,
    surface_table,
)
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, sphere
from ssdo_gl.scene.lights import RectangleLight
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
# 16 bits for a component: 1 / 32767 on the octahedron, some 4e-5 of a direction.
NORMAL_TOLERANCE = 6e-5


def scene_of(mesh: Mesh, material: Material | None = None, **more) -> Scene:
    return Scene((mesh,), (material or Material(),), (SceneObject(0, 0, **more),), CAMERA)


def decode_oct(words: np.ndarray) -> np.ndarray:
    u, v = (words & 0xFFFF) / 32767.0 - 1.0, (words >> 16) / 32767.0 - 1.0
    z = 1.0 - np.abs(u) - np.abs(v)
    x = np.where(z < 0.0, (1.0 - np.abs(v)) * np.where(u < 0.0, -1.0, 1.0), u)
    y = np.where(z < 0.0, (1.0 - np.abs(u)) * np.where(v < 0.0, -1.0, 1.0), v)
    n = np.stack([x, y, z], axis=-1)
    return n / np.linalg.norm(n, axis=-1, keepdims=True)


def test_normals_survive_packing() -> None:
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(1000, 3))
    normals[:6] = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    decoded = decode_oct(oct_words(normals))
    np.testing.assert_allclose(decoded, normals, atol=NORMAL_TOLERANCE)
    np.testing.assert_array_equal(decoded[:6], normals[:6])


def test_every_corner_keeps_what_its_mesh_says() -> None:
    mesh = sphere(6)
    rng = np.random.default_rng(1)
    colors = rng.uniform(size=(len(mesh.positions), 4))
    mesh = dataclasses.replace(mesh, colors=colors)
    texture = Texture(np.zeros((1, 1, 4), dtype=np.uint8))
    bvh = build_bvh(scene_of(mesh, Material(albedo_texture=texture)))
    table = surface_table(bvh)
    for primitive, pair in enumerate(bvh.primitive_triangles):
        for second, triangle in enumerate(pair):
            if triangle < 0:
                continue
            row = table[2 * primitive + second]
            vertices = mesh.triangles[triangle, bvh.primitive_corners[primitive, second]]
            np.testing.assert_allclose(
                decode_oct(row[:3]),
                mesh.normals[vertices],
                atol=NORMAL_TOLERANCE,
            )
            np.testing.assert_allclose(
                row[3:9].view(np.float32).reshape(3, 2),
                mesh.uvs[vertices],
                rtol=1e-6,
                atol=1e-7,
            )
            halves = np.stack([row[9:15] & 0xFFFF, row[9:15] >> 16], axis=1).reshape(3, 4)
            np.testing.assert_allclose(halves / 65535.0, colors[vertices], atol=1e-5)


def test_words_name_materials_and_flags() -> None:
    lamp = RectangleLight((0, 0, 0), (1, 0, 0), (0, 1, 0), (1.0,) * 3)
    free = dataclasses.replace(lamp, shadow="none")
    scene = Scene(
        (box(), sphere(4)),
        (Material(), Material(emission=(1.0,) * 3)),
        (SceneObject(0, 0), SceneObject(0, 1, light=0), SceneObject(1, 1, light=1)),
        CAMERA,
        (lamp, free),
    )
    bvh = build_bvh(scene)
    words = material_words(bvh, scene)
    found = {int(word) for word in words[bvh.primitive_triangles >= 0]}
    # Two rows for materials, then one for each lamp.
    assert found == {0, 2 | LIGHT_BODY_FLAG, 3 | LIGHT_BODY_FLAG | SMOOTH_FLAG}
    table = material_table(scene, {})
    np.testing.assert_array_equal(table[2:, :4], table[[1, 1], :4])
    assert table[:, 4, 1].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_lamps_of_several_materials_keep_each_their_own() -> None:
    lamp = RectangleLight((0, 0, 0), (1, 0, 0), (0, 1, 0), (1.0,) * 3)
    materials = tuple(Material(emission=(float(i),) * 3) for i in range(1, 4))
    # (material, light) of each object, in no order.
    pairs = [(2, 1), (0, None), (1, 1), (2, 0), (1, None), (2, 1)]
    objects = tuple(SceneObject(0, material, light=light) for material, light in pairs)
    scene = Scene((box(),), materials, objects, CAMERA, (lamp, lamp))
    bvh = build_bvh(scene)
    table, words = material_table(scene, {}), material_words(bvh, scene)
    rows = words & ~np.uint32(LIGHT_BODY_FLAG | SMOOTH_FLAG)
    is_there = bvh.primitive_triangles >= 0
    emission = table[rows[is_there], 1, 0]
    wanted = 1.0 + bvh.triangles.material[bvh.primitive_triangles[is_there]]
    np.testing.assert_array_equal(emission, wanted)
    assert len(np.unique(rows)) == 5


def image(height: int, width: int, seed: int, dtype=np.uint8) -> Texture:
    rng = np.random.default_rng(seed)
    pixels = rng.integers(0, 256, (height, width, 4), dtype=np.uint8)
    if dtype == np.float32:
        return Texture((pixels / 255.0).astype(np.float32))
    return Texture(pixels)


def test_the_atlas_holds_every_image_apart_from_the_others() -> None:
    textures = [image(h, w, i) for i, (h, w) in enumerate([(4, 9), (7, 3), (1, 1), (16, 16)])]
    atlas = build_atlas([*textures, textures[0]], 64)
    taken = np.zeros(atlas.pixels.shape[:2], dtype=int)
    for texture in textures:
        x, y, width, height = atlas.places[id(texture)]
        np.testing.assert_array_equal(atlas.pixels[y : y + height, x : x + width], texture.pixels)
        taken[y : y + height, x : x + width] += 1
    assert taken.max() == 1
    assert len(atlas.places) == 4


def test_images_are_halved_until_they_fit() -> None:
    textures = [image(64, 64, i) for i in range(5)]
    atlas = build_atlas(textures, 96)
    assert max(atlas.pixels.shape[:2]) <= 96
    assert {place[2:] for place in atlas.places.values()} == {(32, 32)}


def test_one_linear_image_makes_all_linear() -> None:
    encoded, linear = image(2, 2, 0), image(2, 2, 1, np.float32)
    encoded.pixels[0, 0] = (255, 0, 188, 128)
    atlas = build_atlas([encoded, linear], 64)
    assert atlas.pixels.dtype == np.float32
    x, y, _, _ = atlas.places[id(encoded)]
    # sRGB 188 is 0.5029 in linear light; alpha is not encoded.
    np.testing.assert_allclose(atlas.pixels[y, x], [1.0, 0.0, 0.50289, 128.0 / 255.0], atol=1e-4)


def test_materials_name_their_place_in_the_atlas() -> None:
    texture = dataclasses.replace(image(3, 5, 0), wrap=("clamp", "repeat"))
    material = Material(
        albedo=(0.1, 0.2, 0.3),
        emission=(4.0, 5.0, 6.0),
        alpha=0.5,
        alpha_cutoff=0.25,
        two_sided_emission=True,
        emission_texture=texture,
    )
    scene = Scene((), (Material(), material), (), CAMERA)
    table = material_table(scene, build_atlas([texture], 64).places)
    np.testing.assert_allclose(table[1, 0], [0.1, 0.2, 0.3, 0.5], rtol=1e-6)
    np.testing.assert_allclose(table[1, 1], [4.0, 5.0, 6.0, 1.0])
    np.testing.assert_allclose(table[1, 2], 0.0)
    np.testing.assert_allclose(table[1, 3], [0.0, 0.0, -5.0, 3.0])
    assert table[1, 4, 0] == pytest.approx(0.25)
    assert table[0, 4, 0] == -1.0


def test_features_are_those_of_what_is_drawn() -> None:
    plain = Mesh(box().positions, box().triangles)
    assert RayFeatures.of(scene_of(plain)) == RayFeatures(False, False, False, False, False)
    assert not RayFeatures.of(scene_of(plain)).needs_corners
    assert RayFeatures.of(scene_of(sphere(4))).smooth_normals
    painted = Material(albedo_texture=image(2, 2, 0), alpha_cutoff=0.5)
    # A texture without coordinates to look it up with is none.
    assert not RayFeatures.of(scene_of(plain, painted)).textures
    assert RayFeatures.of(scene_of(sphere(4), painted)) == RayFeatures(
        True, False, True, True, False
    )

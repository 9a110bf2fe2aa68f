"""What rays find on a surface: corners as they are packed, and images in the atlas."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from shaders.harness import evaluate

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.rays.ray_libraries import record_texture
from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.surface_tables import RayFeatures, surface_table
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.geometry.shapes import sphere
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene

INCLUDES = ["rays/surface_data.glsl"]
DEFINES = {
    "RAY_SMOOTH_NORMALS": 1,
    "RAY_VERTEX_COLORS": 1,
    "RAY_TEXTURES": 1,
    "RAY_CUTOUTS": 0,
    "RAY_SECOND_UVS": 0,
    "RAY_NORMAL_MAPS": 0,
    "RAY_TANGENTS": 0,
    "GLOSSY": 0,
}
# Normals have 16 bits for a component, colours too; texture coordinates are float32.
CORNER_TOLERANCE = {"normal": 6e-5, "color": 1e-5, "uv": 1e-6}
COUNT = 500


@pytest.fixture(scope="module")
def packed():
    """Rows of the table of a sphere, and what their triangles' corners carry."""
    rng = np.random.default_rng(2)
    mesh = sphere(6)
    mesh = dataclasses.replace(
        mesh,
        colors=rng.uniform(size=(len(mesh.positions), 4)),
        uvs=rng.uniform(-3.0, 3.0, (len(mesh.positions), 2)),
    )
    material = Material(albedo_texture=Texture(np.zeros((1, 1, 4), dtype=np.uint8)))
    bvh = build_bvh(Scene((mesh,), (material,), (SceneObject(0, 0),), Camera((0, 0, 3), (0, 0, 0))))
    rows = np.flatnonzero(bvh.primitive_triangles.ravel() >= 0)
    triangles = bvh.primitive_triangles.ravel()[rows, None]
    corners = bvh.primitive_corners.reshape(-1, 3)[rows]
    vertices = mesh.triangles[triangles, corners]
    carried = {
        "normal": mesh.normals[vertices],
        "color": mesh.colors[vertices],
        "uv": mesh.uvs[vertices],
    }
    return surface_table(bvh)[rows], carried


@pytest.mark.parametrize(("name", "components"), [("normal", 3), ("color", 4), ("uv", 2)])
def test_corners_are_interpolated_as_they_were_packed(gl, shaders, packed, name, components):
    table, carried = packed
    rng = np.random.default_rng(3)
    chosen = rng.integers(0, len(table), COUNT)
    weights = rng.dirichlet((1.0, 1.0, 1.0), COUNT)
    words = {f"w_{i}": table[chosen, 4 * i : 4 * i + 4] for i in range(4)}
    body = f"interpolated_{name}(Corners(w_0, w_1, w_2, w_3), weights)"
    found = evaluate(gl, shaders, INCLUDES, body, {**words, "weights": weights}, components,
                     defines=DEFINES)  # fmt: skip
    expected = np.einsum("ni,nic->nc", weights, carried[name][chosen])
    np.testing.assert_allclose(found, expected, atol=CORNER_TOLERANCE[name])


@pytest.mark.parametrize("rows", [1, 3, 587, 11587, 16383])
def test_every_row_of_a_table_is_found_however_many_there_are(gl, shaders, rows) -> None:
    numbers = np.arange(rows, dtype=np.uint32)
    texels = np.repeat(numbers[:, None, None], 4, axis=1)
    table = make_texture(gl, (4, rows), 1, "u4", texels)
    found = evaluate(gl, shaders, INCLUDES, "texelFetch(t_table, record_place(record, 4), 0).x",
                     {"record": numbers.astype(np.int32) << 10}, 1,
                     functions="uniform usampler2D t_table;", output_dtype="u4",
                     textures={"t_table": table}, defines=DEFINES)  # fmt: skip
    table.release()
    np.testing.assert_array_equal(found[:, 0], numbers)


@pytest.mark.parametrize(
    ("colors", "textures", "texels"), [(0, 0, 1), (0, 1, 3), (1, 0, 4), (1, 1, 4)]
)
def test_rows_of_corners_are_as_long_as_what_they_carry(gl, shaders, colors, textures, texels):
    words = np.random.default_rng(4).integers(0, 1 << 32, (2500, 16), dtype=np.uint32)
    features = RayFeatures(True, bool(colors), bool(textures), cutouts=False)
    assert features.corner_texels == texels
    table = record_texture(gl, len(words), "u4", lambda span: words[span], texels)
    defines = {**DEFINES, "RAY_VERTEX_COLORS": colors, "RAY_TEXTURES": textures}
    slots = np.arange(len(words))
    for texel in range(texels):
        found = evaluate(gl, shaders, INCLUDES, f"corners_of(slot).words_{texel}",
                         {"slot": slots}, 4, output_dtype="u4",
                         textures={"t_ray_surfaces": table}, defines=defines)  # fmt: skip
        np.testing.assert_array_equal(found, words[:, 4 * texel : 4 * texel + 4])


def looked_up(image, place, uv, wraps, is_nearest):
    """Return texels of a part of an image at coordinates, bilinear or nearest, in float64."""
    x, y, width, height = place
    size = np.array([width, height])
    t = uv * size - (0.0 if is_nearest else 0.5)
    low = np.floor(t)
    share = np.zeros_like(t) if is_nearest else t - low
    total = np.zeros((len(uv), 4))
    for i in range(2):
        for j in range(2):
            texel = low + (i, j)
            inside = np.where(wraps, np.mod(texel, size), np.clip(texel, 0, size - 1)).astype(int)
            weight = np.prod(np.where((i, j), share, 1.0 - share), axis=1)
            total += weight[:, None] * image[y + inside[:, 1], x + inside[:, 0]]
    return total


@pytest.mark.parametrize("is_nearest", [False, True])
@pytest.mark.parametrize("is_data", [False, True])
@pytest.mark.parametrize("wraps", [(True, True), (True, False), (False, True), (False, False)])
def test_images_of_the_atlas_repeat_or_end(gl, shaders, wraps, is_data, is_nearest):
    """And no texel of a neighbour is met; signs and halves of a place say how it is read."""
    rng = np.random.default_rng(4)
    images = rng.uniform(size=(2, 12, 16, 4)).astype(np.float32)
    x, y, width, height = 5, 3, 7, 4
    place = (
        x + 0.5 * is_nearest,
        y + 0.5 * is_data,
        width if wraps[0] else -width,
        height if wraps[1] else -height,
    )
    uv = rng.uniform(-2.5, 2.5, (COUNT, 2)).astype(np.float32)
    textures = {
        name: make_texture(gl, (16, 12), 4, "f4", image)
        for name, image in zip(("t_ray_atlas", "t_ray_data_atlas"), images, strict=True)
    }
    found = evaluate(gl, shaders, INCLUDES, "atlas_color(place, uv)",
                     {"place": np.tile(place, (COUNT, 1)), "uv": uv}, 4,
                     textures=textures, defines=DEFINES)  # fmt: skip
    image = images[int(is_data)].astype(np.float64)
    expected = looked_up(image, (x, y, width, height), uv.astype(np.float64), wraps, is_nearest)
    # Coordinates of some twenty texels have 24 bits.
    np.testing.assert_allclose(found, expected, atol=2e-5)

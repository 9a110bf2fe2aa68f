"""Rays through the hierarchy against rays against every triangle, and watertightness."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import moderngl
import numpy as np
import pytest
from meshes import soup
from numpy.typing import NDArray
from oracle.ray_triangles import edge_clearance, intersect_all
from program_of_text import fullscreen_source
from shaders.harness import evaluate

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.passes.rays.ray_libraries import record_texture
from ssdo_gl.raytracing.bvh import MAX_RECORDS, Bvh, build_bvh
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, sphere
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Positions in the frame are good to 6e-8 and t to a few of that over lengths up to 2, but
# divided by the cosine to the triangle where the ray grazes it; 1e-3 cosine is left out.
T_TOLERANCE = 2e-5
CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))


def bvh_of(mesh: Mesh) -> Bvh:
    return build_bvh(Scene((mesh,), (Material(),), (SceneObject(0, 0),), CAMERA))


def arguments(gl: moderngl.Context, bvh: Bvh, is_software: int = 1) -> dict[str, Any]:
    """Return defines, textures and uniforms of rays/bvh.glsl for `evaluate`."""
    records = bvh.records()
    table = record_texture(gl, len(records), "u4", lambda span: records[span])
    return {
        "defines": {
            "BVH_LEVELS": bvh.depth,
            "BVH_STACK_IN_REGISTERS": is_software,
            "BVH_FUSES": 1 - is_software,
            "RAY_SMOOTH_NORMALS": 0,
            "RAY_VERTEX_COLORS": 0,
            "RAY_TEXTURES": 0,
            "RAY_CUTOUTS": 0,
            "RAY_SECOND_UVS": 0,
            "RAY_NORMAL_MAPS": 0,
            "RAY_TANGENTS": 0,
            "GLOSSY": 0,
            "RAY_SINGLE_SIDED": 0,
        },
        "textures": {"t_bvh": table},
        "uniforms": {
            "u_bvh_root": bvh.root,
        },
    }


def random_rays(count: int, seed: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    # Some along an axis or in a coordinate plane, where slabs divide by zero.
    directions[::9, 0] = 0.0
    directions[::27, 1] = 0.0
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    origins = rng.uniform(-0.7, 0.7, (count, 3))
    both = origins.astype(np.float32), directions.astype(np.float32)
    return both[0].astype(np.float64), both[1].astype(np.float64)


NEAREST = """
    BvhHit hit = bvh_nearest(origin, direction, limit);
    int number = hit.record < 0 ? -1 : int(bvh_texel(hit.record, 3).x) * 2 + int(hit.is_second);
    return vec4(hit.t, float(number), 0.0, 0.0);
"""


@pytest.mark.parametrize("is_software", [0, 1])
@pytest.mark.parametrize("count", [1, 7, 400])
def test_nearest_hit_is_that_of_every_triangle_tried(gl, shaders, count, is_software) -> None:
    bvh = bvh_of(soup(count, count, 0.15))
    origins, directions = random_rays(4000, 11)
    limits = np.where(np.arange(4000) % 3, 4.0, 0.5)
    positions = bvh.triangles.positions.astype(np.float64)
    t, which = intersect_all(origins, directions, positions)
    t, which = np.where(t < limits, t, limits), np.where(t < limits, which, -1)

    out = evaluate(
        gl,
        shaders,
        ["rays/bvh.glsl"],
        NEAREST,
        {"origin": origins, "direction": directions, "limit": limits},
        4,
        **arguments(gl, bvh, is_software),
    )

    slot = out[:, 1].astype(np.int64)
    found = np.where(slot < 0, -1, bvh.primitive_triangles.reshape(-1)[np.maximum(slot, 0)])
    # Where the ray passes an edge or grazes a plane, rounding may decide otherwise.
    a, b, c = np.moveaxis(positions[np.maximum(which, found)], 1, 0)
    normal = np.cross(b - a, c - a)
    cosine = np.abs(np.einsum("nk,nk->n", normal, directions)) / np.linalg.norm(normal, axis=1)
    point = origins + t[:, None] * directions
    sure = (cosine > 1e-3) & (edge_clearance(point, positions[np.maximum(which, found)]) > 1e-5)
    assert np.mean(sure | (found == which)) > 0.99
    assert (which >= 0).sum() > (30 if count > 1 else 0)
    np.testing.assert_array_equal(found[sure], which[sure])
    np.testing.assert_allclose(out[sure, 0], t[sure], atol=T_TOLERANCE)


@pytest.mark.parametrize("is_software", [0, 1])
def test_blocked_is_the_same_as_having_a_nearest_hit(gl, shaders, is_software) -> None:
    bvh = bvh_of(soup(300, 4, 0.15))
    origins, directions = random_rays(20000, 12)
    limits = np.random.default_rng(1).uniform(0.0, 1.0, 20000)
    out = evaluate(
        gl,
        shaders,
        ["rays/bvh.glsl"],
        """
        bool blocked = bvh_is_blocked(origin, direction, limit);
        bool hit = bvh_nearest(origin, direction, limit).record >= 0;
        bool nothing = bvh_is_blocked(origin, direction, -1.0);
        return vec4(blocked ? 1.0 : 0.0, hit ? 1.0 : 0.0, nothing ? 1.0 : 0.0, 0.0);
        """,
        {"origin": origins, "direction": directions, "limit": limits},
        4,
        **arguments(gl, bvh, is_software),
    )
    np.testing.assert_array_equal(out[:, 0], out[:, 1])
    assert 0.1 < out[:, 0].mean() < 0.9
    assert not out[:, 2].any()


def test_an_empty_hierarchy_is_hit_by_nothing(gl, shaders) -> None:
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]]))
    origins, directions = random_rays(500, 2)
    out = evaluate(
        gl,
        shaders,
        ["rays/bvh.glsl"],
        "bvh_is_blocked(origin, direction, 4.0) ? 1.0 : 0.0",
        {"origin": origins, "direction": directions},
        **arguments(gl, bvh_of(flat)),
    )
    assert not out.any()


@pytest.mark.parametrize("is_software", [0, 1])
@pytest.mark.parametrize("shape", [box(), sphere(40)], ids=["box", "sphere"])
def test_rays_at_vertices_and_edges_do_not_slip_through(
    gl, device, shaders, shape, is_software
) -> None:
    if is_software and not device.is_software:
        pytest.skip("a GPU fuses products into sums, and is told so")
    bvh = bvh_of(shape)
    triangles = bvh.triangles.positions.astype(np.float64)
    rng = np.random.default_rng(7)
    which = rng.integers(0, len(triangles), 200_000)
    corner = rng.integers(0, 3, len(which))
    share = rng.uniform(0.0, 1.0, len(which))
    share[::4] = 0.0  # a quarter straight at a vertex, the others at an edge
    a, b = triangles[which, corner], triangles[which, (corner + 1) % 3]
    targets = a + share[:, None] * (b - a)
    origins = rng.uniform(-0.2, 0.2, targets.shape).astype(np.float32)
    directions = targets - origins
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    out = evaluate(
        gl,
        shaders,
        ["rays/bvh.glsl"],
        "bvh_is_blocked(origin, direction, 4.0) ? 0.0 : 1.0",
        {"origin": origins, "direction": directions},
        **arguments(gl, bvh, is_software),
    )
    assert out.sum() == 0.0


LEAKS = """#version 330 core
#include "rays/bvh.glsl"
#include "lib/random.glsl"
uniform float u_extent;
layout(location = 0) out float o_leaks;
// Rays from anywhere inside, in all directions; every eighth nearly along an axis.
void main()
{
    uint state = pixel_seed(ivec2(gl_FragCoord.xy));
    float leaks = 0.0;
    for (int i = 0; i < u_sample_count; ++i) {
        vec3 p, w;
        for (int k = 0; k < 3; ++k) {
            state = random_hash(state + 0x9e3779b9u);
            p[k] = (2.0 * unit_float(state) - 1.0) * u_extent;
            state = random_hash(state + 0x9e3779b9u);
            w[k] = 2.0 * unit_float(state) - 1.0;
        }
        w.yz *= (i & 7) == 0 ? 1e-4 : 1.0;
        leaks += bvh_is_blocked(p, normalize(w), 4.0) ? 0.0 : 1.0;
    }
    o_leaks = leaks;
}
"""


def count_leaks(gl, shaders: ShaderLibrary, bvh: Bvh, extent: float, draws: int) -> tuple[int, int]:
    """Return how many of how many random rays leave a closed surface."""
    settings: Mapping[str, Any] = arguments(gl, bvh)
    program = fullscreen_source(shaders, LEAKS, settings["defines"])
    target = make_texture(gl, (256, 256), 1, "f4")
    framebuffer = make_framebuffer(gl, [target])
    leaks, per_pixel = 0, 16
    for draw in range(draws):
        uniforms = {
            **settings["uniforms"],
            "u_extent": extent,
            "u_stream": draw + 1,
            "u_sample_count": per_pixel,
        }
        draw_fullscreen(gl, program, framebuffer, uniforms, settings["textures"])
        leaks += int(read_texture(target).sum())
    framebuffer.release()
    target.release()
    return leaks, draws * per_pixel * 256 * 256


# Interior of the unit sphere's inscribed cube in the frame whose half-diagonal is that of
# the bounds: 1 / sqrt(3) for a box; a sphere of radius 1 / sqrt(3) holds a cube of 1 / 3.
CLOSED = {"box": (box(), 0.57), "sphere": (sphere(96), 0.33)}


@pytest.mark.parametrize("name", list(CLOSED))
def test_closed_surfaces_leak_none_of_a_million_rays(gl, shaders, name: str) -> None:
    mesh, extent = CLOSED[name]
    leaks, rays = count_leaks(gl, shaders, bvh_of(mesh), extent, 2)
    assert rays > 2_000_000
    assert leaks == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", list(CLOSED))
def test_closed_surfaces_leak_none_of_a_hundred_million_rays(gl, shaders, name: str) -> None:
    mesh, extent = CLOSED[name]
    leaks, rays = count_leaks(gl, shaders, bvh_of(mesh), extent, 96)
    assert rays > 100_000_000
    assert leaks == 0


def test_the_leak_test_finds_a_hole(gl, shaders) -> None:
    mesh = sphere(96)
    holed = Mesh(mesh.positions, np.delete(mesh.triangles, 5000, axis=0))
    leaks, _ = count_leaks(gl, shaders, bvh_of(holed), 0.33, 1)
    assert leaks > 0


@pytest.mark.slow
@pytest.mark.parametrize("is_software", [0, 1])
def test_records_are_found_at_the_end_of_the_largest_table(gl, shaders, is_software) -> None:
    """A gibibyte of records, of which the first and the last ones are in use."""
    bvh = bvh_of(soup(400, 4, 0.15))
    records = bvh.records()
    offset = MAX_RECORDS - len(records)
    records[bvh.node_records, 10] += offset

    def part(span: slice) -> NDArray[np.uint32]:
        places = np.arange(span.start, span.stop)
        rows = np.where(places == 0, 0, places - offset)
        return np.where((rows >= 0)[:, None], records[np.maximum(rows, 0)], np.uint32(0))

    near = arguments(gl, bvh, is_software)
    table = record_texture(gl, MAX_RECORDS, "u4", part)
    root = {"u_bvh_root": records[0, :12].reshape(3, 4)}
    far = {**near, "textures": {"t_bvh": table}, "uniforms": root}
    origins, directions = random_rays(4000, 11)
    rays = {"origin": origins, "direction": directions, "limit": np.full(4000, 4.0)}
    expected = evaluate(gl, shaders, ["rays/bvh.glsl"], NEAREST, rays, 4, **near)
    found = evaluate(gl, shaders, ["rays/bvh.glsl"], NEAREST, rays, 4, **far)
    table.release()
    np.testing.assert_array_equal(found, expected)
    assert (found[:, 1] >= 0).any()


def test_what_stands_around_surfels_is_met_by_the_way_there(gl, shaders) -> None:
    number, count = 16, 100
    bvh = bvh_of(soup(40, 5, 0.15))
    rng = np.random.default_rng(6)
    rays = rng.uniform(-1.0, 1.0, (2, number, count, 4)).astype(np.float32)
    rays[1, ..., :3] /= np.linalg.norm(rays[1, ..., :3], axis=-1, keepdims=True)
    rays[1, ..., 3] = np.abs(rays[1, ..., 3]) + 0.1
    rays[1, 0, :9, 3] = -1.0  # no rays: they meet nothing
    given = arguments(gl, bvh)
    program = shaders.fullscreen("passes/surfel_surroundings.frag", given["defines"])
    names = zip(("t_starts", "t_ways"), rays, strict=True)
    textures = {n: make_texture(gl, (count, number), 4, "f4", image) for n, image in names}
    textures |= given["textures"]
    met = make_texture(gl, (count, number), 2, "u4")
    draw_fullscreen(gl, program, make_framebuffer(gl, [met]), given["uniforms"], textures)
    words = np.frombuffer(met.read(), np.uint32).reshape(-1, 2)

    positions = bvh.triangles.positions.astype(np.float64)
    starts, ways = rays.reshape(2, -1, 4).astype(np.float64)
    t, which = intersect_all(starts[:, :3], ways[:, :3], positions)
    which = np.where(t < ways[:, 3], which, -1)
    slot, length = words[:, 0], words[:, 1].copy().view(np.float32)
    is_met = slot != 0xFFFFFFFF
    found = np.full(len(slot), -1)
    found[is_met] = bvh.primitive_triangles.reshape(-1)[slot[is_met]]
    assert (found == which).mean() > 0.98
    assert is_met.any() and not is_met[:9].any()
    same = (found == which) & is_met
    a, b, c = np.moveaxis(positions[found[same]], 1, 0)
    from_behind = np.einsum("nk,nk->n", np.cross(b - a, c - a), ways[same, :3]) > 0.0
    signed = np.where(from_behind, -t[same], t[same])
    np.testing.assert_allclose(length[same], signed, atol=T_TOLERANCE)

"""Vertex buffers, culling and clip distances."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass

from ssdo_gl import math3d
from ssdo_gl.gpu.geometry import NEAREST_CLIP_RATIO, CameraPose, Geometry, grouped
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material, Texture

TAN = (0.8, 0.6)
FORWARD = CameraPose(np.zeros(3), np.eye(3))


def ahead(distance, size=1.0):
    """A cube whose nearest face is `distance` before the eye."""
    return box((-0.5 * size, -0.5 * size, -distance - size), (0.5 * size, 0.5 * size, -distance))


def test_clip_distances_enclose_what_is_seen_and_no_more(gl):
    aside = box((1000.0, 0.0, -10.0), (1001.0, 1.0, -9.0))
    behind = box((-1.0, -1.0, 5.0), (1.0, 1.0, 500.0))
    geometry = Geometry(gl, make_scene([ahead(4.0), ahead(20.0), aside, behind]))
    near, far = geometry.near_far(FORWARD, TAN)
    # Within the margin of 1e-3 that keeps rounding from clipping the faces themselves.
    assert 4.0 * 0.998 < near < 4.0
    assert 21.0 < far < 21.0 * 1.002
    turned = CameraPose(np.zeros(3), math3d.rotation_euler([0.0, 180.0, 0.0])[:3, :3])
    near, far = geometry.near_far(turned, TAN)
    assert 5.0 * 0.998 < near < 5.0
    assert 500.0 < far < 501.0
    geometry.release()


def test_clip_distances_inside_geometry(gl):
    geometry = Geometry(gl, make_scene([box((-1, -1, -7), (1, 1, 3))]))
    near, far = geometry.near_far(FORWARD, TAN)
    assert far == pytest.approx(7.0, rel=2e-3)
    assert near == far * NEAREST_CLIP_RATIO
    geometry.release()


def test_clip_distances_where_nothing_is_seen(gl):
    geometry = Geometry(gl, make_scene([box((-1, -1, 2), (1, 1, 3))]))
    near, far = geometry.near_far(FORWARD, TAN)
    assert 0.0 < near < far
    geometry.release()


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_clip_distances_scale_with_the_scene(gl, scale):
    geometry = Geometry(gl, make_scene([ahead(4.0 * scale, scale)]))
    assert geometry.near_far(FORWARD, TAN) == pytest.approx((4.0 * scale, 5.0 * scale), rel=2e-3)
    geometry.release()


def test_a_lights_own_body_does_not_pull_the_near_plane_in(gl):
    card = quad((-1, 0, -1), (2, 0, 0), (0, 0, 2))
    scene = make_scene([card, ahead(4.0)], objects=[SceneObject(0, 0, light=3), SceneObject(1, 0)])
    geometry = Geometry(gl, scene)
    assert geometry.near_far(FORWARD, TAN)[0] < 1e-4
    assert geometry.near_far(FORWARD, TAN, skip_light=3)[0] > 3.9
    assert geometry.near_far(FORWARD, TAN, skip_light=2)[0] < 1e-4
    geometry.release()


def test_bounds_along_rotated_axes(gl):
    spin = math3d.rotation_euler([10.0, 20.0, 30.0])[:3, :3]
    place = math3d.translation([5.0, 0.0, 0.0])
    scene = make_scene(
        [box((-1, -2, -3), (1, 2, 3))],
        objects=[SceneObject(0, 0, np.stack([np.eye(4), place]))],
    )
    geometry = Geometry(gl, scene)
    corners = np.array([[x, y, z] for x in (-1, 1, 4, 6) for y in (-2, 2) for z in (-3, 3)])
    low, high = geometry.bounds_along(spin)
    turned = corners @ spin.T
    np.testing.assert_allclose(low, turned.min(axis=0), atol=1e-12)
    np.testing.assert_allclose(high, turned.max(axis=0), atol=1e-12)
    geometry.release()
    empty = Geometry(gl, make_scene([]))
    assert not np.any(empty.bounds_along(spin))


def depth(gl, shaders, geometry, scene, size=(48, 36)):
    frame = make_frame(scene, size, geometry=geometry)
    return run_pass(gl, shaders, GBufferPass(), frame, geometry=geometry)["z_vs"]


def test_objects_of_one_mesh_share_a_draw_call():
    texture = Texture(np.ones((2, 2, 4), np.float32))
    card = dataclasses.replace(
        quad((0, 0, -1), (1, 0, 0), (0, 1, 0)),
        uvs=np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float),
    )
    materials = (
        Material(albedo=(1, 0, 0)),
        Material(albedo=(0, 1, 0), emission=(1, 1, 1)),
        Material(albedo_texture=texture),
    )
    objects = [SceneObject(0, i) for i in (0, 1, 2, 0, 2)]
    # Plain materials in one call, the textured one in another.
    assert grouped(make_scene([card], materials=materials, objects=objects)) == [[0, 1, 3], [2, 4]]


def test_culling_drops_nothing_that_shows(gl, shaders):
    """Thousands of instances, all over and around the view, against one drawn alone."""
    rng = np.random.default_rng(1)
    places = np.array([math3d.translation(p) for p in rng.uniform(-12, 12, (3000, 3))])
    places[:, :3, :3] *= rng.uniform(0.1, 1.0, (3000, 1, 1))
    cube = box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
    scene = make_scene([cube], objects=[SceneObject(0, 0, places)])
    geometry = Geometry(gl, scene)
    together = depth(gl, shaders, geometry, scene)
    geometry.release()
    # The same triangles as one mesh, which nothing can cull.
    merged = dataclasses.replace(
        cube,
        positions=(cube.positions[None] @ np.swapaxes(places[:, :3, :3], 1, 2)
                   + places[:, None, :3, 3]).reshape(-1, 3),
        triangles=(cube.triangles[None] + 8 * np.arange(3000)[:, None, None]).reshape(-1, 3),
    )  # fmt: skip
    scene = make_scene([merged])
    geometry = Geometry(gl, scene)
    apart = depth(gl, shaders, geometry, scene)
    geometry.release()
    # Float32 places a vertex relative to a cube in one case, to the whole in the other:
    # a pixel on a silhouette may see one cube or the next.
    different = np.abs(together - apart) > 2e-5 * apart
    assert np.mean(different) < 2e-3


def test_update_moves_objects_and_frees_what_is_gone(gl, shaders):
    card = quad((-5, -5, 0), (10, 0, 0), (0, 10, 0))
    other = quad((-5, -5, -1), (10, 0, 0), (0, 10, 0))
    place = math3d.translation([0.0, 0.0, -3.0])
    scene = make_scene([card], objects=[SceneObject(0, 0, place[None])])
    geometry = Geometry(gl, scene)
    assert np.all(depth(gl, shaders, geometry, scene) == 3.0)
    moved = make_scene(
        [card, other], objects=[SceneObject(0, 0, place[None] + place[None] - np.eye(4))]
    )
    geometry.update(moved)
    assert np.all(depth(gl, shaders, geometry, moved) == 6.0)
    swapped = make_scene([other])
    geometry.update(swapped)
    assert np.all(depth(gl, shaders, geometry, swapped) == 1.0)
    geometry.release()


def test_far_from_the_origin_vertices_keep_their_precision(gl, shaders):
    """A card baked at 1e5 with details of 1e-6, seen by a camera out there."""
    offset = np.array([1e5, -1e5, 1e5])
    near_card = quad(np.add(offset, (-5, -5, -3)), (10, 0, 0), (0, 10, 0))
    camera = dataclasses.replace(
        make_scene([]).camera, position=tuple(offset), target=tuple(offset - [0, 0, 1])
    )
    scene = make_scene([near_card], camera=camera)
    geometry = Geometry(gl, scene)
    # float64 holds 1e5 to 1.5e-11; float32 would hold it to 8e-3.
    np.testing.assert_allclose(depth(gl, shaders, geometry, scene), 3.0, rtol=3e-7)
    geometry.release()

"""Triangles that compute shaders rasterize, against float64 and a rasterizer."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.pass_harness import box, make_frame, make_scene, quad

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.geometry import Geometry, TriangleRasterizer, can_rasterize
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.material import Material

SIZE = (97, 61)
NEAR_FAR = (0.05, 60.0)
MISSED = 1e9
# Half of what the frame of parallel rays shows.
HALF_FRAME = 4.5, 3.0


def rasterized(gl, shaders, scene, *, parallel=False, room=None, backs=False, before=(), **more):
    """Return the view, numbers from 0 on (-1: none) and depths, top row first.

    `before`: scenes that the same rasterizer draws first.
    """
    more = {"near_far": NEAR_FAR, "jitter_px": (0.2, -0.3)} | more
    rasterizer = TriangleRasterizer(gl, SIZE, ids=not backs, room=room)
    for drawn in (*before, scene):
        geometry = Geometry(gl, drawn)
        view = make_frame(drawn, SIZE, **more).view
        if parallel:
            view = dataclasses.replace(view, tan_half_fov=(0.0, 0.0), half_frame=HALF_FRAME)
        parts = geometry.visible_triangles(view, view.clip_from_view)
        uniforms = view.raster_uniforms()
        rasterizer.draw(shaders.choosing(view.choices), parts, uniforms, backs=backs)
        geometry.release()
    textures = rasterizer.depth_keys, rasterizer.ids
    keys, ids = (np.frombuffer(t.read(), np.uint32).reshape(SIZE[::-1])[::-1] for t in textures)
    depths = np.where(keys == 0, 0, ~keys).view(np.float32)
    return view, np.where(ids == 0, 0, ~ids).astype(np.int64) - 1, depths


def soup(seed, count=220):
    """Triangles of all sizes before, beside, behind and across the eye; returns corners too."""
    rng = np.random.default_rng(seed)
    center = rng.uniform((-6.0, -4.0, -25.0), (6.0, 4.0, 1.0), (count, 1, 3))
    size = 10.0 ** rng.uniform(-3.0, 0.5, (count, 1, 1))
    corners = center + size * rng.normal(size=(count, 3, 3))
    corners[:3, 2] = 0.5 * (corners[:3, 0] + corners[:3, 1]) + 1e-4 * rng.normal(size=(3, 3))
    mesh = Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
    return mesh, corners


def met(view, corners):
    """Return depths of triangles along rays through pixels, NaN where they are missed, and
    how far, of the frame's height, rays pass beside an edge: (rows, columns, triangles)."""
    width, height = view.size
    x, y = np.meshgrid(
        (2.0 * np.arange(width) + 1.0) / width - 1.0, 1.0 - (2.0 * np.arange(height) + 1.0) / height
    )
    clip = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], -1) @ view.clip_from_view.T
    h = clip[..., [0, 1, 3]]
    edges = np.stack([np.cross(h[:, i], h[:, (i + 1) % 3]) for i in range(3)], 1)
    place = np.stack([x, y, np.ones_like(x)], -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        beside = np.einsum("tec,yxc->yxte", edges, place)
        beside /= np.linalg.norm(edges[..., :2], axis=-1)
        side = np.sign(np.linalg.det(h))[:, None]
        inside = (beside * side >= 0.0).all(-1)
        # Weights of the corners, with perspective.
        weights = beside * np.linalg.norm(edges[..., :2], axis=-1)
        weights /= weights.sum(-1, keepdims=True)
        z = -np.einsum("yxte,te->yxt", weights[..., [1, 2, 0]], corners[..., 2])
    z[~inside | ~(z >= view.near) | ~np.isfinite(z)] = np.nan
    return z, np.abs(beside).min(-1)


@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("room", [None, (3, 3), (40, 1000)])
def test_the_nearest_triangle_is_found(gl, computing, parallel, seed, room):
    """Whether or not there is room for what is large."""
    mesh, corners = soup(seed)
    near = soup(seed + 10)[0]
    before = [make_scene([Mesh(0.2 * near.positions, near.triangles)])]
    scene = make_scene([mesh])
    view, ids, depths = rasterized(
        gl, computing, scene, parallel=parallel, room=room, before=before
    )
    center = 0.5 * (mesh.positions.min(0) + mesh.positions.max(0))
    # As they are stored, so that what is left is what shaders round.
    stored = (corners - center).astype(np.float32).astype(np.float64) + center
    z, beside = met(view, stored)
    by_depth = np.sort(np.where(np.isnan(z), MISSED, z), -1)
    nearest = by_depth[..., 0]
    assert 0.3 < np.mean(nearest < MISSED) < 1.0
    found = np.take_along_axis(z, np.maximum(ids, 0)[..., None], -1)[..., 0]
    # A ray that passes an edge by so little, or meets two at once, may go either way.
    is_alone = (by_depth[..., 1] - nearest > 1e-4 * nearest) | (nearest == MISSED)
    sure = (beside > 1e-4).all(-1) & is_alone
    assert sure.mean() > 0.8
    np.testing.assert_array_equal((ids < 0)[sure], (nearest == MISSED)[sure])
    shown = sure & (ids >= 0)
    np.testing.assert_allclose(found[shown], nearest[shown], rtol=1e-12)
    np.testing.assert_allclose(depths[shown], nearest[shown], rtol=2e-4)
    assert np.median(np.abs(depths[shown] / nearest[shown] - 1.0)) < 1e-6


@pytest.mark.parametrize("distance", [3.0, 3e4])
@pytest.mark.parametrize("cells", [3, 40, 300])
def test_no_pixel_is_left_out_between_triangles(gl, computing, cells, distance):
    """A wavy net that fills the frame, of triangles from a hundred pixels to a fifth of one."""
    rng = np.random.default_rng(cells)
    x, y = np.meshgrid(np.linspace(-4.0, 4.0, cells + 1), np.linspace(-3.0, 3.0, cells + 1))
    spread = 0.3 / cells
    points = np.stack([x, y, np.full_like(x, -3.0)], -1).reshape(-1, 3)
    points += rng.uniform(-spread, spread, points.shape) * [1.0, 1.0, 3.0]
    i = np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)
    a, b, c, d = (i.ravel() + n for n in (0, 1, cells + 2, cells + 1))
    mesh = Mesh(
        points * (distance / 3.0), np.concatenate([np.stack(t, 1) for t in ((a, b, c), (a, c, d))])
    )
    near_far = 0.01 * distance, 10.0 * distance
    _, ids, depths = rasterized(gl, computing, make_scene([mesh]), near_far=near_far)
    assert (ids >= 0).all()
    np.testing.assert_allclose(depths, distance, rtol=0.2)


def test_an_edge_through_the_centres_of_pixels_belongs_to_both_its_triangles(gl, computing):
    """The middle column of an odd number; which of the two it shows does not matter."""
    across, up = (20.0, 0.0, 0.0), (0.0, 20.0, 0.0)
    scene = make_scene([quad((x, -10.0, -3.0), across, up) for x in (-20.0, 0.0)])
    _, ids, _ = rasterized(gl, computing, scene, parallel=True, jitter_px=(0.0, 0.0))
    assert (ids >= 0).all()
    assert {*ids[:, 0]} <= {0, 1} and {*ids[:, -1]} <= {2, 3}


def turning_boxes():
    """Closed boxes, of which one holds the eye and one is mirrored."""
    mesh = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    places = []
    for scale, position in (
        ((9.0, 9.0, 9.0), (0.0, 0.0, 0.0)),
        ((0.6, 0.8, 0.5), (-1.0, 0.3, -4.0)),
        ((-0.7, 0.5, 0.6), (1.2, -0.4, -5.0)),
    ):
        place = np.diag([*scale, 1.0])
        place[:3, 3] = position
        places.append(place)
    return mesh, np.array(places)


def test_sides_are_those_that_a_rasterizer_draws(gl, computing):
    """Fronts of solids, both sides of the one that holds the eye, and backs by themselves."""
    mesh, places = turning_boxes()
    scene = make_scene([mesh], objects=[SceneObject(0, 0, places[:, :3, :])])
    _, _, depths = rasterized(gl, computing, scene)
    _, _, backs = rasterized(gl, computing, scene, backs=True)
    center = depths[SIZE[1] // 2]
    assert depths.min() > 0.0 and center.min() < 4.5 < depths.max() <= 9.001
    seen = backs < 8.9
    assert 0.01 < seen.mean() < 0.4
    # Behind a box's front lies its back, one depth of the box away or less.
    assert (backs[seen] > depths[seen]).all() and (backs[seen] - depths[seen] <= 1.4).all()
    assert (backs > 0.0).all()  # the inside of the box that holds the eye


def test_single_sided_surfaces_hide_their_backs(gl, computing):
    meshes = [quad((-1.5, -1.0, -3.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0))]
    meshes.append(quad((1.5, -1.0, -3.0), (-1.0, 0.0, 0.0), (0.0, 2.0, 0.0)))
    counts = {}
    for single_sided in (False, True):
        scene = make_scene(meshes, materials=[Material(single_sided=single_sided)])
        _, ids, _ = rasterized(gl, computing, scene)
        counts[single_sided] = [int(np.isin(ids, pair).sum()) for pair in ((0, 1), (2, 3))]
    assert min(counts[False]) > 50
    assert counts[True] == [counts[False][0], 0]


def written(gl, shaders, fragment, kind, textures):
    """Return what a full-screen shader leaves of 37s, all bits of which matter."""
    output = make_texture(gl, SIZE, 1, kind, np.full((*SIZE[::-1], 1), 37, f"<{kind}").tobytes())
    target = make_framebuffer(gl, [output])
    draw_fullscreen(gl, shaders.fullscreen(fragment), target, {}, textures)
    found = np.frombuffer(output.read(), f"<{kind}").reshape(SIZE[::-1])
    target.release()
    output.release()
    return found


def test_numbers_are_cleared(gl, shaders_either_way):
    assert not written(gl, shaders_either_way, "passes/clear_ids.frag", "u4", {}).any()


def test_keys_stand_for_depths(gl, shaders_either_way):
    """To the last bit, and 0 for background."""
    rng = np.random.default_rng(0)
    depths = (10.0 ** rng.uniform(-9.0, 9.0, SIZE[::-1])).astype(np.float32)
    is_open = rng.uniform(size=depths.shape) < 0.3
    keys = np.where(is_open, 0, ~depths.view(np.uint32)).astype(np.uint32)
    texture = make_texture(gl, SIZE, 1, "u4", keys.tobytes())
    textures = {"t_depth_keys": texture}
    found = written(gl, shaders_either_way, "passes/depths_of_keys.frag", "f4", textures)
    np.testing.assert_array_equal(found, np.where(is_open, np.float32(0.0), depths))
    texture.release()


def test_what_has_holes_is_left_to_the_rasterizer(gl):
    solid, holes = Material(), Material(alpha=0.4, alpha_cutoff=0.5)
    meshes = [quad((-1.0, -1.0, -3.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))] * 2
    for materials, wanted in (((solid, solid), True), ((solid, holes), False)):
        objects = [SceneObject(0, 0), SceneObject(1, 1)]
        scene = make_scene(meshes, materials=materials, objects=objects)
        geometry, view = Geometry(gl, scene), make_frame(scene, SIZE, near_far=NEAR_FAR).view
        parts = geometry.visible_triangles(view, view.clip_from_view)
        assert can_rasterize(parts) == wanted
        geometry.release()

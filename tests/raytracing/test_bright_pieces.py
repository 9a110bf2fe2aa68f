"""Which surfels rays are aimed at, and that what they are aimed at holds all of them."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.raytracing.bright_pieces import BrightSurfels, bright_pieces, bright_surfels
from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.packed import oct_words, unit_vectors
from ssdo_gl.raytracing.surfel_points import NOTHING_MET
from ssdo_gl.raytracing.surfels import build_surfels
from ssdo_gl.raytracing.torn_surfels import TornSurfels, torn
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, sphere
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.0, 0.0, 3.0), (0.0, 0.0, 0.0))
ALBEDO = 0.5
# Octahedral steps of 16 bits.
CODE_ERROR = 1e-4


def chosen(light: np.ndarray, met: np.ndarray) -> list[int]:
    """Return what is bright where each surfel is met so many times."""
    targets = np.repeat(np.arange(len(light)), met)
    return bright_surfels(targets, np.full(len(targets), ALBEDO), light).numbers.tolist()


def test_what_is_far_brighter_than_the_rest_is_aimed_at_and_no_more() -> None:
    light, met = np.full(100, 1.0), np.full(100, 20)
    light[:3], light[3] = 100.0, 6.0
    assert chosen(light, met) == [0, 1, 2]


@pytest.mark.parametrize("share", [0.04, 0.06])
def test_where_it_brings_little_nothing_is(share: float) -> None:
    light, met = np.full(1001, 1.0), np.full(1001, 20)
    light[0], met[0] = share / (1.0 - share) * 20_000.0, 1
    assert chosen(light, met) == ([0] if share > 0.05 else [])


def test_even_light_and_darkness_have_nothing_to_aim_at() -> None:
    assert chosen(np.ones(50), np.full(50, 3)) == []
    assert chosen(np.zeros(50), np.full(50, 3)) == []
    assert chosen(np.ones(50), np.zeros(50, dtype=np.int64)) == []


def test_what_no_ray_has_met_may_be_the_brightest() -> None:
    light, met = np.full(100, 1.0), np.full(100, 20)
    light[:2], met[1] = 500.0, 0
    assert chosen(light, met) == [0, 1]


def surfels_of(mesh: Mesh, texel: float) -> TornSurfels:
    bvh = build_bvh(Scene((mesh,), (Material(),), (SceneObject(0, 0),), CAMERA))
    whole = build_surfels(bvh, 65535, texel)
    met = np.full((whole.count, whole.ends.shape[1]), NOTHING_MET, dtype=np.int64)
    return torn(whole, bvh, met, np.zeros(met.shape), 65535)


@pytest.mark.parametrize(("mesh", "texel"), [(box(), 0.3), (sphere(48), 0.5)])
def test_points_lie_within_the_parallelogram_or_the_box(mesh: Mesh, texel: float) -> None:
    surfels = surfels_of(mesh, texel)
    every = np.arange(surfels.count)
    bright = BrightSurfels(every, np.ones(len(every)), np.ones(len(every)))
    made = bright_pieces(bright, surfels, surfels.triangles)
    is_flat = made.faces[:, 1] == 1
    assert is_flat.all() if len(mesh.triangles) == 12 else (~is_flat).sum() > 10
    for surfel, (first, count) in zip(every, made.faces, strict=True):
        rows = made.entries[first : first + count].astype(np.float64)
        assert (made.owners[first : first + count] == surfel).all()
        points = surfels.positions[surfel]
        for corner, edge_u, edge_v in rows[:, :3, :3]:
            normal = np.cross(edge_u, edge_v)
            if count == 1:
                axes = np.stack([edge_u, edge_v, normal], axis=1)
                place = np.linalg.solve(axes, (points - corner).T)
                assert place[:2].min() > 0.0 and place[:2].max() < 1.0
            else:
                assert ((points - corner) @ normal).max() < 0.0


def test_normals_are_unpacked_as_they_were_packed() -> None:
    normals = np.random.default_rng(1).normal(size=(500, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.abs(unit_vectors(oct_words(normals)) - normals).max() < CODE_ERROR

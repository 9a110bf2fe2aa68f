"""Shafts through the hierarchy against rays against every triangle, and watertightness."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.ray_triangles import intersect_all
from shaders.harness import evaluate
from shaders.test_bvh import arguments, bvh_of, soup

from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.shapes import box, sphere

SHAFTS, LINES, LINE_POINTS = 60, 8, 32
POINTS = LINES * LINE_POINTS
ALL = np.uint32(0xFFFFFFFF)
# The first point of each line, and from each to the next: no two are as high.
STEP = np.array([2.0 / LINE_POINTS, 2.0 / POINTS])
FIRST = np.stack([np.linspace(-0.999, -0.95, LINES), np.linspace(-0.996, 0.754, LINES)], axis=1)

OPEN = """
    Shaft shaft = shaft_from(apex, mat3(middle, u, v), abs(u) + abs(v), 0.9);
    ShaftPoints points = shaft_open_points(shaft);
    return points.WHAT;
"""


def bits(gl, shaders, bvh, ways, what, *, is_software=1, steps=1000, there=ALL):
    """Return `what` of the points of ways (n, 4, 3): apex, middle, two axes."""
    wanted = arguments(gl, bvh, is_software)
    wanted["defines"] |= {"SHAFT_GROUPS": 2}
    wanted["uniforms"] |= {
        "u_shaft_x": FIRST[:, 0].reshape(2, 4),
        "u_shaft_y": FIRST[:, 1].reshape(2, 4),
        "u_shaft_step": tuple(STEP),
        "u_shaft_points": np.full((2, 4), there, np.uint32),
        "u_shaft_steps": steps,
        "u_shaft_rays": 16,
    }
    inputs = {name: ways[:, i] for i, name in enumerate(("apex", "middle", "u", "v"))}
    body, size = OPEN.replace("WHAT", what), 1 if what == "by_rays" else 4
    body = body.replace("points.by_rays", "uint(points.by_rays)")
    return evaluate(
        gl, shaders, ["rays/shaft.glsl"], body, inputs, size, output_dtype="u4", **wanted
    )


def points_of(gl, shaders, bvh, ways, what, **switches):
    """Return which points are `what`, (n, POINTS), line by line."""
    groups = [bits(gl, shaders, bvh, ways, f"{what}[{g}]", **switches) for g in (0, 1)]
    found = np.concatenate(groups, axis=1)[:, :, None] >> np.arange(LINE_POINTS, dtype=np.uint32)
    return (found & 1).astype(bool).reshape(len(ways), POINTS)


def by_rays(gl, shaders, bvh, ways, **switches):
    return bits(gl, shaders, bvh, ways, "by_rays", **switches)[:, 0].astype(bool)


def places():
    """Return the points (POINTS, 2) as multiples of a light's axes."""
    return (FIRST[:, None] + np.arange(LINE_POINTS)[:, None] * STEP).reshape(POINTS, 2)


def random_ways(seed):
    """Lights of all sizes in all directions, some of them across an axis."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(SHAFTS, 4, 3))
    ways[:, 0] = rng.uniform(-0.7, 0.7, (SHAFTS, 3))
    ways[:, 2:] *= rng.uniform(0.0, 0.7, (SHAFTS, 1, 1))
    ways[::5, 1, 1] = ways[::5, 2, 1] = ways[::5, 3, 1] = 0.0
    return ways.astype(np.float32).astype(np.float64)


def true_points(bvh, ways):
    """Return which points are open by rays."""
    where = places()
    origins = np.repeat(ways[:, 0], len(where), axis=0)
    to = ways[:, 1, None] + np.einsum("pk,nkx->npx", where, ways[:, 2:])
    t, _ = intersect_all(origins, to.reshape(-1, 3), bvh.triangles.positions.astype(np.float64))
    return (t >= 0.9).reshape(len(ways), len(where))


@pytest.mark.parametrize("is_software", [0, 1])
@pytest.mark.parametrize("count", [1, 7, 400])
def test_open_points_are_those_of_rays(gl, shaders, count, is_software):
    bvh = bvh_of(soup(count, count))
    ways = random_ways(count)
    true = true_points(bvh, ways)
    found = points_of(gl, shaders, bvh, ways, "open", is_software=is_software)
    assert 0.02 < true.mean() < 0.999
    # Rounding decides of points behind an edge.
    assert (found != true).sum() <= 6
    assert not by_rays(gl, shaders, bvh, ways, is_software=is_software).any()


def test_only_points_on_the_light_are_asked_for(gl, shaders):
    bvh = bvh_of(soup(7, 7))
    ways = random_ways(3)
    there = np.random.default_rng(1).integers(0, 1 << 32, (2, 4), dtype=np.uint32)
    is_there = (there.reshape(-1, 1) >> np.arange(LINE_POINTS, dtype=np.uint32) & 1).astype(bool)
    found = points_of(gl, shaders, bvh, ways, "open", there=there)
    assert (found != true_points(bvh, ways) & is_there.ravel()).sum() <= 3
    for what in ("left", "asked"):
        assert (points_of(gl, shaders, bvh, ways, what, there=there) == found).all()


def test_where_the_shaft_does_not_tell_rays_do(gl, shaders):
    bvh = bvh_of(soup(400, 400))
    ways = random_ways(400)
    limited = {"steps": 8}
    told = by_rays(gl, shaders, bvh, ways, **limited)
    assert 0.1 < told.mean() < 0.98
    left, asked, found = (
        points_of(gl, shaders, bvh, ways, what, **limited) for what in ("left", "asked", "open")
    )
    true = true_points(bvh, ways)
    # What the walk left out is hidden; of the rest two on each line, at other places along it, are
    # asked for.
    assert (true & ~left).sum() <= 3
    rays = np.zeros((LINES, LINE_POINTS), dtype=bool)
    rays[3 * np.arange(16) % LINES, 1 + 2 * np.arange(16)] = True
    assert (asked == left & np.where(told[:, None], rays.ravel(), True)).all()
    assert (found != true & asked).sum() <= 3


def test_a_blocker_thinner_than_what_lies_between_points_is_found(gl, shaders):
    """A slat that hides a four-hundredth of the light, and one point, wherever that is."""
    corners = [[-1.0, 0.0, -1.5e-4], [1.0, 0.0, -1.5e-4], [1.0, 0.0, 1.5e-4], [-1.0, 0.0, 1.5e-4]]
    bvh = bvh_of(Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])))
    way = [[0.0, -0.5, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.1]]
    ways = np.tile(way, (POINTS, 1, 1))
    ways[:, 0, 2] = -0.05 * places()[:, 1]
    assert (points_of(gl, shaders, bvh, ways, "open") == ~np.eye(POINTS, dtype=bool)).all()


@pytest.mark.parametrize("is_software", [0, 1])
@pytest.mark.parametrize("shape", [box(), sphere(40)], ids=["box", "sphere"])
@pytest.mark.parametrize("size", [0.0, 0.02])
def test_nothing_of_a_light_shows_between_triangles(gl, shaders, shape, size, is_software):
    """Seen from inside a closed body, a light behind its edges is hidden.

    At a vertex rounding may leave a gap of some 1e-7, which only aimed ways find.
    """
    bvh = bvh_of(shape)
    triangles = bvh.triangles.positions.astype(np.float64)
    rng = np.random.default_rng(7)
    which, corner = rng.integers(0, len(triangles), 20_000), rng.integers(0, 3, 20_000)
    share = rng.uniform(0.01, 0.99, (len(which), 1))
    a, b = triangles[which, corner], triangles[which, (corner + 1) % 3]
    ways = rng.normal(size=(len(which), 4, 3)) * size
    ways[:, 0] = rng.uniform(-0.2, 0.2, (len(which), 3)).astype(np.float32)
    ways[:, 1] = 2.0 * (a + share * (b - a) - ways[:, 0])
    assert not points_of(gl, shaders, bvh, ways, "open", is_software=is_software).any()

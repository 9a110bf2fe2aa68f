"""Shafts through the hierarchy against rays against every triangle, and watertightness."""

from __future__ import annotations

import numpy as np
import pytest
from oracle.ray_triangles import intersect_all
from shaders.harness import evaluate
from shaders.test_bvh import arguments, bvh_of, soup

from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.shapes import box, sphere

SHAFTS, POINTS = 400, 24
FIRST = np.array([0.3, 0.8])
STEP = np.array([0.7548776662466927, 0.5698402909980532])

OPEN = """
    vec3 extent = SHAFT_IS_ROUND == 1 ? sqrt(u * u + v * v) : abs(u) + abs(v);
    Shaft shaft = shaft_from(apex, mat3(middle, u, v), extent, 0.9);
    ShaftPoints points = shaft_open_points(shaft, begin, count);
    return uvec2(points.open, points.by_rays);
"""


def open_points(gl, shaders, bvh, ways, *, first=0, count=POINTS, **switches):
    """Return which points are open (n, count), and where rays had to tell (n,).

    `ways` (n, 4, 3): apex, middle, two axes; `switches`: is_round and is_software.
    """
    wanted = arguments(gl, bvh, switches.get("is_software", 1))
    wanted["defines"]["SHAFT_IS_ROUND"] = switches.get("is_round", 0)
    wanted["uniforms"] |= {"u_shaft_step": tuple(STEP)}
    inputs = {name: ways[:, i] for i, name in enumerate(("apex", "middle", "u", "v"))}
    inputs["begin"] = np.tile(FIRST + first * STEP, (len(ways), 1))
    inputs["count"] = np.full(len(ways), count, np.int32)
    bits = evaluate(gl, shaders, ["rays/shaft.glsl"], OPEN, inputs, 2, output_dtype="u4", **wanted)
    is_open = bits[:, :1] >> np.arange(count, dtype=np.uint32) & 1
    return is_open.astype(bool), bits[:, 1].astype(bool)


def places(is_round, first=0, count=POINTS):
    """Return the points (count, 2) as multiples of a light's axes."""
    u = (FIRST + (first + np.arange(count))[:, None] * STEP) % 1.0
    if not is_round:
        return 2.0 * u - 1.0
    angle = 2.0 * np.pi * u[:, 1]
    return np.sqrt(u[:, :1]) * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def random_ways(seed):
    """Lights of all sizes in all directions, some of them across an axis."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(SHAFTS, 4, 3))
    ways[:, 0] = rng.uniform(-0.7, 0.7, (SHAFTS, 3))
    ways[:, 2:] *= rng.uniform(0.0, 0.7, (SHAFTS, 1, 1))
    ways[::5, 1, 1] = ways[::5, 2, 1] = ways[::5, 3, 1] = 0.0
    return ways.astype(np.float32).astype(np.float64)


def true_points(bvh, ways, where):
    """Return the same by rays: `where` are points (count, 2) as multiples of the axes."""
    origins = np.repeat(ways[:, 0], len(where), axis=0)
    to = ways[:, 1, None] + np.einsum("pk,nkx->npx", where, ways[:, 2:])
    t, _ = intersect_all(origins, to.reshape(-1, 3), bvh.triangles.positions.astype(np.float64))
    return (t >= 0.9).reshape(len(ways), len(where))


@pytest.mark.parametrize("is_round", [0, 1])
@pytest.mark.parametrize("is_software", [0, 1])
@pytest.mark.parametrize("count", [1, 7, 400])
def test_open_points_are_those_of_rays(gl, shaders, count, is_software, is_round):
    bvh = bvh_of(soup(count, count))
    ways = random_ways(count)
    true = true_points(bvh, ways, places(is_round))
    found, _ = open_points(gl, shaders, bvh, ways, is_round=is_round, is_software=is_software)
    assert 0.02 < true.mean() < 0.999
    # Rounding decides of points behind an edge.
    assert (found != true).sum() <= 3


@pytest.mark.parametrize("first", [0, 8])
@pytest.mark.parametrize("count", [1, 5, 32])
def test_any_number_of_points_from_any_on(gl, shaders, first, count):
    bvh = bvh_of(soup(7, 7))
    ways = random_ways(3)
    found, _ = open_points(gl, shaders, bvh, ways, first=first, count=count)
    assert (found != true_points(bvh, ways, places(0, first, count))).sum() <= 3


def test_where_rays_have_to_tell_is_known(gl, shaders):
    bvh = bvh_of(soup(400, 400))
    ways = random_ways(400)
    is_open, by_rays = open_points(gl, shaders, bvh, ways)
    assert 0.1 < by_rays.mean() < 0.9
    # Of what is all hidden the shaft may have told before it gave up.
    assert is_open[~by_rays].any()
    assert not open_points(gl, shaders, bvh_of(soup(1, 1)), ways)[1].any()


def test_a_blocker_thinner_than_what_lies_between_points_is_found(gl, shaders):
    """A slat that hides a four-hundredth of the light, and one point, wherever that is."""
    corners = [[-1.0, 0.0, -1.5e-4], [1.0, 0.0, -1.5e-4], [1.0, 0.0, 1.5e-4], [-1.0, 0.0, 1.5e-4]]
    bvh = bvh_of(Mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]])))
    way = [[0.0, -0.5, 0.0], [0.0, 1.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.1]]
    ways = np.tile(way, (POINTS, 1, 1))
    ways[:, 0, 2] = -0.05 * places(0)[:, 1]
    assert (open_points(gl, shaders, bvh, ways)[0] == ~np.eye(POINTS, dtype=bool)).all()


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
    assert not open_points(gl, shaders, bvh, ways, is_software=is_software)[0].any()

"""The G-buffer against rays: positions, normals, visibility of surfaces."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.gbuffer_harness import (
    NORMAL_TOLERANCE,
    SIZE,
    barycentric,
    draw,
    nearest,
    normals,
    rays_of,
)
from passes.pass_harness import DEFAULT_CAMERA, box, make_frame, make_scene, quad, run_pass, sphere

from ssdo_gl import math3d
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material


@pytest.fixture
def shaders(shaders_either_way):
    """What has holes is rasterized either way."""
    return shaders_either_way


# Float32 places a vertex to 6e-8 of its distance from the eye, and the interpolated
# 1 / w adds a few roundings of the largest 1 / w in the picture.
Z_TOLERANCE = 4e-6


# Pixels whose ray passes this close (relative) to an edge may go either way.
EDGE_CLEARANCE = 1e-3


# A GPU places vertices on a grid of this many pixels and interpolates between those places,
# so that a pixel has the depth of a place up to half of it away (OpenGL: GL_SUBPIXEL_BITS,
# 8 where we looked). The software renderer interpolates between the vertices as they are.
SNAP_PX = 2.0**-8


def snapped(device, value_of, rays):
    """Return how much the snapping of vertices may change `value_of` rays through pixels."""
    if device.is_software:
        return 0.0
    step = (
        0.5
        * SNAP_PX
        * np.array([rays[0, 1, 0] - rays[0, 0, 0], rays[1, 0, 1] - rays[0, 0, 1], 0.0])
    )
    shifts = [step * [i, j, 0.0] for i in (-1.0, 1.0) for j in (-1.0, 1.0)]
    return np.max([np.abs(value_of(rays + shift) - value_of(rays)) for shift in shifts], axis=0)


@pytest.mark.parametrize("jitter_px", [(0.0, 0.0), (0.3, -0.45)])
@pytest.mark.parametrize("tilt", [0.0, 60.0, 85.0])
def test_plane(gl, device, shaders, tilt, jitter_px):
    """Depth and normal of every pixel, from facing the camera to grazing."""
    rotation = math3d.rotation_euler([-tilt, 0.0, 0.0])[:3, :3]
    u, v = rotation @ [40.0, 0.0, 0.0], rotation @ [0.0, 40.0, 0.0]
    center = np.array([0.3, -0.2, -4.0])
    scene = make_scene([quad(center - 0.5 * u - 0.5 * v, u, v)])
    frame, images = draw(gl, shaders, scene, jitter_px=jitter_px)
    rays = rays_of(frame)
    n = rotation @ [0.0, 0.0, 1.0]
    wanted = (center @ n) / (rays @ n)
    slack = snapped(device, lambda r: (center @ n) / (r @ n), rays) / wanted
    z = images["z_vs"][..., 0].astype(np.float64)
    seen = z > 0.0
    assert seen.mean() > 0.4
    # At grazing angles a rounding across the plane becomes 1 / cos of it along the ray.
    cosine = np.abs(rays @ n) / np.linalg.norm(rays, axis=-1)
    assert np.all(((np.abs(z / wanted - 1.0) - slack) * cosine)[seen] < Z_TOLERANCE)
    for found in normals(images):
        np.testing.assert_allclose(
            found[seen],
            np.broadcast_to(n, found.shape)[seen],
            atol=2e-7 if tilt == 0.0 else NORMAL_TOLERANCE,
        )
    np.testing.assert_array_equal(images["albedo"][seen][:, 3], 1.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_mesh_against_rays(gl, device, shaders, scale, offset):
    """Depth, face normal and smooth normal of a faceted ball, cast in float64.

    At scale 1e-3 an offset of 1e5 is 1e8 sizes away: float32 could not even tell the
    vertices apart. `offset` is baked into vertices, camera and nothing else.
    """
    offset *= scale
    mesh = sphere(rows=8)
    moved = dataclasses.replace(mesh, positions=mesh.positions * scale + offset)
    position = np.array([1.2, 0.7, 2.4]) * scale + offset
    camera = Camera(tuple(position), (offset, offset, offset), fov_y=60.0)
    frame, images = draw(gl, shaders, make_scene([moved], camera=camera))
    # The same ball at the origin is what the oracle sees.
    view_from_world = frame.view.view_from_world
    corners = (mesh.positions - [1.2, 0.7, 2.4]) @ view_from_world.T
    rays = rays_of(frame).reshape(-1, 3)
    triangles = corners[mesh.triangles]
    distance, index, weights = nearest(rays, triangles)
    seen = np.isfinite(distance)
    z = images["z_vs"].reshape(-1).astype(np.float64)
    firm = weights.min(-1) > EDGE_CLEARANCE
    assert np.count_nonzero(seen & firm) > 500
    assert np.all((z > 0.0)[seen & firm])
    assert np.mean((z > 0.0) != seen) < 1e-3
    both = seen & firm & (z > 0.0)
    # Facets near the silhouette are seen at cosines down to 0.2 or so.
    corner, across = (
        triangles[index, 0],
        np.cross(*(triangles[index, k] - triangles[index, 0] for k in (1, 2))),
    )

    def depth_of(grid):
        return np.sum(corner * across, -1) / np.sum(grid.reshape(-1, 3) * across, -1)

    slack = np.broadcast_to(snapped(device, depth_of, rays_of(frame)), distance.shape)
    gap = np.abs(z[both] / scale - distance[both]) - slack[both]
    assert np.max(gap / distance[both]) < 5.0 * Z_TOLERANCE
    shading, geometric = (image.reshape(-1, 3) for image in normals(images))
    face = mesh.face_normals()[index] @ view_from_world.T
    np.testing.assert_allclose(geometric[both], face[both], atol=NORMAL_TOLERANCE)

    def smooth_normal_of(grid):
        points = grid.reshape(-1, 3) * depth_of(grid)[:, None]
        parts = barycentric(points, *np.moveaxis(triangles[index], 1, 0))
        normal = np.einsum("nk,nki->ni", parts, mesh.normals[mesh.triangles[index]])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True) @ view_from_world.T

    slack = np.broadcast_to(snapped(device, smooth_normal_of, rays_of(frame)), shading.shape)
    gap = np.abs(shading - smooth_normal_of(rays)) - slack
    assert np.max(gap[both]) < NORMAL_TOLERANCE
    # The facing rule of both normals.
    assert np.all((geometric * rays).sum(1)[both] < 0.0)
    assert np.all((geometric * shading).sum(1)[both] > 0.0)


def test_instances_share_a_mesh_but_not_place_and_material(gl, shaders):
    card = quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    left, right = math3d.translation([-1.0, 0.0, -4.0]), math3d.translation([1.0, 0.0, -3.0])
    middle = math3d.translation([0.0, 0.0, -5.0])
    materials = (
        Material(albedo=(0.1, 0.2, 0.3), emission=(4.0, 5.0, 6.0)),
        Material(albedo=(0.9, 0.8, 0.7)),
    )
    objects = [SceneObject(0, 0, np.stack([left, right])), SceneObject(0, 1, middle[None])]
    scene = make_scene([card], materials=materials, objects=objects)
    _, images = draw(gl, shaders, scene)
    z = images["z_vs"][..., 0]
    assert set(np.unique(z)) == {0.0, 3.0, 4.0, 5.0}
    # 16-bit unorm.
    for depth, albedo, emission in (
        (3.0, (0.1, 0.2, 0.3), (4, 5, 6)),
        (4.0, (0.1, 0.2, 0.3), (4, 5, 6)),
        (5.0, (0.9, 0.8, 0.7), (0, 0, 0)),
    ):
        np.testing.assert_allclose(
            images["albedo"][z == depth][:, :3].T,
            np.array(albedo)[:, None] * np.ones((z == depth).sum()),
            atol=1.0 / 65535.0,
        )
        assert np.all(images["emission"][z == depth][:, :3] == emission)
    for name in ("normals_vs", "albedo", "emission"):
        assert np.all(images[name][z == 0.0] == 0.0)


def test_geometry_through_the_eye_and_around_it(gl, device, shaders):
    """Standing on a floor that passes below the eye, inside a closed box."""
    floor = quad((-50.0, -1.0, 50.0), (100.0, 0.0, 0.0), (0.0, 0.0, -100.0))
    frame, images = draw(gl, shaders, make_scene([floor]))
    rays = rays_of(frame)
    down = rays[..., 1] < -1.0 / 45.0
    wanted = -1.0 / rays[..., 1]
    z = images["z_vs"][..., 0]
    slack = np.broadcast_to(snapped(device, lambda r: -1.0 / r[..., 1], rays), z.shape)
    assert np.max((np.abs(z - wanted) - slack)[down] / wanted[down]) < 1e-5
    room = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    _, images = draw(gl, shaders, make_scene([room]))
    reach = 1.0 / np.abs(rays).max(-1)
    np.testing.assert_allclose(images["z_vs"][..., 0], reach, rtol=1e-5)
    # Seen from inside, too, normals point at the camera.
    _, geometric = normals(images)
    assert np.all((geometric * rays).sum(-1) < 0.0)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("position", [(0.0, 0.0, 4.0), (0.2, 0.3, 0.1), (0.0, 0.0, 1.0005)])
def test_hidden_backs_are_not_missed(gl, shaders, mirrored, position):
    """Solids are drawn without the backs that their fronts hide: the buffers are the same.

    From outside, from inside, and from just off a wall; open meshes and bodies that are
    inside out are drawn whole.
    """
    body = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    place = np.diag([-1.0, 1.0, 1.0, 1.0] if mirrored else [1.0] * 4)
    camera = Camera(position, (0.1, 0.0, -0.2), fov_y=70.0)
    found = []
    for mesh in (
        body,
        dataclasses.replace(body, closed=False),
        dataclasses.replace(body, triangles=body.triangles[:, ::-1]),
    ):
        scene = make_scene([mesh], objects=[SceneObject(0, 0, place[None])], camera=camera)
        found.append(draw(gl, shaders, scene)[1])
    assert np.count_nonzero(found[0]["z_vs"]) > 100
    for images in found[1:]:
        for name in ("z_vs", "normals_vs", "albedo"):
            np.testing.assert_array_equal(found[0][name] > 0.0, images[name] > 0.0)
        np.testing.assert_allclose(found[0]["z_vs"], images["z_vs"], rtol=Z_TOLERANCE)


@pytest.mark.parametrize("distance", [1.0, 1e3, 1e5])
def test_the_nearer_of_two_close_surfaces_wins(gl, shaders, distance):
    """Whether drawn first or last, with something at the eye that spoils near / far.

    The cards are 4e-6 of their distance apart: what 24 bits resolve logarithmically.
    """
    gap = 4e-6 * distance
    near_thing = quad((-1e-3, -1e-3, -2e-3), (1e-4, 0, 0), (0, 1e-4, 0))
    cards = [
        quad(
            (-distance, -distance, -distance - i * gap), (2 * distance, 0, 0), (0, 2 * distance, 0)
        )
        for i in range(2)
    ]
    materials = (Material(albedo=(1, 0, 0)), Material(albedo=(0, 1, 0)), Material())
    for order in ((0, 1), (1, 0)):
        objects = [SceneObject(i, i) for i in order] + [SceneObject(2, 2)]
        scene = make_scene([*cards, near_thing], materials=materials, objects=objects)
        _, images = draw(gl, shaders, scene, (32, 24))
        far_part = images["z_vs"][..., 0] > 0.5 * distance
        assert np.all(images["albedo"][far_part][:, 0] == 1.0)


def test_same_bytes_every_time(gl, shaders):
    scene = make_scene([sphere()], camera=Camera((1.0, 0.5, 3.0), (0.0, 0.0, 0.0)))
    _, first = draw(gl, shaders, scene)
    _, second = draw(gl, shaders, scene)
    for name in first:
        np.testing.assert_array_equal(first[name], second[name])


def test_empty_view_is_all_zero(gl, shaders):
    behind = quad((-1.0, -1.0, 5.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    _, images = draw(gl, shaders, make_scene([behind], camera=DEFAULT_CAMERA))
    assert all(np.all(image == 0.0) for image in images.values())


@pytest.mark.parametrize(
    "wanted", [(), ("normals_vs",), ("albedo",), ("emission",), ("emission", "albedo")]
)
def test_targets_that_nobody_reads_are_left_out(gl, shaders, wanted):
    """Each in its own place, whatever is missing before it."""
    lamp = Material(albedo=(0.25, 0.5, 1.0), emission=(3.0, 2.0, 1.0))
    panel = quad((-1, -1, -3), (2, 0, 0.5), (0, 2, 0))
    scene = make_scene([panel], materials=[lamp])
    _, everything = draw(gl, shaders, scene)
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, SIZE, geometry=geometry)
    some = run_pass(gl, shaders, GBufferPass(wanted), frame, geometry=geometry)
    geometry.release()
    assert set(some) == {"z_vs", *wanted}
    for name, image in some.items():
        np.testing.assert_array_equal(image, everything[name])
        assert np.count_nonzero(image) > 0


def test_a_normal_in_the_plane_of_its_face_does_not_flicker(gl, shaders):
    plain = quad((-0.5, -0.5, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    turned = math3d.translation((0.0, 0.0, -2.0)) @ math3d.rotation_euler((23.0, 17.0, 31.0))
    mesh = dataclasses.replace(plain, normals=np.tile([1.0, 0.0, 0.0], (len(plain.positions), 1)))
    item = SceneObject(0, 0, turned[None])
    _, images = draw(gl, shaders, make_scene([mesh], objects=[item]))
    seen = images["z_vs"][..., 0] > 0.0
    shading, _ = normals(images)
    assert np.count_nonzero(seen) > 100
    # The sign of a dot product of 0 would turn single pixels over.
    assert (shading[seen] @ shading[seen][0]).min() > 0.999

"""A small room with everything in it, and the ways to move, scale and mirror scenes."""

from __future__ import annotations

import dataclasses

import numpy as np
from meshes import box, quad

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

RADIUS = 0.5
CAMERA = Camera(position=(1.3, 1.1, 2.4), target=(0.0, 0.35, 0.0), fov_y=45.0)


def sphere(center, radius, rings=8):
    """Return a closed sphere of `rings` bands with smooth normals."""
    theta = np.linspace(0.0, np.pi, rings + 1)[1:-1]
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * rings, endpoint=False)
    around = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.cos(theta), np.ones_like(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
        ],
        axis=2,
    ).reshape(-1, 3)
    normals = np.concatenate([[[0.0, 1.0, 0.0]], around, [[0.0, -1.0, 0.0]]])
    count, last = 2 * rings, len(normals) - 1
    triangles = []
    for i in range(count):
        j = (i + 1) % count
        triangles += [(0, 1 + j, 1 + i), (last, last - count + i, last - count + j)]
        for ring in range(rings - 2):
            a, b = 1 + ring * count, 1 + (ring + 1) * count
            triangles += [(a + i, a + j, b + i), (a + j, b + j, b + i)]
    positions = np.asarray(center, float) + radius * normals
    return Mesh(positions, np.array(triangles), normals=normals, closed=True)


def room(**changes):
    """Return a corner of a room: floor, two walls, a box, a sphere, a pole; every light."""
    meshes = (
        quad((-1, 0, 1.2), (2.4, 0, 0), (0, 0, -2.2)),
        quad((-1, 0, -1), (2.4, 0, 0), (0, 1.6, 0)),
        quad((-1, 0, 1.2), (0, 0, -2.2), (0, 1.6, 0)),
        box((-0.6, 0, -0.6), (-0.1, 0.7, -0.2)),
        sphere((0.45, 0.3, 0.1), 0.3),
        box((0.8, 0, -0.5), (0.84, 1.2, -0.46)),
    )
    colors = [(0.7, 0.7, 0.7), (0.7, 0.2, 0.15), (0.2, 0.6, 0.2), (0.8, 0.8, 0.75)]
    scene = Scene(
        meshes=meshes,
        materials=tuple(Material(albedo=color) for color in colors),
        objects=tuple(SceneObject(i, min(i, 3)) for i in range(len(meshes))),
        camera=CAMERA,
        lights=(
            RectangleLight((-0.3, 1.5, -0.3), (0.6, 0, 0), (0, 0, 0.6), (4, 4, 3.5), visible=False),
            PointLight((0.9, 1.2, 0.8), (0.3, 0.3, 0.4)),
            SpotLight((-0.5, 1.4, 0.9), tuple(math3d.normalized([0.4, -1, -0.6])), (0.5, 0.4, 0.3)),
            DirectionalLight(tuple(math3d.normalized([-0.4, -1, -0.5])), (0.4, 0.4, 0.35)),
            RectangleLight(
                (1.3, 0.2, 1.0),
                (0, 0, -1.2),
                (0, 1.0, 0),
                (0.8, 0.9, 1.2),
                shadow="ssdo",
                visible=False,
            ),
        ),
        environment=ConstantEnvironment((0.35, 0.4, 0.5)),
        render={"radius": RADIUS},
    )
    return dataclasses.replace(scene, **changes)


def transformed(scene, matrix, *, bake=False):
    """Return `scene` moved by a similarity `matrix` (4, 4) so that the image stays the same.

    Lengths, and with them the near-field radius and the intensity of point lights (W/sr
    at a distance), follow the scale of the matrix; radiances stay. A reflection keeps
    the outward side of surfaces.

    Parameters
    ----------
    bake : bool
        Move the vertices instead of the objects' transforms.
    """
    linear = matrix[:3, :3]
    scale = abs(np.linalg.det(linear)) ** (1 / 3)
    mirrored = np.linalg.det(linear) < 0.0

    def point(p):
        return tuple(math3d.transform_points(matrix, p).tolist())

    def vector(v):
        return tuple((linear @ np.asarray(v, float)).tolist())

    def direction(v):
        return tuple(math3d.normalized(linear @ np.asarray(v, float)).tolist())

    def light(item):
        if isinstance(item, RectangleLight):
            edge_u, edge_v = vector(item.edge_u), vector(item.edge_v)
            if mirrored:
                edge_u, edge_v = edge_v, edge_u
            return dataclasses.replace(
                item, corner=point(item.corner), edge_u=edge_u, edge_v=edge_v
            )
        if isinstance(item, DirectionalLight):
            return dataclasses.replace(item, direction=direction(item.direction))
        power = tuple(scale**2 * c for c in item.intensity)
        item = dataclasses.replace(item, position=point(item.position), intensity=power)
        if isinstance(item, SpotLight):
            item = dataclasses.replace(item, direction=direction(item.direction))
        return item

    def mesh(item):
        normals = None if item.normals is None else item.normals @ (linear / scale).T
        triangles = item.triangles[:, ::-1] if mirrored else item.triangles
        return dataclasses.replace(
            item,
            positions=math3d.transform_points(matrix, item.positions),
            triangles=triangles,
            normals=normals,
        )

    camera = dataclasses.replace(
        scene.camera,
        position=point(scene.camera.position),
        target=point(scene.camera.target),
        up=direction(scene.camera.up),
        height=None if scene.camera.height is None else scene.camera.height * scale,
    )
    moved = {
        "meshes": tuple(mesh(m) for m in scene.meshes) if bake else scene.meshes,
        "objects": scene.objects
        if bake
        else tuple(
            dataclasses.replace(o, world_from_object=matrix @ o.world_from_object)
            for o in scene.objects
        ),
    }
    radius = scene.render.get("radius")
    render = {**scene.render} if radius is None else {**scene.render, "radius": radius * scale}
    return dataclasses.replace(
        scene, camera=camera, lights=tuple(map(light, scene.lights)), render=render, **moved
    )

"""Runs one pass on hand-made textures or on a small scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl
import numpy as np
from gpu.image_texture import texture_from_image
from meshes import box as box
from meshes import quad as quad
from numpy.typing import ArrayLike, NDArray

from ssdo_gl.gpu.geometry import CameraPose, Geometry
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.graph.frame import Frame, FrameView
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import Environment
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

Array = NDArray[np.float32]
DEFAULT_CAMERA = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), fov_y=60.0)
# The dtypes that the frame graph gives to resources which are not plain f4.
STORED_AS = {"normals_vs": "nu2", "albedo": "nu2", "display": "nu2"}


def make_scene(
    meshes: Sequence[Mesh] = (),
    *,
    materials: Sequence[Material] = (Material(),),
    objects: Sequence[SceneObject] | None = None,
    lights: Sequence[Light] = (),
    environment: Environment | None = None,
    camera: Camera = DEFAULT_CAMERA,
) -> Scene:
    """Return a scene; without `objects`, each mesh once, with the first material."""
    if objects is None:
        objects = [SceneObject(i, 0) for i in range(len(meshes))]
    return Scene(
        tuple(meshes), tuple(materials), tuple(objects), camera, tuple(lights), environment
    )


def sphere(rows=12, radius=1.0, smooth=True, **more):
    """A lat-long sphere about the origin."""
    polar = np.linspace(0.0, np.pi, rows + 1)
    azimuth = np.linspace(0.0, 2.0 * np.pi, 2 * rows, endpoint=False)
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    points = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], -1)
    points = points.reshape(-1, 3)
    triangles = []
    for i in range(rows):
        for j in range(2 * rows):
            k = (j + 1) % (2 * rows)
            a, b = i * 2 * rows + j, i * 2 * rows + k
            c, d = a + 2 * rows, b + 2 * rows
            triangles += ([(a, b, d)] if i > 0 else []) + ([(a, d, c)] if i < rows - 1 else [])
    return Mesh(
        points * radius,
        np.array(triangles),
        normals=points.copy() if smooth else None,
        closed=True,
        **more,
    )


def make_frame(
    scene: Scene,
    size: tuple[int, int] = (64, 48),
    *,
    near_far: tuple[float, float] | None = None,
    geometry: Geometry | None = None,
    jitter_px: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
) -> Frame:
    """Return the frame that the scene's camera sees.

    The clip distances come from `geometry` if given, else from `near_far`, else they
    are (0.01, 100).
    """
    camera = scene.camera
    position = np.array(camera.position, np.float64)
    rotation = camera.view_from_world_rotation()
    tan_half_fov = camera.tan_half_fov(size[0] / size[1])
    if near_far is None and geometry is not None:
        near_far = geometry.near_far(CameraPose(position, rotation), tan_half_fov)
    near, far = near_far or (0.01, 100.0)
    view = FrameView(size, position, rotation, tan_half_fov, near, far, jitter_px)
    return Frame(view, scene, seed)


def run_pass(
    gl: moderngl.Context,
    shaders: ShaderLibrary,
    render_pass: RenderPass,
    frame: Frame,
    inputs: Mapping[str, ArrayLike | moderngl.Texture] | None = None,
    geometry: Geometry | None = None,
) -> dict[str, Array]:
    """Run `render_pass` and return what it wrote, (height, width, channels), top row first.

    Parameters
    ----------
    inputs : mapping
        For each resource in ``reads`` an array in the same layout, or a texture.
    geometry : Geometry, optional
        Built from ``frame.scene`` and released again if not given.
    """
    textures = {
        name: value
        if isinstance(value, moderngl.Texture)
        else texture_from_image(gl, value, STORED_AS.get(name, "f4"))
        for name, value in (inputs or {}).items()
    }
    written = {
        name: make_texture(gl, spec.size(frame.view.size), spec.components, spec.dtype)
        for name, spec in render_pass.writes.items()
        if not spec.own
    }
    used = geometry or Geometry(gl, frame.scene)
    target = None
    if written:
        target = make_framebuffer(gl, list(written.values()), render_pass.needs_depth)
        target.use()
        target.viewport = (0, 0, *target.size)
        target.clear(*((1e3,) * 4 if render_pass.overwrites else ()))
    context = PassContext(
        gl, shaders, used, frame, {name: textures[name] for name in render_pass.reads}, target
    )
    own = render_pass.execute(context) or {}
    results = {name: read_texture(texture) for name, texture in {**written, **own}.items()}
    if target is not None:
        target.release()
    made = [t for name, t in textures.items() if t is not (inputs or {})[name]]
    for texture in [*written.values(), *made]:
        texture.release()
    if geometry is None:
        used.release()
    return results

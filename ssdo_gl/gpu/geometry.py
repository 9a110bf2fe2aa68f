"""The scene's triangles on the device, and how any pass draws them.

Knows transforms and materials as data, nothing of lighting. Vertices are stored
relative to the centre of their mesh and placed relative to the eye in float64, so
that neither a mesh baked at 1e5 nor a camera out there costs precision: float32
holds small numbers only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.draw_group import (
    INSTANCE_ATTRIBUTES,
    INSTANCE_FLOATS,
    DrawGroup,
    Features,
    features_of,
    grouped,
    material_row,
)
from ssdo_gl.gpu.material_textures import MaterialTextures
from ssdo_gl.gpu.shader import Program
from ssdo_gl.gpu.vertices import VertexStreams, vertex_streams
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.mesh import Mesh
from ssdo_gl.scene.scene import Scene

# Geometry nearer than this fraction of the farthest visible bound is cut off: a
# clip plane must lie somewhere in front of the eye, and a millionth of the view is
# below what a picture shows.
NEAREST_CLIP_RATIO = 1e-6
# The clip planes keep this distance (relative) from the bounds, far above float32
# rounding of the projection (1e-7) and far below what depth precision would notice.
CLIP_MARGIN = 1e-3


class Viewpoint(Protocol):
    """An eye somewhere in the world; `graph.frame.FrameView` is one."""

    @property
    def position_ws(self) -> FloatArray:
        """World-space position, shape (3,)."""

    @property
    def view_from_world(self) -> FloatArray:
        """Rotation, shape (3, 3)."""


@dataclass(frozen=True)
class Eye:
    """The plainest `Viewpoint`: a light, or a face of its shadow map."""

    position_ws: FloatArray
    view_from_world: FloatArray


class Geometry:
    """Vertex buffers of a scene and the draw calls over them.

    Parameters
    ----------
    gl : moderngl.Context
    scene : Scene
    """

    def __init__(self, gl: moderngl.Context, scene: Scene) -> None:
        self._gl = gl
        self._textures = MaterialTextures(gl)
        # The mesh is kept with its streams so that its id stays taken.
        self._streams: dict[int, tuple[Mesh, VertexStreams]] = {}
        self._groups: list[DrawGroup] = []
        self.update(scene)

    @property
    def has_solids(self) -> bool:
        """Whether any mesh bounds a solid, so that its back faces tell a thickness."""
        return any(group.is_solid for group in self._groups)

    @property
    def draw_call_count(self) -> int:
        """Number of draw calls of a view that sees everything."""
        return len(self._groups)

    def update(self, scene: Scene) -> None:
        """Take over transforms and materials of `scene`; upload only new meshes."""
        self._release_groups()
        kept = {id(mesh) for mesh in scene.meshes}
        for key in [key for key in self._streams if key not in kept]:
            self._streams.pop(key)[1].release()
        self._textures.keep(scene.materials)
        for members in grouped(scene):
            self._groups.append(self._make_group(scene, members))

    def release(self) -> None:
        """Free every device object."""
        self._release_groups()
        for _, streams in self._streams.values():
            streams.release()
        self._streams.clear()
        self._textures.keep(())

    def draw(
        self,
        viewpoint: Viewpoint,
        clip_from_view: FloatArray,
        program_of: Callable[[Features], Program],
        uniforms: Mapping[str, object],
        *,
        solids_only: bool = False,
        skip_light: int | None = None,
    ) -> None:
        """Draw what lies inside the clip volume into the bound framebuffer.

        With face culling enabled, the front is the outside of the mesh, for mirrored
        instances too.

        Parameters
        ----------
        viewpoint : Viewpoint
            What positions are made relative to, in float64.
        clip_from_view : ndarray, shape (4, 4)
            Projection; passed on as ``u_clip_from_view``.
        program_of : callable
            Returns the program for what a group of objects needs. Attributes that
            the program does not use are left out.
        uniforms : mapping
            Set once on each program used.
        solids_only : bool
            Leave out what bounds no solid: open meshes and those with cut-outs.
        skip_light : int or None
            Leave out the visible body of this light (an index into Scene.lights).
        """
        prepared: set[Program] = set()
        common = {**uniforms, "u_clip_from_view": clip_from_view}
        for group in self._groups:
            if solids_only and not group.is_solid:
                continue
            mirrored, packed = self._visible_instances(group, viewpoint, clip_from_view, skip_light)
            if len(packed) == 0:
                continue
            program = program_of(group.features)
            if program not in prepared:
                program.set(common)
                prepared.add(program)
            program.set({}, {n: t for n, t in group.textures.items() if n in program.gl})
            program.check_complete()
            for winding, chosen in (("ccw", packed[~mirrored]), ("cw", packed[mirrored])):
                if len(chosen) > 0:
                    self._gl.front_face = winding
                    group.instances.orphan()
                    group.instances.write(chosen)
                    self._vertex_array(group, program).render(instances=len(chosen))
        self._gl.front_face = "ccw"

    def bounds_along(self, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return corners (low, high) of all instances in a rotated world frame.

        Parameters
        ----------
        axes : ndarray, shape (3, 3)
            The frame's axes as rows.

        Returns
        -------
        low, high : ndarray, shape (3,)
            Zeros if there are no objects.
        """
        eye = Eye(np.zeros(3), axes)
        boxes = [
            _bounds(_view_from(eye, group.world_from_mesh), group.vertices.half_extent)
            for group in self._groups
        ]
        if not boxes:
            return np.zeros(3), np.zeros(3)
        low = np.min([(center - half).min(axis=0) for center, half in boxes], axis=0)
        high = np.max([(center + half).max(axis=0) for center, half in boxes], axis=0)
        return low, high

    def near_far(
        self,
        viewpoint: Viewpoint,
        tan_half_fov: tuple[float, float],
        *,
        skip_light: int | None = None,
    ) -> tuple[float, float]:
        """Return clip distances (near, far) that enclose all that `viewpoint` can see.

        They follow the bounds of the visible instances. Where the eye is inside
        one, `near` is `NEAREST_CLIP_RATIO` of `far`. If nothing is visible, any pair
        is right and (0.5, 1) is returned.
        """
        x, y = tan_half_fov
        sides = np.array([[1, 0, -x, 0], [-1, 0, -x, 0], [0, 1, -y, 0], [0, -1, -y, 0]])
        # A jittered frame sees up to a pixel more; a hundredth of the field of view
        # covers that for frames of 100 pixels and more, at no cost.
        sides[:, 2] *= 1.01
        nearest, farthest = np.inf, 0.0
        for group in self._groups:
            view_from_mesh = _view_from(viewpoint, group.world_from_mesh)
            center, half = _bounds(view_from_mesh, group.vertices.half_extent)
            seen = _inside(sides, center, half) & (half[:, 2] - center[:, 2] > 0.0)
            seen &= _not_of(skip_light, group.lights)
            if np.any(seen):
                nearest = min(nearest, float((-center[seen, 2] - half[seen, 2]).min()))
                farthest = max(farthest, float((-center[seen, 2] + half[seen, 2]).max()))
        if farthest == 0.0:
            return 0.5, 1.0
        far = farthest * (1.0 + CLIP_MARGIN)
        near = max(nearest * (1.0 - CLIP_MARGIN), far * NEAREST_CLIP_RATIO)
        return near, far

    def _make_group(self, scene: Scene, members: Sequence[int]) -> DrawGroup:
        first = scene.objects[members[0]]
        mesh, material = scene.meshes[first.mesh], scene.materials[first.material]
        if id(mesh) not in self._streams:
            self._streams[id(mesh)] = mesh, vertex_streams(self._gl, mesh)
        streams = self._streams[id(mesh)][1]
        world_from_mesh = np.concatenate(
            [scene.objects[i].world_from_object for i in members]
        ).copy()
        world_from_mesh[:, :3, 3] += world_from_mesh[:, :3, :3] @ streams.center
        rows, owners = [], []
        for i in members:
            item = scene.objects[i]
            count = len(item.world_from_object)
            row = material_row(scene.materials[item.material], item.light is None)
            rows.append(np.broadcast_to(row, (count, len(row))))
            owners.append(np.full(count, -1 if item.light is None else item.light))
        features = features_of(mesh, material)
        textures = {}
        if features.albedo_texture and material.albedo_texture is not None:
            textures["t_albedo"] = self._textures.get(material.albedo_texture)
        if features.emission_texture and material.emission_texture is not None:
            textures["t_emission"] = self._textures.get(material.emission_texture)
        count = len(world_from_mesh)
        return DrawGroup(
            mesh,
            streams,
            features,
            textures,
            world_from_mesh,
            np.concatenate(rows).astype(np.float32),
            np.concatenate(owners),
            self._gl.buffer(reserve=count * INSTANCE_FLOATS * 4, dynamic=True),
        )

    def _visible_instances(
        self,
        group: DrawGroup,
        viewpoint: Viewpoint,
        clip_from_view: FloatArray,
        skip_light: int | None,
    ) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
        """Return whether each visible instance is mirrored, and its attributes."""
        view_from_mesh = _view_from(viewpoint, group.world_from_mesh)
        center, half = _bounds(view_from_mesh, group.vertices.half_extent)
        planes = np.concatenate(
            [clip_from_view[3] + clip_from_view[:3], clip_from_view[3] - clip_from_view[:3]]
        )
        seen = _inside(planes, center, half)
        seen &= _not_of(skip_light, group.lights)
        count = int(np.count_nonzero(seen))
        packed = np.empty((count, INSTANCE_FLOATS), np.float32)
        packed[:, :12] = view_from_mesh[seen].reshape(count, 12)
        packed[:, 12:] = group.materials[seen]
        return np.linalg.det(view_from_mesh[seen, :, :3]) < 0.0, packed

    def _vertex_array(self, group: DrawGroup, program: Program) -> moderngl.VertexArray:
        # Keyed by the Program, compared with its `gl`: a reload replaces the latter.
        known = group.vertex_arrays.get(program)
        if known is None or known.program is not program.gl:
            content: list[tuple[object, ...]] = [
                (buffer, f"{count}f", name)
                for name, (buffer, count) in group.vertices.buffers.items()
                if name in program.gl
            ]
            used = [(name, n) for name, n in INSTANCE_ATTRIBUTES if name in program.gl]
            layout = " ".join(
                f"{n}f" if name in program.gl else f"{4 * n}x" for name, n in INSTANCE_ATTRIBUTES
            )
            content.append((group.instances, f"{layout}/i", *(name for name, _ in used)))
            known = self._gl.vertex_array(program.gl, content, index_buffer=group.vertices.indices)
            group.vertex_arrays[program] = known
        return known

    def _release_groups(self) -> None:
        for group in self._groups:
            for array in group.vertex_arrays.values():
                array.release()
            group.instances.release()
        self._groups.clear()


def _view_from(viewpoint: Viewpoint, world_from_mesh: FloatArray) -> FloatArray:
    """Return (N, 3, 4) view_from_mesh; the eye is subtracted in float64."""
    relative = world_from_mesh[:, :3, :].copy()
    relative[:, :, 3] -= viewpoint.position_ws
    return np.asarray(viewpoint.view_from_world @ relative)


def _bounds(view_from_mesh: FloatArray, half_extent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return centres and half sizes (N, 3) of the view-space boxes of instances."""
    return view_from_mesh[:, :, 3], np.abs(view_from_mesh[:, :, :3]) @ half_extent


def _not_of(light: int | None, lights: NDArray[np.int64]) -> NDArray[np.bool_] | bool:
    return True if light is None else np.asarray(lights != light)


def _inside(planes: FloatArray, center: FloatArray, half: FloatArray) -> NDArray[np.bool_]:
    """Return which boxes reach the positive side of every plane (P, 4)."""
    distance = center @ planes[:, :3].T + planes[:, 3]
    reach = half @ np.abs(planes[:, :3]).T
    return np.asarray(np.all(distance + reach >= 0.0, axis=1))

"""The scene's triangles on the device, and how any pass draws them.

Knows transforms and materials as data, nothing of lighting. Vertices are stored
relative to the centre of their mesh and placed relative to the eye in float64, so
that neither a mesh baked at 1e5 nor a camera out there costs precision: float32
holds small numbers only.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.gpu.geometry.draw_group import DrawGroup, Features, features_of, grouped
from ssdo_gl.gpu.geometry.instances import (
    Batch,
    Boxes,
    CameraPose,
    Instances,
    Viewpoint,
    Visible,
    gather,
)
from ssdo_gl.gpu.geometry.material_textures import MaterialTextures
from ssdo_gl.gpu.geometry.vertices import VertexStreams, vertex_streams
from ssdo_gl.gpu.instance_attributes import INSTANCE_ATTRIBUTES, INSTANCE_FLOATS
from ssdo_gl.gpu.program import Program
from ssdo_gl.last_made import LastMade
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

# Views of which what shows is remembered: two passes and the next frame ask for the same.
MOST_KNOWN = 64

Found = TypeVar("Found")

__all__ = ["CameraPose", "Geometry", "Viewpoint"]


class Numbered(NamedTuple):
    """Triangles of a batch that shows, by consecutive numbers from `first` on.

    `is_mirrored`: their fronts run clockwise in this view.
    """

    group: DrawGroup
    batch: Batch
    features: Features
    visible: Visible
    first: int
    is_mirrored: bool


class Geometry:
    """Vertex buffers of a scene and the draw calls over them."""

    def __init__(self, gl: moderngl.Context, scene: Scene) -> None:
        self._gl = gl
        self._textures = MaterialTextures(gl)
        # The mesh is kept with its streams so that its id stays taken.
        self._streams: dict[int, tuple[Mesh, VertexStreams]] = {}
        self._groups: list[DrawGroup] = []
        self._known: dict[Hashable, Any] = {}
        self._last_boxes: LastMade[Boxes] = LastMade()
        self.update(scene)

    def update(self, scene: Scene) -> None:
        """Take over transforms and materials of `scene`; upload only new meshes."""
        members = grouped(scene)
        kept = {id(mesh) for mesh in scene.meshes}
        old = {group.key: group for group in self._groups}
        self._groups = [self._group(scene, indices, old) for indices in members]
        for group in old.values():
            group.release()
        for key in [key for key in self._streams if key not in kept]:
            self._streams.pop(key)[1].release()
        self._textures.keep(scene.materials)
        self._instances = gather(scene, members, [group.vertices.center for group in self._groups])
        # Equal ones are the same object, so that draws need not compare them.
        same: dict[Features, Features] = {}
        self._batches = [
            (batch, same.setdefault(features, features))
            for batch, features in map(self._with_features, self._instances.batches)
        ]
        self._known.clear()

    @property
    def instances(self) -> Instances:
        """Where everything stands; another object after each `update`."""
        return self._instances

    def release(self) -> None:
        """Free every device object."""
        for group in self._groups:
            group.release()
        self._groups.clear()
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
        hide_backs: bool = False,
        emitting: bool | None = None,
        by_chance: bool | None = None,
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
            Leave out what bounds no solid: open meshes and those with cut-outs. Backs of
            single-sided surfaces are drawn only then.
        hide_backs : bool
            Leave out back faces of solids that the eye is outside of: their fronts hide
            them. Face culling must not be in use otherwise.
        emitting, by_chance : bool or None
            Draw only what emits, or is translucent, or only what does not.
        skip_light : int or None
            Leave out the visible body of this light (an index into Scene.lights).
        """
        programs: dict[int, Program] = {}
        common = {**uniforms, "u_clip_from_view": clip_from_view}
        is_reflection, visible = self._visible(viewpoint, clip_from_view, skip_light)
        for (batch, features), shown in zip(self._batches, visible, strict=True):
            group = self._groups[batch.group]
            if len(shown.attributes) == 0 or (solids_only and not group.is_solid):
                continue
            if emitting not in (None, features.emits):
                continue
            if by_chance not in (None, features.by_chance):
                continue
            program = programs.get(id(features))
            if program is None:
                program = programs[id(features)] = program_of(features)
                program.set(common)
            program.set({}, {n: t for n, t in group.textures.items() if program.takes(n)})
            program.check_complete()
            self._gl.front_face = "cw" if batch.is_mirrored != is_reflection else "ccw"
            if features.single_sided and not solids_only:
                self._render(group, program, shown.attributes, fronts_only=True)
            elif hide_backs and group.is_solid:
                self._render(group, program, shown.around)
                self._render(group, program, shown.others, fronts_only=True)
            else:
                self._render(group, program, shown.attributes)
        self._gl.front_face = "ccw"

    def shows_by_chance(
        self, viewpoint: Viewpoint, clip_from_view: FloatArray, skip_light: int | None
    ) -> bool:
        """Return whether anything translucent may lie inside the clip volume."""
        _, visible = self._visible(viewpoint, clip_from_view, skip_light)
        return any(
            batch.by_chance and len(shown.attributes) > 0
            for (batch, _), shown in zip(self._batches, visible, strict=True)
        )

    def visible_triangles(
        self, viewpoint: Viewpoint, clip_from_view: FloatArray
    ) -> Sequence[Numbered]:
        """Return the triangles of all batches that show, numbered from 1."""
        first, found = 1, []
        is_reflection, visible = self._visible(viewpoint, clip_from_view, None)
        for (batch, features), shown in zip(self._batches, visible, strict=True):
            if len(shown.attributes) > 0:
                group = self._groups[batch.group]
                is_mirrored = batch.is_mirrored != is_reflection
                found.append(Numbered(group, batch, features, shown, first, is_mirrored))
                first += group.vertices.triangle_count * len(shown.attributes)
        return found

    def _visible(
        self, viewpoint: Viewpoint, clip_from_view: FloatArray, skip_light: int | None
    ) -> tuple[bool, list[Visible]]:
        """Return whether the view is a mirror image, and what shows of each batch."""
        return self._once(
            (_key(viewpoint), clip_from_view.tobytes(), skip_light),
            lambda: (
                math3d.is_reflection(viewpoint.view_from_world),
                self._instances.visible(self._boxes(viewpoint), clip_from_view, skip_light),
            ),
        )

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
        return self._once(axes.tobytes(), lambda: self._instances.bounds_along(axes))

    def near_far(
        self,
        viewpoint: Viewpoint,
        tan_half_fov: tuple[float, float],
        *,
        skip_light: int | None = None,
    ) -> tuple[float, float]:
        """Return clip distances (near, far) that enclose all that `viewpoint` can see.

        They follow the bounds of the visible instances. Where the eye is inside
        one, `near` is `instances.NEAREST_CLIP_RATIO` of `far`. If nothing is visible,
        any pair is right and (0.5, 1) is returned.
        """
        return self._once(
            (_key(viewpoint), tan_half_fov, skip_light),
            lambda: self._instances.near_far(self._boxes(viewpoint), tan_half_fov, skip_light),
        )

    def _boxes(self, viewpoint: Viewpoint) -> Boxes:
        """Return the boxes of the instances as one viewpoint sees them, the last one's kept."""
        made_from = self._instances, viewpoint.position_ws, viewpoint.view_from_world
        return self._last_boxes.get(made_from, lambda: self._instances.boxes(viewpoint))

    def _once(self, key: Hashable, look_up: Callable[[], Found]) -> Found:
        """Return what is known of the instances as they stand, looked up the first time."""
        if key not in self._known:
            if len(self._known) >= MOST_KNOWN:
                self._known.clear()
            self._known[key] = look_up()
        found: Found = self._known[key]
        return found

    def depth_bounds(
        self, viewpoint: Viewpoint, half_frame: tuple[float, float]
    ) -> tuple[float, float] | None:
        """Return between which depths the boxes lie that parallel rays from a frame meet.

        Parameters
        ----------
        half_frame : (float, float)
            Half its width and height, scene units.
        """
        boxes = self._boxes(viewpoint)
        return self._instances.depth_bounds(boxes, (0.0, 0.0), half_frame, None)

    def _group(
        self, scene: Scene, members: Sequence[int], old: dict[object, DrawGroup]
    ) -> DrawGroup:
        """Return the draw group of these objects, taken from `old` if it is there."""
        first = scene.objects[members[0]]
        mesh, material = scene.meshes[first.mesh], scene.materials[first.material]
        if id(mesh) not in self._streams:
            self._streams[id(mesh)] = mesh, vertex_streams(self._gl, mesh)
        features = features_of(mesh, material)
        textures = {
            f"t_{name}_image": self._textures.get(
                texture,
                _cutoff_of_image(material) if name == "albedo" else None,
                is_normals=name == "normal" and material.is_glossy,
            )
            for name, texture in material.textures.items()
            if name in features.images
        }
        count = sum(len(scene.objects[i].world_from_object) for i in members)
        streams = self._streams[id(mesh)][1]
        images = tuple(texture.glo for texture in textures.values())
        key = (id(mesh), features, images, count)
        if key in old:
            return old.pop(key)
        buffer = self._gl.buffer(reserve=count * INSTANCE_FLOATS * 4, dynamic=True)
        return DrawGroup(key, mesh, streams, features, textures, buffer)

    def _with_features(self, batch: Batch) -> tuple[Batch, Features]:
        features = self._groups[batch.group].features
        return batch, replace(features, emits=batch.emits, by_chance=batch.by_chance)

    def _render(
        self,
        group: DrawGroup,
        program: Program,
        attributes: NDArray[np.float32],
        *,
        fronts_only: bool = False,
    ) -> None:
        if len(attributes) == 0:
            return
        # Keyed by the Program, compared with its `gl`: a reload replaces the latter.
        known = group.vertex_arrays.get(program)
        if known is None or known.program is not program.gl:
            content: list[tuple[object, ...]] = [
                (buffer, f"{count}f", name)
                for name, (buffer, count) in group.vertices.buffers.items()
                if program.takes(name)
            ]
            used = [name for name, _ in INSTANCE_ATTRIBUTES if program.takes(name)]
            layout = " ".join(
                f"{n}f" if program.takes(name) else f"{4 * n}x" for name, n in INSTANCE_ATTRIBUTES
            )
            content.append((group.instances, f"{layout}/i", *used))
            known = self._gl.vertex_array(program.gl, content, index_buffer=group.vertices.indices)
            group.vertex_arrays[program] = known
        if group.attributes is not attributes:
            group.hold(attributes)
        if fronts_only:
            self._gl.enable(moderngl.CULL_FACE)
            self._gl.cull_face = "back"
        known.render(instances=len(attributes))
        if fronts_only:
            self._gl.disable(moderngl.CULL_FACE)


def _key(viewpoint: Viewpoint) -> Hashable:
    return viewpoint.position_ws.tobytes(), viewpoint.view_from_world.tobytes()


def _cutoff_of_image(material: Material) -> float | None:
    """Return the alpha below which an image's texels are cut out, if any may be."""
    if material.alpha_cutoff is None or material.alpha <= material.alpha_cutoff:
        return None
    return material.alpha_cutoff / material.alpha

"""Scenes made in Python: of arrays, by adding parts, by changing some of them. Pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.builder import SceneBuilder
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import Environment
from ssdo_gl.scene.geometry import Mesh, SceneObject, are_mirrored
from ssdo_gl.scene.light_edits import with_lights
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene_data import SceneData, SceneKind
from ssdo_gl.scene.scene_error import SceneError, a_type, check_type
from ssdo_gl.scene.trimesh_parts import Part, trimesh_parts, undrawn
from ssdo_gl.settings.fields import shown
from ssdo_gl.settings.loading import LoadOptions
from ssdo_gl.wording import suggestion

# What messages call a scene that is in no file.
SOURCE = "scene"


def matrices_of(transform: ArrayLike | None) -> FloatArray:
    """Return one or more affine matrices as (N, 4, 4)."""
    if transform is None:
        return np.eye(4)[None]
    matrices = np.asarray(transform, dtype=np.float64)
    matrices = matrices[None] if matrices.ndim == 2 else matrices
    is_affine = matrices.ndim == 3 and matrices.shape[1:] == (4, 4) and len(matrices) > 0
    if not is_affine or not np.allclose(matrices[:, 3], (0.0, 0.0, 0.0, 1.0)):
        raise SceneError(
            "transform: expected affine matrices, (4, 4) or (N, 4, 4), got shape "
            f"{np.shape(transform)}" + (" with another last row than 0 0 0 1" if is_affine else "")
        )
    if not np.isfinite(matrices).all() or not np.linalg.det(matrices[:, :3, :3]).all():
        raise SceneError("transform: expected finite matrices that have an inverse")
    return matrices


def composed(
    kind: type[SceneKind],
    parts: Sequence[Part],
    camera: Camera | None,
    lights: Iterable[Light],
    environment: Environment | None,
    render: Mapping[str, Any] | None,
    title: str,
    notes: Iterable[str] = (),
) -> SceneKind:
    """Return a scene of parts; light and camera are added where there are none."""
    if not isinstance(lights, Iterable):
        raise SceneError(f"lights: expected a list of lights, got {a_type(lights)}")
    if environment is not None:
        check_type("environment", environment, get_args(Environment), "environment")
    if render is not None:
        check_type("render", render, Mapping, "mapping")
    lights = tuple(lights)
    is_lit = bool(lights) or environment is not None
    options = LoadOptions(light="file" if is_lit else "auto", is_bare=True)
    builder = SceneBuilder(SOURCE, options, notes=list(notes), joins=False)
    _add(builder, parts, lights)
    if camera is not None:
        check_type("camera", camera, Camera)
    exposure = None if camera is None else camera.exposure
    return builder.build(kind, camera, environment, exposure=exposure, render=render, title=title)


def extended(
    scene: SceneKind, parts: Sequence[Part], lights: Sequence[Light], notes: Iterable[str]
) -> SceneKind:
    """Return `scene` with more in it, `notes` first of its notes.

    A camera that was chosen to frame the scene frames what it is now, and light that was
    added for want of any yields to `lights`.
    """
    # The light of a studio, or of a map, stays as it is.
    is_chosen = scene.loading.replaces_light
    drops = bool(lights) or not is_chosen
    loading = scene.loading
    if lights or is_chosen:
        loading = dataclasses.replace(loading, light="file")
    kept = scene.lights[: len(scene.lights) - scene.added_light_count] if drops else scene.lights
    builder = SceneBuilder(
        SOURCE,
        dataclasses.replace(loading, is_bare=not scene.has_ground, frames_all=False),
        meshes=list(scene.meshes),
        materials=list(scene.materials),
        objects=[item for item in scene.objects if not item.is_ground],
        lights=list(kept),
        notes=list(dict.fromkeys(notes)),
        joins=False,
    )
    _add(builder, parts, lights)
    camera = scene.camera
    built = builder.build(
        type(scene),
        None if scene.is_framed else camera,
        None if drops and scene.has_added_sky else scene.environment,
        exposure=camera.exposure if scene.metering_slack is None else None,
        fov_y=camera.fov_y,
        height=None if camera.height is None else 0.0,
    )
    return dataclasses.replace(
        built,
        camera_motion=scene.camera_motion,
        cameras=scene.cameras,
        render={**built.render, **scene.render},
        title=scene.title,
        purpose=scene.purpose,
        loading=loading,
        reach=scene.reach,
    )


def parts_of(
    item: object, material: Material | None, transform: ArrayLike | None, name: str
) -> list[Part]:
    """Return the parts of a mesh, of a scene, or of an object of trimesh."""
    matrices = matrices_of(transform)
    if material is not None:
        check_type("material", material, Material)
    if isinstance(item, Mesh):
        if item.fault:
            raise SceneError(item.fault)
        return [Part(item, material or Material(), matrices, name or item.name)]
    if isinstance(item, SceneData):
        parts = [_part_of_scene(item, part) for part in item.objects if not part.is_ground]
    elif _is_of_trimesh(item):
        parts = trimesh_parts(item)
    else:
        raise SceneError(
            f"add: expected a Mesh, a light, a Scene or an object of trimesh, got {a_type(item)}"
        )
    return [
        Part(
            part.mesh,
            material or part.material,
            (matrices[:, None] @ part.world_from_object[None]).reshape(-1, 4, 4),
            name or part.name,
        )
        for part in parts
    ]


def _is_of_trimesh(item: object) -> bool:
    return type(item).__module__.partition(".")[0] == "trimesh"


def notes_of(item: object) -> Sequence[str]:
    """Return what is to be said of an item that is added: what of it is not drawn as it asks."""
    if isinstance(item, SceneData):
        return item.notes[: item.read_note_count]
    return undrawn(item) if _is_of_trimesh(item) else ()


def _part_of_scene(scene: SceneData, item: SceneObject) -> Part:
    mesh = scene.meshes[item.mesh]
    if item.motion is not None or mesh.pose is not None:
        raise SceneError(f"add: {item.name or 'an object'} of the scene moves: it cannot be placed")
    return Part(mesh, scene.materials[item.material], item.world_from_object, item.name)


def _add(builder: SceneBuilder, parts: Sequence[Part], lights: Iterable[Light]) -> None:
    for part in parts:
        mesh = _index(builder.meshes, part.mesh)
        material = _index(builder.materials, part.material)
        builder.add(SceneObject(mesh, material, part.world_from_object, name=part.name))
    for light in lights:
        check_type("lights", light, Light, "light")
        builder.add_light(light)


def _index(items: list[Any], item: Any) -> int:
    """Return where the very same `item` is in a list; at its end if it was not there."""
    for index, other in enumerate(items):
        if other is item:
            return index
    items.append(item)
    return len(items) - 1


def index_of(items: Sequence[Any], which: int | str, what: str) -> int:
    """Return the index of what is named, or numbered, `which`; raises SceneError."""
    names = [item.name for item in items]
    if isinstance(which, str):
        found = [index for index, name in enumerate(names) if name == which]
        if len(found) == 1:
            return found[0]
        known = suggestion(which, [name for name in names if name])
        fault = f"{len(found)} are called so: give an index" if found else f"there is none{known}"
        raise SceneError(f"{what} {shown(which)}: {fault}")
    if not 0 <= which < len(items):
        raise SceneError(f"{what} {which}: expected an index from 0 to {len(items) - 1}, or a name")
    return which


def with_object(
    scene: SceneKind, which: int | str, transform: ArrayLike | None, material: Material | None
) -> SceneKind:
    """Return the scene with an object placed elsewhere, or of another material."""
    index = index_of(scene.objects, which, "object")
    item = scene.objects[index]
    objects, materials = list(scene.objects), list(scene.materials)
    if transform is not None:
        matrices = matrices_of(transform)
        if are_mirrored(matrices).any():
            raise SceneError("transform: it mirrors; add the object mirrored, then move it")
        item = dataclasses.replace(item, world_from_object=matrices)
    if material is not None:
        check_type("material", material, Material)
        if item.light is not None or material.emits:
            raise SceneError(
                f"object {shown(which)}: what emits has lights: add it to a scene anew"
            )
        item = dataclasses.replace(item, material=_index(materials, material))
    objects[index] = item
    return dataclasses.replace(scene, objects=tuple(objects), materials=tuple(materials))


def with_light(scene: SceneKind, which: int | str, light: Light) -> SceneKind:
    """Return the scene with another light in the place of one of the same kind."""
    index = index_of(scene.lights, which, "light")
    check_type(f"light {shown(which)}", light, type(scene.lights[index]))
    lights = [light if number == index else old for number, old in enumerate(scene.lights)]
    return with_lights(scene, lights, [True] * len(lights))

"""Changes the lights of a scene together with the bodies that are seen of them. Pure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import SceneObject
from ssdo_gl.scene.light_bodies import body_lights
from ssdo_gl.scene.lights import BLACK, Form, Light
from ssdo_gl.scene.scene_data import SceneData, SceneKind

# Edge of a new light with an area, as a part of how far it is from the eye.
NEW_EDGE = 0.25


def with_lights(original: SceneKind, lights: Sequence[Light], on: Sequence[bool]) -> SceneKind:
    """Return `original` with its lights replaced by `lights`, dark where not `on`.

    The body that stands for a rectangle light in the picture follows it: it moves and turns
    by as much, and its emission changes by the same factors. One that several lights stand
    for follows the first, and glows by the mean of them all.

    Parameters
    ----------
    original : SceneData
        As it was loaded.
    lights : sequence of Light
        One for each light of `original`, of the same kind.
    """
    shining = tuple(
        light if is_on else light.with_emitted(BLACK)
        for light, is_on in zip(lights, on, strict=True)
    )
    materials = list(original.materials)
    objects = []
    runs = body_lights(original)
    for item in original.objects:
        if item.light is None:
            objects.append(item)
            continue
        run = runs.get(item.light, range(item.light, item.light + 1))
        if all(shining[i] == original.lights[i] for i in run):
            objects.append(item)
            continue
        before, after = original.lights[item.light], shining[item.light]
        material = original.materials[item.material]
        shares = np.array([_area(original.lights[i]) for i in run])
        shares /= max(shares.sum(), np.finfo(np.float64).tiny)
        was, now = (
            shares @ [lights[i].emitted for i in run] for lights in (original.lights, shining)
        )
        emission = [
            float(e * new / old if old > 0.0 else new)
            for e, old, new in zip(material.emission, was, now, strict=True)
        ]
        materials.append(
            dataclasses.replace(material, emission=(emission[0], emission[1], emission[2]))
        )
        objects.append(_moved(item, before, after, len(materials) - 1))
    return dataclasses.replace(
        original, lights=shining, materials=tuple(materials), objects=tuple(objects)
    )


def _area(light: Light) -> float:
    """Return the area of a light's face; 1 if it has none."""
    edges = [getattr(light, name) for name in light.edge_fields]
    return float(np.linalg.norm(np.cross(*edges))) if edges else 1.0


def _moved(item: SceneObject, before: Light, after: Light, material: int) -> SceneObject:
    start, end = before.place, after.place
    matrices = item.world_from_object
    turn = np.eye(4)
    if not np.array_equal(before.light_from_world, after.light_from_world):
        turn[:3, :3] = after.light_from_world.T @ before.light_from_world
    if start is not None and end is not None:
        offset = math3d.translation(end) @ turn @ math3d.translation(np.negative(start))
        matrices = np.asarray(offset @ matrices)
    return dataclasses.replace(item, world_from_object=matrices, material=material)


def _sharing(scene: SceneData, index: int) -> range:
    """Return the lights that stand for the same body as one does, itself among them."""
    alone = range(index, index + 1)
    return next((run for run in body_lights(scene).values() if index in run), alone)


def moved_lights(
    scene: SceneData, lights: Sequence[Light], index: int, matrix: FloatArray
) -> list[Light]:
    """Return `lights`, one moved by a rigid (4, 4) matrix, with those that share its body."""
    moves = _sharing(scene, index)
    return [light.moved(matrix) if i in moves else light for i, light in enumerate(lights)]


def with_added_light(scene: SceneKind, light: Light) -> SceneKind:
    """Return the scene with one more light, the last one, and the body that shows it."""
    meshes, materials, objects = scene.meshes, scene.materials, scene.objects
    body = light.body()
    if body is not None:
        item = body.placed(light, len(scene.lights), len(meshes), len(materials))
        meshes, materials = (*meshes, body.make()), (*materials, body.material)
        objects = (*objects, item)
    return dataclasses.replace(
        scene,
        meshes=meshes,
        materials=materials,
        objects=objects,
        lights=(*scene.lights, light),
    )


def without_light(scene: SceneKind, index: int) -> tuple[SceneKind, range]:
    """Return the scene without a light and its body, and all lights that went with it."""
    gone = _sharing(scene, index)

    def left(number: int | None) -> int | None:
        return number if number is None or number < gone.start else number - len(gone)

    objects = tuple(
        item
        if left(item.light) == item.light
        else dataclasses.replace(item, light=left(item.light))
        for item in scene.objects
        if item.light not in gone
    )
    lights = (*scene.lights[: gone.start], *scene.lights[gone.stop :])
    return dataclasses.replace(scene, objects=objects, lights=lights), gone


def new_light(kind: type[Light], camera: Camera, distance: float) -> Light:
    """Return a white light `distance` before the camera that shines where the camera looks.

    As far from it, what it faces gets an irradiance under which white shows as white.
    """
    right, up, back = camera.view_from_world_rotation()
    place = math3d.vector(np.asarray(camera.position) - distance * back)
    irradiance = math.pi / 2.0**camera.exposure
    edge = NEW_EDGE * distance
    emitted = {
        Form.POINT: irradiance * distance**2,
        Form.PARALLEL: irradiance,
        Form.AREA: irradiance * (distance / edge) ** 2,
    }[kind.form]
    fields: dict[str, Any] = dict.fromkeys(kind.point_fields, place)
    fields |= dict.fromkeys(kind.direction_fields, math3d.vector(-back))
    # In this order, their product points ahead.
    for name, axis in zip(kind.edge_fields, (up, right), strict=False):
        fields[name] = math3d.vector(edge * axis)
    fields[kind.emitted_field] = (emitted, emitted, emitted)
    light = kind(**fields)
    return light.moved_to(place)

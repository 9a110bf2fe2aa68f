"""Changes a light of a scene together with the body that is seen of it. Pure."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from ssdo_gl import math3d
from ssdo_gl.scene.lights import BLACK, Light
from ssdo_gl.scene.mesh import SceneObject
from ssdo_gl.scene.scene import Scene


def with_lights(original: Scene, lights: Sequence[Light], on: Sequence[bool]) -> Scene:
    """Return `original` with its lights replaced by `lights`, dark where not `on`.

    The body that stands for a rectangle light in the picture follows it: it moves by
    as much, and its emission changes by the same factors.

    Parameters
    ----------
    original : Scene
        As it was loaded.
    lights : sequence of Light
        One for each light of `original`, of the same kind.
    on : sequence of bool
    """
    shining = tuple(
        light if is_on else light.with_emitted(BLACK)
        for light, is_on in zip(lights, on, strict=True)
    )
    materials = list(original.materials)
    objects = []
    for item in original.objects:
        if item.light is None or shining[item.light] == original.lights[item.light]:
            objects.append(item)
            continue
        before, after = original.lights[item.light], shining[item.light]
        material = original.materials[item.material]
        emission = [
            e * new / old if old > 0.0 else new
            for e, old, new in zip(material.emission, before.emitted, after.emitted, strict=True)
        ]
        materials.append(
            dataclasses.replace(material, emission=(emission[0], emission[1], emission[2]))
        )
        objects.append(_moved(item, before, after, len(materials) - 1))
    return dataclasses.replace(
        original, lights=shining, materials=tuple(materials), objects=tuple(objects)
    )


def _moved(item: SceneObject, before: Light, after: Light, material: int) -> SceneObject:
    start, end = before.place, after.place
    matrices = item.world_from_object
    if start is not None and end is not None and start != end:
        offset = math3d.translation(np.subtract(end, start))
        matrices = np.asarray(offset @ matrices)
    return dataclasses.replace(item, world_from_object=matrices, material=material)

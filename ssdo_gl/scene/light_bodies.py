"""Which lights of a scene are one glowing body."""

from __future__ import annotations

from ssdo_gl.scene.emissive_meshes import MAX_LIGHTS, MAX_PANELS
from ssdo_gl.scene.scene_data import SceneData

# Where something is translucent, frames of a moving camera take 1.75 and 7.5 s with 8 and 32 panels
# as exact lights, .38 and .68 by rays to all of them, which err alike (640x360).
MOST_PANELS = 4


def body_lights(scene: SceneData) -> dict[int, range]:
    """Return, for each light that names a glowing object, all lights that stand for it.

    An object names the first of them; the others follow it, up to the first that another
    object names or that cannot be of the same body. A scene may have lost its lights since.
    """
    owners = {
        item.light
        for item in scene.objects
        if item.light is not None and scene.materials[item.material].emits
    }
    runs = {}
    for first in sorted(owners & set(range(len(scene.lights)))):
        head, last = scene.lights[first], first + 1
        while (
            last < len(scene.lights)
            and last not in owners
            and head.can_share_body(scene.lights[last])
        ):
            last += 1
        runs[first] = range(first, last)
    return runs


def parts_of_bodies(scene: SceneData) -> frozenset[int]:
    """Return the lights that share their body with others."""
    return frozenset(
        light for lights in body_lights(scene).values() if len(lights) > 1 for light in lights
    )


def bodies_with_images(scene: SceneData) -> frozenset[int]:
    """Return the lights of bodies that emit an image, of which they have but the mean."""
    with_images = {
        item.light
        for item in scene.objects
        if item.light is not None
        and scene.meshes[item.mesh].uvs is not None
        and scene.materials[item.material].emission_texture is not None
    }
    runs = body_lights(scene)
    return frozenset(i for first in with_images & runs.keys() for i in runs[first])


def approximations(scene: SceneData) -> frozenset[int]:
    """Return the lights in whose place rays to points of their bodies are better.

    They do not send exactly what the body does; or they are of many panels, where
    something translucent casts another shadow of each light in each frame, or rays
    are needed anyway because other panels are more than a scene's lights.
    """
    return stand_ins(scene) | bodies_with_images(scene) | _many_panels(scene)


def _many_panels(scene: SceneData) -> frozenset[int]:
    if has_crowd_of_panels(scene):
        return _panels(scene)
    lights = frozenset(i for run in body_lights(scene).values() for i in run)
    if len(lights) <= MOST_PANELS:
        return frozenset()
    used = (scene.materials[item.material] for item in scene.objects)
    return lights if any(m.is_translucent for m in used) else frozenset()


def has_crowd_of_panels(scene: SceneData) -> bool:
    """Return whether bodies are left over of which no lights were made, as panels are so many.

    docs/far-field-lights.md has what they took as exact lights.
    """
    is_over = any(
        item.light is None and scene.materials[item.material].emits for item in scene.objects
    )
    # One body needs no more places than MAX_PANELS, so all others are taken.
    return is_over and len(_panels(scene)) > MAX_LIGHTS - MAX_PANELS


def _panels(scene: SceneData) -> frozenset[int]:
    lights = frozenset(i for run in body_lights(scene).values() for i in run)
    return lights - stand_ins(scene)


def stand_ins(scene: SceneData) -> frozenset[int]:
    """Return the lights that share a body of another shape, within which they lie."""
    return frozenset(i for i in parts_of_bodies(scene) if scene.lights[i].body() is None)

"""Which lights of a scene are one glowing body."""

from __future__ import annotations

from ssdo_gl.scene.scene import Scene


def body_lights(scene: Scene) -> dict[int, range]:
    """Return, for each light that names a glowing object, all lights that stand for it.

    An object names the first of them; the others follow it, up to the first that another
    object names or that cannot be of the same body.
    """
    owners = {
        item.light
        for item in scene.objects
        if item.light is not None and scene.materials[item.material].emits
    }
    runs = {}
    for first in sorted(owners):
        head, last = scene.lights[first], first + 1
        while (
            last < len(scene.lights)
            and last not in owners
            and head.can_share_body(scene.lights[last])
        ):
            last += 1
        runs[first] = range(first, last)
    return runs


def parts_of_bodies(scene: Scene) -> frozenset[int]:
    """Return the lights that share their body with others."""
    return frozenset(
        light for lights in body_lights(scene).values() if len(lights) > 1 for light in lights
    )


def stand_ins(scene: Scene) -> frozenset[int]:
    """Return the lights that share a body of another shape, within which they lie."""
    return frozenset(i for i in parts_of_bodies(scene) if scene.lights[i].body() is None)

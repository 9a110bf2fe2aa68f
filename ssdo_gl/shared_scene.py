"""A scene on a device, for all who draw it: what does not depend on who looks, and how."""

from __future__ import annotations

from collections.abc import Callable
from weakref import WeakKeyDictionary, WeakValueDictionary

import moderngl

from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.graph.pass_results import SharedResults
from ssdo_gl.last_made import are_same
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.material import have_same_shape
from ssdo_gl.scene.scene import Scene


class _Numbers:
    """Numbers scenes that somebody holds; equal where they are alike in what counts."""

    def __init__(self, are_alike: Callable[[Scene, Scene], bool]) -> None:
        self._are_alike = are_alike
        self._known: WeakKeyDictionary[Scene, int] = WeakKeyDictionary()
        self._count = 0

    def of(self, scene: Scene) -> int:
        """Return the number of `scene`."""
        number = self._known.get(scene)
        if number is None:
            alike = (n for known, n in self._known.items() if self._are_alike(known, scene))
            number = next(alike, self._count)
            self._count += number == self._count
            self._known[scene] = number
        return number


class SharedScene:
    """Geometry of a scene on the device, and what passes make of the scene alone.

    Whoever draws from one place, at one time or with one method needs the same vertices,
    hierarchy, shadow maps and surface cache as others do, who draw with the same device.

    Attributes
    ----------
    geometry : Geometry
        As it stood when `follow` was called last.
    """

    def __init__(self, gl: moderngl.Context, scene: Scene) -> None:
        self.geometry = Geometry(gl, scene)
        self.results = SharedResults()
        self._geometries = _Numbers(_stand_alike)
        self._materials = _Numbers(lambda a, b: are_same(a.materials, b.materials))
        self._lights = _Numbers(lambda a, b: _are_equal(a.lights, b.lights))
        self._environments = _Numbers(lambda a, b: _are_equal(a.environment, b.environment))
        self._moments: WeakValueDictionary[tuple[Scene, float], Scene] = WeakValueDictionary()
        self._stands = scene

    def at(self, scene: Scene, seconds: float) -> Scene:
        """Return the scene at a time: the very same for all who ask for the same."""
        if not scene.moves:
            return scene
        moment = scene, seconds
        moved = self._moments.get(moment)
        if moved is None:
            moved = self._moments[moment] = scene_at(scene, seconds)
        return moved

    def follow(self, scene: Scene) -> dict[str, int]:
        """Bring the geometry to the state of `scene`; return versions of it and of materials."""
        versions = self._surface_versions(scene)
        if versions != self._surface_versions(self._stands):
            self.geometry.update(scene)
        self._stands = scene
        return versions

    def _surface_versions(self, scene: Scene) -> dict[str, int]:
        return {"geometry": self._geometries.of(scene), "materials": self._materials.of(scene)}

    def light_versions(self, scene: Scene) -> dict[str, int]:
        """Return versions of its lights and its environment."""
        return {"lights": self._lights.of(scene), "environment": self._environments.of(scene)}


def _stand_alike(a: Scene, b: Scene) -> bool:
    are_alike = all(map(are_same, *((s.objects, s.meshes) for s in (a, b))))
    return are_alike and have_same_shape(a.materials, b.materials)


def _are_equal(a: object, b: object) -> bool:
    try:
        return a is b or bool(a == b)
    except ValueError:
        # Arrays, where somebody has given some: told apart by identity alone.
        return False

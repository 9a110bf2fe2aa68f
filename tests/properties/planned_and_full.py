"""Renders a scene as planned and with every effect, and compares all images."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl import math3d
from ssdo_gl.effects.request import Decided
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, GradientEnvironment
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import AOVS, Settings

SIZE = (48, 32)
# Of the brightest value in the image, or of 1: the planned frame may add the same float32
# numbers in another order, or multiply after a sum instead of before it.
AGREEMENT = 1e-6
# The display has 16 bits: what differs by less may lie on either side of where they round.
DISPLAY_STEP = 1.0 / 65535.0

BOX, QUAD, SPHERE, TORUS = shapes.box(), shapes.quad(), shapes.sphere(16), shapes.torus(0.3)
WHITE, GREY, BLACK = (1.0, 1.0, 1.0), (0.5, 0.5, 0.5), (0.0, 0.0, 0.0)
FRONT = Camera((0.0, 0.0, 6.0), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Compared:
    """What a planned rendering decided and showed."""

    decided: Decided
    images: dict[str, NDArray[np.float32]]
    ran: frozenset[str]
    ran_in_full: frozenset[str]

    def runs(self, *effects: str) -> bool:
        """Return whether any of these effects was decided to run."""
        return self.decided.runs(*effects)

    @property
    def is_open(self) -> bool:
        """Nothing within R blocks any direction of any visible point."""
        return self.decided.spares("blocked directions")

    @property
    def shares_directions(self) -> bool:
        """The bounce takes over what an earlier march found."""
        return self.decided.spares("second march")


def at(x: float, y: float, z: float) -> NDArray[np.float64]:
    return math3d.translation((x, y, z))


def turned(x: float, y: float, z: float) -> NDArray[np.float64]:
    return math3d.rotation_euler(np.array([x, y, z]))


FLOOR = (QUAD, at(-2.5, -1.0, 2.5) @ turned(-90.0, 0.0, 0.0) @ np.diag([5.0, 5.0, 1.0, 1.0]))
PILE = (FLOOR, (BOX, at(-0.6, -0.5, 0.0)), (TORUS, at(0.8, -0.7, 0.2)))
LAMP = PointLight((1.5, 3.0, 2.5), (20.0, 20.0, 20.0))
OFF = dataclasses.replace(LAMP, intensity=BLACK)
WINDOW = RectangleLight((-1.0, 2.5, -1.0), (2, 0, 0), (0, 0, 2), (3.0, 3.0, 3.0), shadow="ssdo")
SKY = ConstantEnvironment((0.5, 0.6, 0.7))
DAWN = GradientEnvironment((0.5, 0.6, 0.7), (0.9, 0.5, 0.3), (0.2, 0.2, 0.2))


def make_scene(*items, lights=(), environment=None, camera=FRONT, **more) -> Scene:
    """Return a scene of (mesh, matrix) or (mesh, matrix, material) items."""
    meshes: list[Mesh] = []
    materials: list[Material] = []
    objects = []
    for mesh, matrix, *rest in items:
        material = rest[0] if rest else Material(albedo=GREY)
        if not any(mesh is known for known in meshes):
            meshes.append(mesh)
        number = next(i for i, known in enumerate(meshes) if known is mesh)
        objects.append(SceneObject(number, len(materials), np.asarray(matrix)[None]))
        materials.append(material)
    return Scene(
        tuple(meshes), tuple(materials), tuple(objects), camera, tuple(lights), environment, **more
    )


def compare(device, shaders, scene: Scene, wanted=AOVS, **settings) -> Compared:
    """Render `scene` both ways and assert that all images agree."""
    usual = {"method": "bounce", "size": SIZE, "radius": 0.5, "samples": 32, "steps": 4}
    chosen = Settings(**usual | settings)
    results = []
    with Renderer(scene, chosen, device=device, shaders=shaders) as renderer:
        for effects in ("auto", "full"):
            renderer.use(dataclasses.replace(chosen, effects=effects))
            result = renderer.render(wanted)
            results.append((result, renderer._planned.decided))
    (planned, decided), (full, _) = results
    for name in wanted:
        a, b = planned.images[name], full.images[name]
        assert a.shape == b.shape, name
        assert np.all(np.isfinite(b)), name
        bound = AGREEMENT * max(1.0, float(np.abs(b).max(initial=0.0)))
        bound += DISPLAY_STEP if name == "display" else 0.0
        difference = float(np.abs(a.astype(np.float64) - b).max(initial=0.0))
        assert difference <= bound, f"{name}: {difference:.2e} > {bound:.2e}"
    ran = [frozenset(row.name for row in result.passes if row.ran) for result in (planned, full)]
    return Compared(decided, planned.images, *ran)

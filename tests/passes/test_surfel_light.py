"""The surface cache against closed forms: all light, any number of bounces."""

from __future__ import annotations

import numpy as np
import pytest
from passes.cache_harness import fill

from ssdo_gl.passes.surfel_light import SurfaceCacheSettings, relaxation
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.mesh import Mesh, SceneObject
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.shapes import box, sphere

CAMERA = Camera((0.1, 0.0, 0.2), (0.0, 0.0, 0.0))
# Fewer surfels than usual: closed forms hold for any number of them.
FEW = SurfaceCacheSettings(surfels=4096, texel=0.08, light_samples=64)
# Lamps are drawn from at random: 64 points for each of some 2000 surfels, whose light is
# off by a tenth near the edges of the furnace, are good to 0.3 % on average.
TOLERANCE = 0.005


def furnace(mesh: Mesh, albedo: float) -> Scene:
    material = Material(albedo=(albedo,) * 3, emission=(1.0, 1.0, 1.0))
    turned = Mesh(mesh.positions, mesh.triangles[:, ::-1])
    return Scene((turned,), (material,), (SceneObject(0, 0),), CAMERA)


@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.9, 0.99])
@pytest.mark.parametrize("mesh", [box(), sphere()], ids=["box", "sphere"])
def test_furnace_reaches_e_over_one_minus_a(device, shaders, mesh, albedo) -> None:
    filled = fill(device, shaders, furnace(mesh, albedo), FEW)
    inside = filled.direct[:, 0] > 0.0
    assert inside.mean() == 0.5
    expected = np.pi / (1.0 - albedo)
    np.testing.assert_allclose(filled.irradiance[inside].mean(), expected, rtol=TOLERANCE)
    assert np.all(filled.irradiance[~inside] == 0.0)
    assert filled.irradiance.min() >= 0.0


@pytest.mark.parametrize("kept", [0.0, 0.5, 0.9, 0.99])
def test_relaxation_converges_for_every_part_of_the_spectrum(kept) -> None:
    spectrum = kept * np.linspace(-1.0, 1.0, 41)
    last_but_one, last = np.zeros(41), np.zeros(41)
    for over in relaxation(kept):
        bounced = 1.0 + spectrum * last
        last_but_one, last = last, last_but_one + over * (bounced - last_but_one)
    np.testing.assert_allclose(last, 1.0 / (1.0 - spectrum), rtol=2e-4)

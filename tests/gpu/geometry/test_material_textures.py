"""Textures of materials: cut-outs keep their share of a surface at every distance."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import ssdo_gl
from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.scene import Scene

# Between two mip levels whose opaque texels differ, interpolation loses up to 0.09;
# averaged alpha loses all of it.
TOLERANCE = 0.1


def fence(dtype: type) -> NDArray[np.uint8] | NDArray[np.float32]:
    """Return bars of four texels in every sixteen: a quarter of the surface."""
    pixels = np.ones((256, 256, 4), dtype)
    pixels *= 255 if dtype is np.uint8 else 1
    pixels[:, np.arange(256) % 16 >= 4, 3] = 0
    return pixels


@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
@pytest.mark.parametrize("distance", [2.0, 8.0, 20.0, 50.0])
def test_a_fence_stays_a_quarter(distance: float, dtype: type) -> None:
    mesh = shapes.quad()
    assert mesh.uvs is not None
    scene = Scene(
        (mesh,),
        (Material(albedo_texture=Texture(fence(dtype)), alpha_cutoff=0.5),),
        (SceneObject(0, 0, (math3d.scaling(4.0) @ math3d.translation((-0.5, -0.5, 0)))[None]),),
        Camera((0.0, 0.0, distance), (0.0, 0.0, 0.0)),
    )
    fov = 2.0 * np.degrees(np.arctan(2.0 / distance))
    size = max(int(512 / distance), 16)
    camera = Camera((0.0, 0.0, distance), (0.0, 0.0, 0.0), fov_y=float(fov))
    with ssdo_gl.Renderer(scene, ssdo_gl.Settings(size=(size, size))) as renderer:
        depth = renderer.render(["depth"], camera=camera).images["depth"]
    assert (depth > 0.0).mean() == pytest.approx(0.25, abs=TOLERANCE)

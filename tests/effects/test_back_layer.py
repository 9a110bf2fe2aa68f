"""The second depth layer: where solids end."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle import analytic_pictures
from passes.estimator_cases import picture_frame
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.back_layer import BackFacesPass, DepthLayersPass
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material

# As for the G-buffer's depth.
Z_TOLERANCE = 4e-6
CUBE = box((-1.0, -1.0, -6.0), (1.0, 1.0, -4.0))


@pytest.fixture
def shaders(shaders_either_way):
    return shaders_either_way


def z_back(gl, shaders, scene, size=(64, 48)):
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, size, geometry=geometry)
    image = run_pass(gl, shaders, BackFacesPass(), frame, geometry=geometry)["z_back_vs"][..., 0]
    geometry.release()
    rays = analytic_pictures.view_rays(size, frame.view.tan_half_fov)[::-1]
    return image, rays


def box_exit(rays, low, high):
    """Depth at which rays from the origin leave a box; 0 for those that miss it."""
    with np.errstate(divide="ignore"):
        t = np.stack([low / rays, high / rays])
    enter, leave = t.min(0).max(-1), t.max(0).min(-1)
    return np.where(enter < leave, leave, 0.0)


@pytest.mark.parametrize("mirror", [(1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
def test_back_of_a_box(gl, shaders, mirror):
    """Mirrored instances turn their windings around, not their insides out."""
    shifted = box((-0.5, -0.7, -6.0), (1.0, 1.2, -4.0))
    place = np.diag([*mirror, 1.0]).astype(np.float64)
    scene = make_scene([shifted], objects=[SceneObject(0, 0, place[None])])
    found, rays = z_back(gl, shaders, scene)
    low, high = np.array([-0.5, -0.7, -6.0]), np.array([1.0, 1.2, -4.0])
    wanted = box_exit(rays * mirror, low, high)
    # Rays that graze the silhouette may go either way.
    rim = np.array([0.02, 0.02, 0.0])
    hit = box_exit(rays * mirror, low + rim, high - rim) > 0.0
    missed = box_exit(rays * mirror, low - rim, high + rim) == 0.0
    assert hit.sum() > 200
    np.testing.assert_allclose(found[hit], wanted[hit], rtol=Z_TOLERANCE)
    assert np.all(found[missed] == 0.0)


def test_nearest_of_several_backs(gl, shaders):
    inner = box((-0.2, -0.2, -5.2), (0.2, 0.2, -4.8))
    found, _ = z_back(gl, shaders, make_scene([CUBE, inner]))
    assert found[24, 32] == pytest.approx(5.2, rel=Z_TOLERANCE)


def test_from_inside_a_solid_its_walls_are_backs(gl, shaders):
    room = box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    found, rays = z_back(gl, shaders, make_scene([room]))
    np.testing.assert_allclose(found, 1.0 / np.abs(rays).max(-1), rtol=1e-5)


def test_open_meshes_and_cut_outs_bound_nothing(gl, shaders):
    card = quad((1.0, -1.0, -3.0), (-2.0, 0.0, 0.0), (0.0, 2.0, 0.0))
    opened = dataclasses.replace(CUBE, closed=False)
    assert not np.any(z_back(gl, shaders, make_scene([card, opened]))[0])
    holey = make_scene([CUBE], materials=[Material(alpha_cutoff=0.5)])
    assert not np.any(z_back(gl, shaders, holey)[0])


def test_a_body_turned_inside_out_is_no_solid(gl, shaders):
    inside_out = dataclasses.replace(CUBE, triangles=CUBE.triangles[:, ::-1])
    assert not np.any(z_back(gl, shaders, make_scene([inside_out]))[0])
    # Mirrored, its front is still the side that the mesh calls its front.
    place = np.diag([-1.0, 1.0, 1.0, 1.0])[None]
    scene = make_scene([inside_out], objects=[SceneObject(0, 0, place)])
    assert not np.any(z_back(gl, shaders, scene)[0])


def test_no_front_face_is_drawn(gl, shaders):
    """Just behind the eye's own cube face nothing but the far side shows."""
    found, _ = z_back(gl, shaders, make_scene([CUBE]))
    assert found[found > 0.0].min() > 4.0 * (1.0 + 1e-3)


def test_layers_are_packed_unchanged(gl, shaders):
    rng = np.random.default_rng(1)
    z, back = (rng.random((5, 7, 1)).astype(np.float32) * 10.0 for _ in range(2))
    frame = picture_frame((7, 5), 0.5)
    found = run_pass(gl, shaders, DepthLayersPass(), frame, {"z_vs": z, "z_back_vs": back})
    np.testing.assert_array_equal(found["z_layers"], np.concatenate([z, back], -1))

"""Shadows: a plane casts none on itself, and what stands on it leaves no gap."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hard_cases.hard_scene import box, quad
from hard_cases.methods import render
from hard_cases.test_depth import with_meshes

from ssdo_gl import math3d
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight

# Three axes that no texel's grid and no code of a normal is aligned with.
U, V, N = np.linalg.qr(np.array([[0.9, 0.2, 0.3], [0.1, -0.4, 0.8], [-0.3, 0.8, 0.5]]))[0].T
DISTANCE = 2.0


def rectangle(place):
    """A light of a quarter of its distance, that faces the plane's middle."""
    toward = -math3d.normalized(place)
    edge_u = math3d.normalized(np.cross(toward, V)) * 0.5
    edge_v = np.cross(toward, edge_u)
    corner = place - 0.5 * (edge_u + edge_v)
    edges = tuple(edge_u.tolist()), tuple(edge_v.tolist())
    return RectangleLight(tuple(corner), *edges, (5, 5, 5), two_sided=True, visible=False)


LIGHTS = {
    "point": lambda place: PointLight(tuple(place), (1, 1, 1)),
    "spot": lambda place: SpotLight(tuple(place), tuple(-math3d.normalized(place)), (1, 1, 1)),
    "directional": lambda place: DirectionalLight(tuple(-math3d.normalized(place)), (1, 1, 1)),
    "rectangle": rectangle,
}


def lit(device, shaders, light, slope, shadows, *meshes):
    """Return direct light on a plane whose normal is `slope` degrees off the light's."""
    angle = np.radians(slope)
    place = DISTANCE * (np.cos(angle) * N + np.sin(angle) * U)
    eye = 1.5 * N + 0.7 * V
    scene = with_meshes(
        quad(-2 * U - 2 * V, 4 * U, 4 * V),
        *meshes,
        camera=Camera(tuple(eye), (0, 0, 0), up=tuple(U)),
        lights=(LIGHTS[light](place),),
        environment=None,
    )
    options = {"images": ("direct",), "shadows": shadows, "effects": "full", "maps": {}}
    return render(device, shaders, scene, ("direct", None), **options)["direct"].astype(float)


def plane_shadows_itself(device, shaders, light="rectangle", slope=85.0, shadows="map"):
    """The largest share of its light that a plane, alone in the world, keeps from itself."""
    open_ = lit(device, shaders, light, slope, "none")
    found = lit(device, shaders, light, slope, shadows)
    is_lit = open_ > 0.0
    assert is_lit.mean() > 0.3 and np.all(found[~is_lit] == 0.0)
    return float(np.abs(found[is_lit] / open_[is_lit] - 1.0).max()), 0.0


SLOPES = (0, 30, 60, 80, 85, 89)


@pytest.mark.parametrize("slope", SLOPES)
@pytest.mark.parametrize("light", LIGHTS)
def test_a_plane_casts_no_shadow_on_itself(device, shaders, record, light, slope):
    """Not even in rounding: what passes no test that blocks counts as 1."""
    error, bound = plane_shadows_itself(device, shaders, light, slope)
    record("plane in its own shadow map", light, error, bound, "of the light")


@pytest.mark.parametrize("slope", SLOPES)
@pytest.mark.parametrize("light", [name for name in LIGHTS if name != "rectangle"])
def test_a_plane_meets_no_shadow_ray_of_its_own(device, shaders, record, light, slope):
    """Rays weigh light by the triangle's own normal, pixels by one that was stored."""
    error, _ = plane_shadows_itself(device, shaders, light, slope, "traced")
    # 16 bits per axis: 6.5e-5 radians, beside a cosine that vanishes at 90 degrees. What is
    # in view lies at most 2.7 beside the foot of a light 0.035 above: 89.3 degrees.
    bound = 6.5e-5 * np.tan(np.radians(89.3))
    record("plane under rays", light, error, bound, "of the light")


# Texels that the shadow's border halves: a twentieth of its pixels, at most half open on
# one side. Of a rectangle, four rays may all be blocked where a little of it is in view.
LEAK_BOUND = {"point": 0.02, "spot": 0.02, "directional": 0.02, "rectangle": 0.04}


def body():
    """Return a board that stands on the plane."""
    straight = box((-0.02, -0.2, 0.0), (0.02, 0.2, 0.3))
    return dataclasses.replace(straight, positions=straight.positions @ np.array([U, V, N]))


def light_gets_under(device, shaders, light="point", slope=60.0):
    """The share of its light that gets to where, by a ray, a board on the plane keeps it off."""
    open_, shadowed, reference = (
        lit(device, shaders, light, slope, kind, body()) for kind in ("none", "map", "traced")
    )
    is_dark = (reference == 0.0) & (open_ > 0.0)
    assert is_dark.mean() > 0.01
    return float(shadowed[is_dark].sum() / open_[is_dark].sum()), LEAK_BOUND[light]


@pytest.mark.parametrize("slope", (30, 45, 60, 75))
@pytest.mark.parametrize("light", LIGHTS)
def test_no_light_gets_under_what_stands_on_a_plane(device, shaders, record, light, slope):
    """Shadows begin where bodies touch the ground: a bias against acne would part them."""
    error, bound = light_gets_under(device, shaders, light, slope)
    record("light under a board", light, error, bound, "of the light")

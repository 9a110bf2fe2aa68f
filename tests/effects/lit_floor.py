"""A floor under a light of each kind: what is drawn, and its irradiance by definition."""

from __future__ import annotations

import numpy as np
from oracle import lambert_polygon
from passes.pass_harness import make_frame, quad, run_pass

from ssdo_gl.effects.direct import DirectPass
from ssdo_gl.effects.shadows.shadow_map import ShadowMapPass, ShadowMapSettings
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.images.surface_arrays import world_positions
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight

SIZE = (64, 48)
FLOOR = quad((-10.0, 0.0, 10.0), (20.0, 0.0, 0.0), (0.0, 0.0, -20.0))
UP = np.array([0.0, 1.0, 0.0])
CAMERA = Camera((0.0, 3.0, 5.0), (0.0, 0.0, 0.0), fov_y=45.0)
LIGHTS = {
    "point": PointLight((0.7, 2.0, -0.4), (5.0, 6.0, 7.0)),
    "spot": SpotLight((0.5, 2.5, 0.3), (-0.28, -0.96, 0.0), (5.0, 6.0, 7.0), 15.0, 40.0),
    "wide spot": SpotLight((0.5, 2.5, 0.3), (-0.28, -0.96, 0.0), (5.0, 6.0, 7.0), 15.0, 75.0),
    "directional": DirectionalLight((0.48, -0.8, 0.36), (3.0, 2.0, 1.0)),
    "rectangle": RectangleLight(
        (-0.4, 2.0, -0.6), (0.8, 0.0, 0.0), (0.0, 0.0, 1.2), (3.0, 2.0, 1.0)
    ),
}


def draw(gl, shaders, scene, size=SIZE, *, maps=True, settings=None, map_settings=None, seed=0):
    """Return the frame, the G-buffer and the direct irradiance, top row first."""
    geometry = Geometry(gl, scene)
    frame = make_frame(scene, size, geometry=geometry, seed=seed)
    images = run_pass(gl, shaders, GBufferPass(), frame, geometry=geometry)
    map_settings = map_settings or ShadowMapSettings(resolution=128)
    parts = map_settings.parts_per_side
    direct = DirectPass(settings, shadow_maps=maps, parts_per_side=parts, lifts=maps)
    inputs = {name: images[name] for name in ("z_vs", "normals_vs")}
    if maps:
        inputs["lift_vs"] = images["lift_vs"]
        made = run_pass(gl, shaders, ShadowMapPass(map_settings), frame, geometry=geometry)
        inputs["shadow_atlas"] = made["shadow_atlas"]
    irradiance = run_pass(gl, shaders, direct, frame, inputs, geometry)["direct_irradiance"]
    geometry.release()
    return frame, images, irradiance[..., :3]


def floor_points(frame, images):
    """World-space points of the pixels that see something, float64, and their mask."""
    seen = images["z_vs"][..., 0] > 0.0
    points = world_positions(images["z_vs"], frame.view).astype(np.float64)
    return points[seen], seen


def unshadowed(light, points, normal=UP):
    """Irradiance at `points` by definition, one colour channel of 1."""
    if isinstance(light, DirectionalLight):
        return np.full(len(points), max(-np.dot(light.direction, normal), 0.0))
    if isinstance(light, RectangleLight):
        corner, u, v = (np.asarray(a) for a in (light.corner, light.edge_u, light.edge_v))
        outline = np.array([corner, corner + u, corner + u + v, corner + v])
        return np.array(
            [lambert_polygon.cosine_integral(outline - p, normal, normal) for p in points]
        )
    d = np.asarray(light.position) - points
    r = np.linalg.norm(d, axis=1)
    result = np.maximum(d @ normal / r, 0.0) / r**2
    if isinstance(light, SpotLight):
        cosine = -(d @ light.direction) / r
        result = result * lambert_polygon.spot_falloff(cosine, light.inner_angle, light.outer_angle)
    return result


def power(light):
    names = ("intensity", "irradiance", "radiance")
    return np.array(next(getattr(light, name) for name in names if hasattr(light, name)))


CARD = ((-0.5, 1.0, -0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))

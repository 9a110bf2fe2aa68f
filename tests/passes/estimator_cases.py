"""Hand-made pictures for the estimators, and how to run a pass on them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from oracle import analytic_pictures, screen_space, slices
from oracle.analytic_pictures import Plane, Sphere
from oracle.screen_space import Estimator, Picture
from passes.pass_harness import Array, make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.directional import DirectionalPass, DirectionalSettings
from ssdo_gl.effects.ssao import SsaoPass, SsaoSettings
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.screen_space_settings import (
    ScreenSpaceSettings,
    estimator_uniforms,
    pattern_offset,
)
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    Environment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.lights import Light, RectangleLight

NEAR = 0.01
# What a picture is seen through whose angles and size do not matter.
SIZE = (48, 36)
TAN_Y = 0.5
# Sums of some 16 float32 terms of one size.
SUM_TOLERANCE = 2e-6
SKY = GradientEnvironment((0.5, 1.0, 2.0), (1.0, 0.75, 0.5), (0.1, 0.2, 0.3))
# Overhead and to the left of a floor that lies 3 below the camera's axis and beyond.
LAMP = RectangleLight(
    (-0.5, 1.0, -4.0), (0.0, 0.0, 1.5), (-1.0, 0.5, 0.0), (3.0, 2.0, 1.0), shadow="ssdo"
)


def picture_frame(
    size: tuple[int, int],
    tan_half_y: float,
    *,
    near: float = NEAR,
    seed: int = 0,
    environment: Environment | None = None,
    lights: tuple[Light, ...] = (),
) -> Frame:
    """Return a frame whose camera stands at the origin of view space."""
    fov_y = float(np.degrees(2.0 * np.arctan(tan_half_y)))
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, -1.0), fov_y=fov_y)
    # The passes under test draw no geometry; a scene must have some.
    filler = quad((-1, -1, -3), (1, 0, 0), (0, 1, 0))
    scene = make_scene([filler], camera=camera, environment=environment, lights=lights)
    return make_frame(scene, size, near_far=(near, 1e3 * near), seed=seed)


def run_on(
    gl: object,
    shaders: object,
    render_pass: RenderPass,
    frame: Frame,
    picture: Picture,
    more: Mapping[str, NDArray[np.float64]] | None = None,
) -> Array:
    """Run a pass on a picture; return its one image with row 0 at the BOTTOM."""
    images = {**inputs_of(picture), **{k: v[::-1] for k, v in (more or {}).items()}}
    inputs = {name: images[name] for name in render_pass.reads}
    (result,) = run_pass(gl, shaders, render_pass, frame, inputs).values()  # type: ignore[arg-type]
    return np.asarray(result[::-1])


def run_visibility(
    gl: object,
    shaders: object,
    picture: Picture,
    settings: SsaoSettings,
    frame: Frame | None = None,
    has_back: bool | None = None,
) -> Array:
    """Return visibility (h, w) of a picture; by default with its back layer, if any."""
    has_back = picture.z_back is not None if has_back is None else has_back
    size = picture.z.shape[1], picture.z.shape[0]
    frame = frame or picture_frame(size, picture.tan_half_fov[1], near=picture.near)
    render_pass = SsaoPass(settings, has_back_layer=has_back)
    return np.asarray(run_on(gl, shaders, render_pass, frame, picture)[..., 0])


def run_directional(
    gl: object,
    shaders: object,
    picture: Picture,
    settings: DirectionalSettings,
    *,
    environment: Environment | None = None,
    lights: tuple[Light, ...] = (),
    has_back: bool = False,
    more: Mapping[str, NDArray[np.float64]] | None = None,
    **switches: bool,
) -> Array:
    """Return irradiance and visibility (h, w, 4) of a picture under a light of its own."""
    size = picture.z.shape[1], picture.z.shape[0]
    frame = picture_frame(
        size, picture.tan_half_fov[1], near=picture.near, environment=environment, lights=lights
    )
    kinds = {
        type(None): "none",
        ConstantEnvironment: "constant",
        GradientEnvironment: "gradient",
        MapEnvironment: "map",
    }
    render_pass = DirectionalPass(
        settings, environment=kinds[type(environment)], has_back_layer=has_back, **switches
    )
    return run_on(gl, shaders, render_pass, frame, picture, more)


def inputs_of(picture: Picture) -> dict[str, NDArray[np.float64]]:
    """Return the textures that estimators read, row 0 at the top."""
    images = analytic_pictures.textures(picture)
    back = images.pop("z_back_vs", np.zeros_like(images["z_vs"]))
    images["z_layers"] = np.concatenate([images["z_vs"], back], -1)
    return images


def twin_of(settings: ScreenSpaceSettings, frame: Frame, has_back: bool = False) -> Estimator:
    """Return the oracle's estimator for a pass' settings."""
    uniforms = estimator_uniforms(settings, frame, has_back)
    return Estimator(
        settings.estimator,
        settings.radius,
        settings.direction_count,
        settings.step_count,
        pattern_offset(frame.seed),
        thickness=uniforms["u_thickness"],
        bias=settings.bias,
        growth=settings.step_growth,
        front_slack=settings.front_slack,
        back_slack=settings.back_slack,
        box_px=settings.box_px if isinstance(settings, SsaoSettings) else 0.0,
    )


# Estimators that say how open a point is, and not which directions are blocked.
VISIBILITY_TWINS = {
    "bitmask": slices.bitmask,
    "gtao": slices.gtao,
    "hbao": slices.hbao,
    "sao": slices.sao,
    "zbuffer": slices.zbuffer,
}


def expected_visibility(
    picture: Picture, texel: NDArray[np.int64], pixel: NDArray[np.int64], twin: Estimator
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the oracle's visibility (n,) and where float32 may decide otherwise (n,)."""
    if twin.kind in VISIBILITY_TWINS:
        return VISIBILITY_TWINS[twin.kind](picture, texel, pixel, twin)
    samples = screen_space.sample(picture, texel, pixel, twin)
    return screen_space.visibility(samples), samples.unsure.any(1)


def corner(size: tuple[int, int], tan_half: tuple[float, float], scale: float = 1.0) -> Picture:
    """A floor (lower half) and a wall (upper half) that meet at a right angle, 3 away."""
    c = np.sqrt(0.5)
    edge = (0.0, 0.0, -3.0 * scale)
    planes = [Plane(edge, (0.0, c, c)), Plane(edge, (0.0, -c, c))]
    return analytic_pictures.cast(planes, size, tan_half, NEAR * scale)


def tilted_plane(
    degrees: float, size: tuple[int, int], tan_half: tuple[float, float], scale: float = 1.0
) -> Picture:
    """A plane through (0, 0, -3), turned by an angle about the axis (1, 2, 0)."""
    angle = np.radians(degrees)
    across = np.array([2.0, -1.0, 0.0]) / np.sqrt(5.0)
    normal = np.array([0.0, 0.0, 1.0]) * np.cos(angle) + across * np.sin(angle)
    return analytic_pictures.cast([Plane((0, 0, -3 * scale), normal)], size, tan_half, NEAR * scale)


def ball_on_floor(size: tuple[int, int], tan_half: tuple[float, float]) -> Picture:
    """A ball of radius 0.5 that rests on a floor, seen from 45 degrees above."""
    c = np.sqrt(0.5)
    up = np.array([0.0, c, c])
    contact = np.array([0.0, 0.0, -4.0])
    surfaces = [Plane(contact, up), Sphere(contact + 0.5 * up, 0.5)]
    return analytic_pictures.cast(surfaces, size, tan_half)


def random_picture(
    seed: int, size: tuple[int, int], tan_half: tuple[float, float], has_back: bool
) -> Picture:
    """Noise: every texel a surface of its own, some background, some backs."""
    rng = np.random.default_rng(seed)
    shape = size[1], size[0]
    z = float32(1.0 + 2.0 * rng.random(shape)) * (rng.random(shape) > 0.1)
    rays = analytic_pictures.view_rays(size, tan_half)
    geometric = _facing(rng, rays)
    shading = geometric + 0.3 * _facing(rng, rays)
    shading /= np.linalg.norm(shading, axis=-1, keepdims=True)
    back = float32(np.maximum(z + 0.5 * rng.normal(size=shape), 0.0))
    back *= rng.random(shape) < 0.5
    return Picture(
        z, stored(shading), stored(geometric), tan_half, NEAR, back if has_back else None
    )


def noise(seed: int = 3, has_back: bool = False) -> Picture:
    """Return a picture of noise, of the usual size."""
    return random_picture(seed, SIZE, picture_frame(SIZE, TAN_Y).view.tan_half_fov, has_back)


def plane(degrees: float = 40.0) -> Picture:
    """Return a plane of the usual size."""
    return tilted_plane(degrees, SIZE, picture_frame(SIZE, TAN_Y).view.tan_half_fov)


def float32(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the values that a float32 texture would hold."""
    return values.astype(np.float32).astype(np.float64)


def stored(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the normals that the G-buffer would hold."""
    return analytic_pictures.oct_decode(analytic_pictures.oct_encode(normals))


def covered_texels(picture: Picture) -> NDArray[np.int64]:
    """Return (n, 2) texels that are not background."""
    y, x = np.nonzero(picture.z > 0.0)
    return np.stack([x, y], 1)


def positions(picture: Picture) -> NDArray[np.float64]:
    """Return (h, w, 3) view-space points."""
    height, width = picture.z.shape
    return picture.position(np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1))


def _facing(rng: np.random.Generator, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    n = rng.normal(size=rays.shape)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.where(((n * rays).sum(-1) > 0.0)[..., None], -n, n)


__all__ = [
    "ball_on_floor",
    "corner",
    "covered_texels",
    "expected_visibility",
    "float32",
    "inputs_of",
    "picture_frame",
    "positions",
    "random_picture",
    "run_directional",
    "run_on",
    "run_visibility",
    "screen_space",
    "stored",
    "tilted_plane",
    "twin_of",
]

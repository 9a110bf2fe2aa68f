"""Hard cases whose answer is known: more than finite, the images must be right."""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.hard_scene import CAMERA, box, quad, room
from hard_cases.methods import METHODS, SCREEN_SPACE, label, render
from hard_cases.test_depth import CASES as DEPTHS
from hard_cases.test_depth import with_meshes
from hard_cases.test_geometry import CASES as GEOMETRIES
from hard_cases.test_geometry import FLOOR, inward
from hard_cases.test_light import CASES as LIGHTS
from hard_cases.test_light import only

from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment
from ssdo_gl.scene.lights import PointLight

RADIANCES = ("direct", "directional", "bounce")
OCCLUDING = [m for m in METHODS if m[0] != "direct" and m[1] != "zbuffer"]
# Three float32 vertices, interpolated: a few roundings of 6e-8.
DEPTH_ROUNDING = 1e-6


@pytest.mark.parametrize("shadows", ["map", "traced"])
def test_a_light_at_the_camera_casts_no_shadow_in_view(device, shaders, record, shadows):
    """It sees exactly what the camera sees."""
    scene = only(PointLight(CAMERA.position, (1, 1, 1)))
    open_, shadowed = (
        render(device, shaders, scene, ("direct", None), images=("direct",), shadows=kind)["direct"]
        for kind in ("none", shadows)
    )
    lost = float((open_ - shadowed).sum() / open_.sum())
    # Texels of the map that an edge of the scene halves: there it blurs by a texel.
    bound = 0.005 if shadows == "map" else 0.0
    record(f"light at the camera, {shadows}", "direct", lost, bound, "of the light lost")


@pytest.mark.parametrize("shadows", ["map", "traced"])
def test_a_light_inside_a_body_does_not_get_out(device, shaders, record, shadows):
    scene = LIGHTS["point light inside a box"]()
    open_, shadowed = (
        render(device, shaders, scene, ("direct", None), images=("direct",), shadows=kind)["direct"]
        for kind in ("none", shadows)
    )
    leaked = float(shadowed.sum() / open_.sum())
    # The map's texels at the foot of the box, where it meets the floor.
    bound = 0.005 if shadows == "map" else 0.0
    record(f"light inside a box, {shadows}", "direct", leaked, bound, "of the light leaked")


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_lights_without_area_or_height_light_nothing(device, shaders, record, method):
    scene = LIGHTS["rectangle of zero area"]()
    images = render(device, shaders, scene, method, images=RADIANCES)
    brightest = max(float(image[..., :3].max()) for image in images.values())
    record("rectangle of zero area: light", label(method), brightest, 0.0, "radiance")
    scene = LIGHTS["rectangle in the plane of the floor"]()
    images = render(device, shaders, scene, method, images=("direct", "position_ws", "depth"))
    floor = (np.abs(images["position_ws"][..., 1]) < 1e-5) & (images["depth"][..., 0] > 0.0)
    assert floor.any()
    own = float(images["direct"][floor].max())
    record("rectangle in its own plane: light", label(method), own, 0.0, "radiance")


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_surfaces_on_top_of_each_other_count_once(device, shaders, record, method):
    """Three times the same triangles: whichever wins, it looks the same."""
    names = ("direct", "directional", "bounce", "visibility", "depth")
    once = render(device, shaders, with_meshes(FLOOR), method, images=names, effects="full")
    thrice = render(
        device, shaders, GEOMETRIES["duplicate triangles"](), method, images=names, effects="full"
    )
    # References estimate what cannot be seen at once by rays of their own.
    for name in names:
        gap = np.abs(thrice[name] - once[name]).max() / max(once[name].mean(), 1e-30)
        record("duplicate triangles: same image", label(method), float(gap), 1e-6, "relative")


@pytest.mark.parametrize("case", ["one triangle", "coplanar surfaces"])
@pytest.mark.parametrize("method", OCCLUDING, ids=label)
def test_what_lies_in_one_plane_is_open(device, shaders, record, method, case):
    scene = (GEOMETRIES | DEPTHS)[case]()
    names = ("visibility", "depth")
    images = render(device, shaders, scene, method, images=names, effects="full")
    closed = 1.0 - images["visibility"][images["depth"] > 0.0].min()
    record(f"{case}: occlusion", label(method), float(closed), 0.0, "occluded")


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_an_empty_view_is_sky_and_nothing_else(device, shaders, record, method):
    scene = DEPTHS["empty view"]()
    images = render(device, shaders, scene, method, effects="full")
    gap = np.abs(images["beauty"][..., :3] - scene.environment.radiance).max()
    gap = max(gap, *(images[name].max() for name in (*RADIANCES, "depth", "normal_ws")))
    # The sky's own colour as float32 holds it.
    gap = max(gap, 1.0 - images["visibility"].min())
    record("empty view: neutral", label(method), float(gap), 1e-7, "off")


def test_both_ends_of_a_large_range_keep_their_depth(device, shaders, record):
    names = ("depth",)
    scene = DEPTHS["near/far ratio 1e6"]()
    depth = render(device, shaders, scene, ("direct", None), images=names)["depth"][..., 0]
    near, far = depth < 1.0, depth >= 1.0
    assert near.any() and far.any()
    error = max(np.abs(depth[near] / 0.1 - 1.0).max(), np.abs(depth[far] / 1e5 - 1.0).max())
    record("near/far ratio 1e6: depth", "gbuffer", float(error), DEPTH_ROUNDING, "relative")


def test_a_floor_that_passes_under_the_eye_is_where_it_is(device, shaders, record):
    """0.01 below the eye and through the near plane: depth by similar triangles."""
    scene = DEPTHS["geometry through the near plane"]()
    images = render(device, shaders, scene, ("direct", None), images=("depth", "position_ws"))
    rows = images["depth"].shape[0]
    down = -(1.0 - (2.0 * np.arange(rows) + 1.0) / rows) * np.tan(
        np.radians(scene.camera.fov_y / 2.0)
    )
    on_floor = np.abs(images["position_ws"][..., 1] + 0.01) < 1e-4
    wanted = np.broadcast_to((0.01 / np.maximum(down, 1e-9))[:, None], on_floor.shape)
    on_floor &= (wanted > 0.0) & (wanted < 5.0)
    assert on_floor[-1].all(), "the nearest row must show it"
    error = np.abs(images["depth"][..., 0] / wanted - 1.0)[on_floor].max()
    # The floor is 10 long and seen at its height of 0.01: rounding of the projected
    # vertices, 1e-7 of 5, shows against the height.
    record("floor through the near plane: depth", "gbuffer", float(error), 5e-5, "relative")


def test_from_inside_a_body_its_walls_are_where_they_are(device, shaders, record):
    scene = DEPTHS["camera inside a closed mesh"]()
    images = render(device, shaders, scene, ("direct", None), images=("position_ws", "depth"))
    assert np.all(images["depth"] > 0.0)
    error = np.abs(np.abs(images["position_ws"]).max(axis=2) - 1.0).max()
    record("camera inside a closed mesh: walls", "gbuffer", float(error), 1e-6, "absolute")


@pytest.mark.parametrize("method", [m for m in METHODS if m[0].startswith("reference")], ids=label)
def test_rays_find_both_sides_of_a_surface(device, shaders, record, method):
    camera = Camera((0, 0.6, 2.2), (0, 0.3, 0))
    body = box((-0.3, 0.1, -0.3), (0.3, 0.6, 0.3))
    images = [
        render(device, shaders, with_meshes(FLOOR, mesh, camera=camera), method)
        for mesh in (body, inward(body))
    ]
    for name in (*RADIANCES, "visibility"):
        a, b = (image[name].astype(float) for image in images)
        gap = np.abs(a - b).mean() / max(a.mean(), 1e-30)
        # Vertices of a triangle in another order round otherwise: rays that pass an
        # edge within rounding, 1e-5 of them, find another surface.
        record("inward box: same image", label(method), float(gap), 1e-4, "rel. mean")


def sun(value):
    """Return a dark sky of 16 x 32 with one bright texel."""
    image = np.zeros((16, 32, 3), np.float32)
    image[4, 20] = value
    return MapEnvironment(image)


@pytest.mark.parametrize("method", OCCLUDING, ids=label)
def test_a_sun_of_one_texel_brings_its_own_irradiance(device, shaders, record, method):
    """An open floor under one bright texel: radiance x solid angle x cosine."""
    rows, columns, row = 16, 32, 4
    theta = np.pi * np.array([row, row + 1]) / rows
    # Integral of cos(theta) sin(theta) over the texel: the floor's normal is the pole.
    expected = 1e5 * (2.0 * np.pi / columns) * 0.5 * np.diff(np.sin(theta) ** 2)[0]
    scene = with_meshes(
        quad((-9, 0, 9), (18, 0, 0), (0, 0, -18)),
        lights=(),
        environment=sun(1e5),
        camera=Camera((0, 3, 2), (0, 0, 0)),
    )
    images = render(
        device, shaders, scene, method, images=("beauty", "albedo"), samples=64, spp=64,
        effects="full",
    )  # fmt: skip
    found = images["beauty"][..., :3].mean() / images["albedo"][..., :3].mean() * np.pi
    gap = abs(float(found) / expected - 1.0)
    # The control variate is exact on an open plane. Irradiance of a map comes from a grid
    # over the octahedron whose node at the pole is exact. rgs09 only sums what its
    # directions meet: one in 280 of them sees the sun.
    bound = 0.25 if method[1] == "rgs09" else 0.01
    kind = "rgs09" if method[1] == "rgs09" else "others"
    record(f"sun of one texel, {kind}", label(method), gap, bound, "relative")


@pytest.mark.parametrize("method", [m for m in SCREEN_SPACE if m in OCCLUDING], ids=label)
def test_a_radius_below_a_pixel_occludes_nothing(device, shaders, record, method):
    """A pixel covers 0.04 at the room's distance: what is nearer cannot be told apart."""
    images = render(device, shaders, room(), method, radius=1e-3, effects="full")
    closed = float(1.0 - images["visibility"].min())
    record("radius below a pixel: occlusion", label(method), closed, 0.0, "occluded")

"""The surface cache against closed forms: all light, any number of bounces."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from passes.cache_harness import fill

from ssdo_gl.gpu.texture import make_texture, read_texture
from ssdo_gl.passes.surfels.bounces import Bounces, relaxation
from ssdo_gl.passes.surfels.surfel_textures import SURFELS_PER_ROW, SurfaceCacheSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import Environment
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, MapEnvironment
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad, sphere
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

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


# Of large faces one of 17 surfels lies outside, where nothing is seen; small ones are as they are.
@pytest.mark.parametrize("albedo", [0.0, 0.5, 0.9, 0.99])
@pytest.mark.parametrize(
    ("mesh", "share"), [(box(), 16 / 17), (sphere(), 0.5)], ids=["box", "sphere"]
)
def test_furnace_reaches_e_over_one_minus_a(device, shaders, mesh, share, albedo) -> None:
    filled = fill(device, shaders, furnace(mesh, albedo), FEW)
    inside = filled.direct[:, 0] > 0.0
    assert inside.mean() == pytest.approx(share, abs=0.001)
    expected = np.pi / (1.0 - albedo)
    np.testing.assert_allclose(filled.irradiance[inside].mean(), expected, rtol=TOLERANCE)
    assert np.all(filled.irradiance[~inside] == 0.0)
    assert filled.irradiance.min() >= 0.0


def strips(widths: tuple[float, ...], axis: int) -> Mesh:
    """Return a plane from the edge at z = 0 outwards along x or y, its front inside."""
    along = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    outward = np.eye(3)[axis]
    edges = np.concatenate([[0.0], widths])
    points = (edges[:, None, None] * outward + along).reshape(-1, 3)
    corners = 2 * np.arange(len(widths))[:, None] + np.array([0, 1, 3, 2])
    triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    return Mesh(points, triangles if axis == 1 else triangles[:, ::-1])


@pytest.mark.parametrize("albedo", [0.5, 0.9])
def test_wedge_under_an_even_sky(device, shaders, albedo) -> None:
    """Each half of an endless wedge sees the sky and the other half, 1/2 of its view each."""
    widths = (0.004, 0.012, 0.04, 0.12, 0.4, 1.0)
    scene = Scene(
        (strips(widths, 0), strips(widths, 1)),
        (Material(albedo=(albedo,) * 3),),
        (SceneObject(0, 0), SceneObject(1, 0)),
        CAMERA,
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
    )
    filled = fill(device, shaders, scene, SurfaceCacheSettings(texel=0.04))
    # 0.4 % of the width from the edge, and far from the ends, the wedge is endless to 0.5 %.
    at = filled.positions
    chosen = (at[:, :2] > 0.0).all(axis=1) & (at[:, :2] < 0.004).all(axis=1)
    chosen &= np.abs(at[:, 2]) < 0.4
    assert chosen.sum() > 20
    radiance = albedo / np.pi * filled.irradiance[chosen].mean()
    np.testing.assert_allclose(radiance, albedo / 2 / (1 - albedo / 2), rtol=0.01)


def bowl(share: float, material: Material, sky: Environment) -> Scene:
    """Return part of a sphere: wherever in it, the view holds this share of the sphere."""
    mesh = sphere(128)
    low = mesh.positions[mesh.triangles].mean(axis=1)[:, 2] < 2.0 * share - 1.0
    kept = Mesh(mesh.positions, mesh.triangles[low, ::-1])
    return Scene((kept,), (material,), (SceneObject(0, 0),), CAMERA, environment=sky)


@pytest.mark.parametrize("share", [0.25, 0.75])
def test_bowl_under_an_even_sky(device, shaders, share) -> None:
    albedo = 0.8
    material = Material(albedo=(albedo,) * 3, single_sided=True)
    sky = ConstantEnvironment((1.0, 1.0, 1.0))
    filled = fill(device, shaders, bowl(share, material, sky), FEW)
    radiance = albedo / np.pi * filled.irradiance.mean()
    expected = albedo * (1.0 - share) / (1.0 - albedo * share)
    np.testing.assert_allclose(radiance, expected, rtol=0.01)


def test_surfels_find_the_sky_of_a_map_through_a_small_opening(device, shaders) -> None:
    # 16 samples of a map find a tenth of the sphere 1.6 times: their scatter is 1.25 of the mean.
    # Of a surfel's 64 rays 6.4 find it, too, and are spread evenly over the hemisphere: .19.
    sky = MapEnvironment(np.ones((32, 64, 3), dtype=np.float32))
    black = Material(albedo=(0.0, 0.0, 0.0))
    few = SurfaceCacheSettings(texel=0.08)
    direct = fill(device, shaders, bowl(0.9, black, sky), few).direct[:, 0]
    inside = direct < np.pi / 2.0
    assert inside.mean() == pytest.approx(0.5, abs=0.02)
    np.testing.assert_allclose(direct[~inside].mean(), np.pi, rtol=0.01)
    direct = direct[inside]
    np.testing.assert_allclose(direct.mean(), 0.1 * np.pi, rtol=0.02)
    assert direct.std() / direct.mean() < 0.35


def test_lamps_close_to_walls_send_what_they_should(device, shaders) -> None:
    """A closed black box receives pi times area and radiance of each of six lamps beside walls."""
    inward = Mesh(box().positions, box().triangles[:, ::-1])
    # They look down, a fiftieth of a texel from their wall, a third of one above a texel's edge.
    lamps = tuple(
        RectangleLight((x, 0.19, z), (0.02, 0.0, 0.0), (0.0, 0.0, 0.15), (1.0,) * 3, visible=False)
        for x in (-0.499, 0.479)
        for z in (-0.4, -0.1, 0.2)
    )
    black = Material(albedo=(0.0, 0.0, 0.0))
    scene = Scene((inward,), (black,), (SceneObject(0, 0),), CAMERA, lamps)
    filled = fill(device, shaders, scene, SurfaceCacheSettings(texel=0.08))
    at = filled.positions
    inside = np.abs(at).max(axis=1) < 0.5
    # Six faces of area 1, cut into as many texels each. Two rays to a lamp leave 14 % too little.
    received = 6.0 * filled.direct[inside, 0].mean()
    np.testing.assert_allclose(received, 6 * np.pi * 0.02 * 0.15, rtol=0.06)


def test_few_rays_to_long_lamps_come_from_all_of_their_length(device, shaders) -> None:
    """Each surfel sends one ray to each, and not all surfels the same: no end is lit more."""
    inward = Mesh(box().positions, box().triangles[:, ::-1])
    lamps = tuple(
        RectangleLight((-0.45, 0.4, z), (0.9, 0, 0), (0, 0, 0.01), (1.0,) * 3, visible=False)
        for z in np.linspace(-0.4, 0.4, 9).tolist()
    )
    black = Material(albedo=(0.0, 0.0, 0.0))
    scene = Scene((inward,), (black,), (SceneObject(0, 0),), CAMERA, lamps)
    filled = fill(device, shaders, scene, SurfaceCacheSettings(texel=0.03))
    x, y, _ = filled.positions.T
    ends = [filled.direct[(np.abs(x - end) < 1e-3) & (y < 0.3), 0].mean() for end in (-0.5, 0.5)]
    # It was 6 %.
    assert ends[0] == pytest.approx(ends[1], rel=0.03)


def test_the_narrow_sides_of_a_box_light_the_wall_that_it_hangs_on(device, shaders) -> None:
    """Its front, which few rays are spared from, does not."""
    room = Mesh(2.0 * box().positions, box().triangles[:, ::-1])
    plate = placed(box(), (0.02, 0.6, 0.6), (-0.99, 0.0, 0.0))
    black, lamp = Material(albedo=(0.0,) * 3), Material(albedo=(0.0,) * 3, emission=(1.0,) * 3)
    scene = Scene((room, plate), (black, lamp), (SceneObject(0, 0), SceneObject(1, 1)), CAMERA)
    filled = fill(device, shaders, scene)
    x, y, z = filled.positions.T
    beside = (np.abs(x + 1.0) < 1e-3) & (np.abs(y - 0.42) < 0.04) & (np.abs(z) < 0.25)
    sees_it = beside & (np.abs(filled.points[..., 0] + 1.0).max(axis=1) < 1e-3)
    # Where panels were drawn by power alone, nine of 31 found it.
    assert sees_it.sum() > 20 and (filled.direct[sees_it, 0] > 0.0).mean() > 0.9


def placed(mesh: Mesh, size: tuple[float, ...], middle: tuple[float, ...]) -> Mesh:
    return Mesh(mesh.positions * size + np.array(middle), mesh.triangles)


def test_no_body_sends_more_than_fills_the_hemisphere(device, shaders) -> None:
    """A ball glows on a stand that it touches, in a black room that receives all it sends."""
    room = Mesh(2.0 * box().positions, box().triangles[:, ::-1])
    ball = placed(sphere(16), (0.1, 0.1, 0.1), (0.1, -0.6, 0.2))
    stand = placed(box(), (0.06, 0.3, 0.06), (0.1, -0.85, 0.2))
    black, lamp = Material(albedo=(0.0,) * 3), Material(albedo=(0.0,) * 3, emission=(1.0,) * 3)
    objects = SceneObject(0, 0), SceneObject(1, 1), SceneObject(2, 0)
    scene = Scene((room, ball, stand), (black, lamp), objects, CAMERA)
    # Of texels that are all alike, which the mean of surfels below takes for granted.
    settings = SurfaceCacheSettings(surfels=16384)
    filled = fill(device, shaders, scene, settings, by_tree=True)
    # Two estimators, each of which brings no more than that.
    assert filled.direct[:, 0].max() < 1.2 * np.pi
    top = np.abs(filled.positions - (0.1, -0.7, 0.2)).max(axis=1) < 0.04
    assert filled.direct[top, 0].max() > 0.5 * np.pi
    inside = np.abs(np.abs(filled.positions).max(axis=1) - 1.0) < 1e-3
    inside &= filled.direct[:, 0] > 0.0
    corners = ball.positions[ball.triangles]
    edges = corners[:, 1:] - corners[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=-1).sum()
    # What the stand keeps is the tenth that is missing.
    received = 24.0 * filled.direct[inside, 0].mean()
    assert 0.8 < received / (np.pi * area) < 1.0


def two_rooms(thickness: float, tessellation: int) -> Scene:
    """Return a box of 2 x 1 x 1 with a wall in its middle and a lamp on its left."""
    room = tessellated(box(), tessellation)
    inward = Mesh(room.positions * (2.0, 1.0, 1.0), room.triangles[:, ::-1])
    wall = Mesh(box().positions * (thickness, 1.0, 1.0) + (0.013, 0.0, 0.0), box().triangles)
    white = Material(albedo=(0.8, 0.8, 0.8))
    lamp = PointLight(position=(-0.4, 0.1, 0.2), intensity=(1.0, 1.0, 1.0))
    return Scene((inward, wall), (white,), (SceneObject(0, 0), SceneObject(1, 0)), CAMERA, (lamp,))


def tessellated(mesh: Mesh, count: int) -> Mesh:
    """Return `mesh` with every triangle cut into four, `count` times."""
    corners = mesh.positions[mesh.triangles]
    for _ in range(count):
        a, b, c = np.moveaxis(corners, 1, 0)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    return Mesh(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))


@pytest.mark.parametrize("tessellation", [0, 3, 6])
def test_no_light_goes_through_a_thin_wall(device, shaders, tessellation) -> None:
    filled = fill(device, shaders, two_rooms(1e-3, tessellation), FEW)
    x, y, z = filled.positions.T
    inside = (np.abs(x) < 1.0) & (np.abs(y) < 0.5) & (np.abs(z) < 0.5)
    inside &= np.abs(x - 0.013) > 1e-3
    lit = filled.irradiance[inside & (x < 0.013), 0].mean()
    dark = filled.irradiance[inside & (x > 0.013), 0].mean()
    assert lit > 1.0
    assert dark < 1e-3 * lit


def test_what_shows_between_two_bodies_is_not_darkened_by_what_they_cover(device, shaders) -> None:
    """The floor of a groove as wide as it is deep sees sqrt(2) - 1 of an even sky."""
    boxes = []
    for low, high in ((-0.1, 0.45), (0.55, 1.1)):
        matrix = np.diag([high - low, 1.2, 0.2, 1.0])
        matrix[:3, 3] = (low + high) / 2, 0.5, 0.0
        boxes.append(SceneObject(1, 0, matrix[None]))
    floor = Mesh(quad().positions, quad().triangles)
    scene = Scene(
        (floor, box()),
        (Material(albedo=(0.0, 0.0, 0.0)),),
        (SceneObject(0, 0), *boxes),
        CAMERA,
        environment=ConstantEnvironment((1.0, 1.0, 1.0)),
    )
    # No more surfels than that, or the floor is cut finer beside the bodies.
    filled = fill(device, shaders, scene, SurfaceCacheSettings(surfels=64, texel=0.6))
    x, _, z = filled.points.transpose(2, 0, 1)
    shows = np.all((x > 0.45) & (x < 0.55) & (z > 0.0) & (z < 1e-3), axis=1)
    # The whole floor has few texels, each with a part that lies in the groove alone.
    assert 1 <= shows.sum() <= 4
    expected = np.pi * (np.sqrt(2.0) - 1.0)
    # 64 rays of each, from the middle of the groove, where it sees 8 % more than on average.
    np.testing.assert_allclose(filled.irradiance[shows].mean(), expected, rtol=0.2)


def moved(scene: Scene, scale: float, offset: float) -> Scene:
    """Return the scene in other units, its lamp as bright as seen from its surfaces."""
    matrix = np.diag([scale, scale, scale, 1.0])
    matrix[:3, 3] = offset
    objects = tuple(dataclasses.replace(o, world_from_object=matrix[None]) for o in scene.objects)
    lamp = scene.lights[0]
    place = scale * np.array(lamp.position) + offset
    lamp = PointLight(tuple(place), tuple(np.array(lamp.intensity) * scale**2))
    return dataclasses.replace(scene, objects=objects, lights=(lamp,))


@pytest.mark.parametrize(("scale", "offset"), [(1e-3, 0.0), (1e4, 0.0), (1.0, 1e5)])
def test_unit_and_place_of_a_scene_do_not_matter(device, shaders, scale, offset) -> None:
    scene = two_rooms(0.1, 0)
    here = fill(device, shaders, scene, FEW)
    there = fill(device, shaders, moved(scene, scale, offset), FEW)
    assert len(there.irradiance) == len(here.irradiance)
    # Rounding decides which of two surfaces a few rays meet, not what arrives.
    ratio = there.irradiance.sum(axis=0) / here.irradiance.sum(axis=0)
    np.testing.assert_allclose(ratio, 1.0, rtol=1e-4)
    same = np.isclose(there.irradiance, here.irradiance, rtol=1e-3, atol=1e-6)
    assert same.mean() > 0.98


@pytest.mark.parametrize("kept", [0.0, 0.5, 0.9, 0.99])
def test_relaxation_converges_for_every_part_of_the_spectrum(kept) -> None:
    spectrum = kept * np.linspace(-1.0, 1.0, 41)
    last_but_one, last = np.zeros(41), np.zeros(41)
    for over in relaxation(kept):
        bounced = 1.0 + spectrum * last
        last_but_one, last = last, last_but_one + over * (bounced - last_but_one)
    np.testing.assert_allclose(last, 1.0 / (1.0 - spectrum), rtol=2e-4)


def seen_in_turn(device, shaders, order: tuple[int, ...], albedo: float) -> Bounces:
    """Return bounces between surfels all of whose rays meet the one that `order` names."""
    words = np.zeros((2, 2, SURFELS_PER_ROW, 2), dtype=np.uint32)
    grey = round(albedo * 65535.0)
    words[:, :, : len(order), 0] = np.array(order, dtype=np.uint32) | np.uint32(grey << 16)
    words[:, :, : len(order), 1] = grey | grey << 16
    # The rays of a row lie beside each other, each as a block of all surfels.
    data = words.reshape(2, 2 * SURFELS_PER_ROW, 2)
    hits = make_texture(device.gl, (2 * SURFELS_PER_ROW, 2), 2, "u4", data)
    facts = {"surfel_points": SimpleNamespace(count=len(order))}
    context = SimpleNamespace(gl=device.gl, facts=facts, shaders=shaders)
    return Bounces(context, hits, 2, glossy=False)  # type: ignore[arg-type]


def summed(bounces: Bounces, direct, kept: float, *, is_plain: bool):
    last, last_but_one = bounces.texture(0.0), bounces.texture(0.0)
    for over in relaxation(kept, is_plain=is_plain):
        last_but_one, last = last, bounces.step(direct, last, last_but_one, over)
    return last


@pytest.mark.parametrize(("order", "grows"), [((1, 2, 0), True), ((1, 0), False)])
def test_light_that_goes_round_in_circles_is_found_and_summed(
    device, shaders, order, grows
) -> None:
    albedo = 0.92
    bounces = seen_in_turn(device, shaders, order, albedo)
    kept = bounces.share_kept()
    assert kept == pytest.approx(albedo, abs=1e-4)
    arriving = np.zeros((1, SURFELS_PER_ROW, 4), dtype=np.float32)
    arriving[0, 0, :3] = 1.0
    direct = make_texture(device.gl, (SURFELS_PER_ROW, 1), 4, "f4", arriving)
    light = summed(bounces, direct, kept, is_plain=False)
    assert bounces.grow(kept, direct, light) == grows
    if grows:
        light = summed(bounces, direct, kept, is_plain=True)
    seen = np.eye(len(order))[list(order)]
    expected = np.linalg.solve(np.eye(len(order)) - albedo * seen, np.eye(len(order))[0])
    found = read_texture(light)[0, : len(order), 0]
    np.testing.assert_allclose(found, expected, rtol=1e-3)

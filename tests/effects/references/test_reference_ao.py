"""Ray-traced visibility against closed forms (FIELD 4.4), and its own promises."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from oracle.closed_forms import (
    box_corner_occlusion,
    corner_occlusion,
    sphere_on_plane_occlusion,
)
from oracle.monte_carlo import worst_deviation
from passes.pass_harness import box, make_scene, quad
from passes.ray_harness import Tracer

from ssdo_gl.effects.references.reference_ao import ReferenceAoPass, ReferenceAoSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh
from ssdo_gl.scene.geometry.shapes import sphere
from ssdo_gl.scene.scene import Scene

SIZE = (24, 16)
RUNS = 32
FACETS = 192  # around a sphere
# Rays start 4e-6 of the scene's half-diagonal off the surface; of the visibility of a
# point at distance d from a wall that changes some 1e-5 / d. Scenes here are 20 across.
START_ALLOWANCE = 1e-4


def floor_camera(x: float, height: float = 1.0) -> Camera:
    """Look straight down on the floor y = 0 at (x, 0, 0); +x to the right."""
    return Camera((x, height, 0.0), (x, 0.0, 0.0), up=(0.0, 0.0, -1.0), fov_y=50.0)


def floor() -> Mesh:
    return quad([-10, 0, 10], [20, 0, 0], [0, 0, -20])


def ao(scene: Scene, radius: float, spp: int = 16, **more: object) -> ReferenceAoPass:
    settings = ReferenceAoSettings(radius=radius, spp=spp, **more)  # type: ignore[arg-type]
    return ReferenceAoPass(settings, RayFeatures.of(scene))


def test_corner_matches_the_closed_form(device, shaders) -> None:
    wall = quad([0, 0, 10], [0, 0, -20], [0, 10, 0])
    scene = make_scene([floor(), wall], camera=floor_camera(0.6, 0.8))
    radius = 0.7
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(ao(scene, radius), RUNS)["visibility"][..., 0]
        distance = tracer.positions_ws()[..., 0]
    assert distance.min() > 0.0
    exact = 1.0 - corner_occlusion(distance / radius)
    assert worst_deviation(runs, exact, START_ALLOWANCE, rays=RUNS * 16) <= 1.0
    # The same data must refuse the unweighted hemisphere (A2): the test can fail.
    uniform = 1.0 - np.clip(1.0 - distance / radius, 0.0, 1.0) / 2.0
    assert worst_deviation(runs, uniform, START_ALLOWANCE, rays=RUNS * 16) > 1.0


def test_box_corner_matches_the_closed_form(device, shaders) -> None:
    walls = [quad([0, 0, 10], [0, 0, -20], [0, 10, 0]), quad([-10, 0, 0], [20, 0, 0], [0, 10, 0])]
    camera = Camera((0.4, 0.6, 0.3), (0.4, 0.0, 0.3), up=(0.0, 0.0, -1.0), fov_y=50.0)
    scene = make_scene([floor(), *walls], camera=camera)
    radius = 0.9
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(ao(scene, radius), RUNS)["visibility"][..., 0]
        at = tracer.positions_ws()
    k = np.clip(at[..., [0, 2]] / radius, 0.0, 1.0)
    exact = np.array([[1.0 - box_corner_occlusion(*pair) for pair in row] for row in k])
    assert worst_deviation(runs, exact, START_ALLOWANCE, rays=RUNS * 16) <= 1.0


@pytest.mark.parametrize("radius", [5.0, np.inf])
def test_sphere_on_a_plane_matches_the_closed_form(device, shaders, radius: float) -> None:
    ball = sphere(FACETS)
    ball = dataclasses.replace(ball, positions=ball.positions + [0.0, 1.0, 0.0])
    scene = make_scene([floor(), ball], camera=floor_camera(2.5, 1.6))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        runs = tracer.runs(ao(scene, radius), RUNS)["visibility"][..., 0]
        at = tracer.positions_ws()
    rho = np.hypot(at[..., 0], at[..., 2])
    exact = 1.0 - sphere_on_plane_occlusion(rho, 1.0)
    # Facets lie up to (pi / FACETS)^2 / 2 of its radius inside the sphere: they cover
    # twice that share less.
    allowance = START_ALLOWANCE + (np.pi / FACETS) ** 2
    assert worst_deviation(runs, exact, allowance, rays=RUNS * 16) <= 1.0


def test_open_plane_and_background_are_exactly_open(device, shaders) -> None:
    scene = make_scene([quad([-1, 0, 1], [2, 0, 0], [0, 0, -2])], camera=floor_camera(0.9, 0.5))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        images = tracer.run(ao(scene, np.inf), ["z_vs"])
    assert (images["z_vs"] == 0.0).any()
    assert (images["z_vs"] > 0.0).any()
    np.testing.assert_array_equal(images["visibility"], 1.0)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("offset", [0.0, 1e5])
def test_a_closed_room_leaks_nothing_at_any_scale_and_place(device, shaders, scale, offset) -> None:
    room = box([-1, -1, -1], [1, 1, 1])
    pillar = box([0.2, -1, -0.5], [0.5, 0.3, -0.2])
    move = offset * np.array([1.0, -1.0, 0.5])
    meshes = [dataclasses.replace(m, positions=m.positions * scale + move) for m in (room, pillar)]
    # On the diagonal, and an odd size: the room's edge falls on pixel centres.
    eye, target = np.full(3, 0.6) * scale + move, np.full(3, -1.0) * scale + move
    scene = make_scene(meshes, camera=Camera(tuple(eye), tuple(target), fov_y=90.0))
    with Tracer(device, shaders, scene, (63, 63)) as tracer:
        image = tracer.run(ao(scene, np.inf, spp=64))["visibility"]
    # At 1e5, positions come in steps of 1.5e-11: a scene of 1e-3 is built 1e-8 crooked.
    np.testing.assert_array_equal(image, 0.0)


def test_scale_and_place_do_not_change_the_image(device, shaders) -> None:
    def picture(scale: float, offset: float) -> np.ndarray:
        move = offset * np.array([1.0, -1.0, 0.5])
        meshes = [
            dataclasses.replace(m, positions=m.positions * scale + move)
            for m in (floor(), box([0.1, 0, -0.3], [0.5, 0.6, 0.3]))
        ]
        camera = floor_camera(0.0, 3.0)
        camera = dataclasses.replace(
            camera,
            position=tuple(np.array(camera.position) * scale + move),
            target=tuple(np.array(camera.target) * scale + move),
        )
        scene = make_scene(meshes, camera=camera)
        with Tracer(device, shaders, scene, SIZE) as tracer:
            return tracer.run(ao(scene, 0.8 * scale, spp=64))["visibility"]

    base = picture(1.0, 0.0)
    assert 0.2 < base.min() < 0.9
    for scale, offset in ((1e-3, 0.0), (1e4, 0.0), (1.0, 1e5)):
        # The same rays: only one that grazes an edge may end differently.
        differing = np.abs(picture(scale, offset) - base) > 1e-6
        assert differing.mean() < 0.02
        assert np.abs(picture(scale, offset) - base).max() <= 2.0 / 64.0


def test_longer_rays_never_brighten(device, shaders) -> None:
    scene = make_scene([floor(), box([0.1, 0, -0.3], [0.5, 0.6, 0.3])], camera=floor_camera(0.0, 2))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        images = [tracer.run(ao(scene, r))["visibility"] for r in (0.0, 0.1, 0.3, 1.0, np.inf)]
    np.testing.assert_array_equal(images[0], 1.0)
    for shorter, longer in itertools.pairwise(images):
        assert np.all(longer <= shorter)
    assert images[-1].min() < 0.7


def test_the_same_seed_gives_the_same_bytes_another_does_not(device, shaders) -> None:
    scene = make_scene([floor(), box([0.1, 0, -0.3], [0.5, 0.6, 0.3])], camera=floor_camera(0.0, 2))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = ao(scene, 1.0)
        first, second = tracer.run(item, seed=3), tracer.run(item, seed=4)
        again = tracer.run(item, seed=3)
    np.testing.assert_array_equal(first["visibility"], again["visibility"])
    assert (first["visibility"] != second["visibility"]).any()


def test_the_reported_error_is_the_real_one(device, shaders) -> None:
    wall = quad([0, 0, 10], [0, 0, -20], [0, 10, 0])
    scene = make_scene([floor(), wall], camera=floor_camera(0.6, 0.8))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = ao(scene, np.inf, spp=32)
        reported = []
        images = []
        for seed in range(24):
            images.append(tracer.run(item, seed=seed)["visibility"][..., 0])
            reported.append(item.statistics["standard_error"]["visibility"])
    actual = np.sqrt(np.mean(np.var(images, axis=0, ddof=1)))
    # Both are estimates; with 24 runs of 384 pixels each is good to a few per cent.
    assert np.sqrt(np.mean(np.square(reported))) == pytest.approx(actual, rel=0.1)
    assert item.statistics["spp"] == 32
    assert item.statistics["stopped_by"] == "spp"
    assert not item.statistics["partial"]


def test_low_discrepancy_points_beat_independent_ones(device, shaders) -> None:
    wall = quad([0, 0, 10], [0, 0, -20], [0, 10, 0])
    scene = make_scene([floor(), wall], camera=floor_camera(0.6, 0.8))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = ao(scene, np.inf, spp=256)
        image = tracer.run(item)["visibility"][..., 0].astype(np.float64)
    independent = np.sqrt(np.mean(image * (1.0 - image)) / 256.0)
    assert item.statistics["standard_error"]["visibility"] < 0.5 * independent


def test_it_stops_at_the_wanted_error(device, shaders) -> None:
    wall = quad([0, 0, 10], [0, 0, -20], [0, 10, 0])
    scene = make_scene([floor(), wall], camera=floor_camera(0.6, 0.8))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        totals = []
        item = ao(scene, np.inf, spp=1 << 20, max_error=0.01)
        tracer.run(item, progress=lambda _, done, total: totals.append((done, total)))
    assert all(done <= total for done, total in totals)
    # What is left is told from the error that is left, not from the limit.
    assert totals[-1][1] < 100 * totals[-1][0] < totals[0][1]
    assert item.statistics["stopped_by"] == "max_error"
    assert item.statistics["spp"] < 1 << 14
    assert item.statistics["relative_standard_error"]["visibility"] <= 0.01


def test_an_interrupt_keeps_what_has_converged(device, shaders) -> None:
    scene = make_scene([floor(), box([0.1, 0, -0.3], [0.5, 0.6, 0.3])], camera=floor_camera(0.0, 2))

    def interrupt(label: str, done: int, total: int) -> None:
        assert (label, total) == ("ray-traced visibility", 64)
        if done == 3:
            raise KeyboardInterrupt

    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = ao(scene, 1.0, spp=2048)
        partial = tracer.run(item, progress=interrupt)["visibility"]
        statistics = dict(item.statistics)
        full = tracer.run(ao(scene, 1.0, spp=2048), seed=1)["visibility"]
    assert statistics["partial"]
    assert statistics["stopped_by"] == "interrupt"
    assert statistics["spp"] == 96
    assert np.abs(partial - full).max() < 0.2
    assert np.abs(partial - full).mean() < 0.02


@pytest.mark.parametrize("spp", [1, 2, 3, 33])
def test_any_number_of_rays_is_a_mean(device, shaders, spp: int) -> None:
    scene = make_scene([floor(), box([0.1, 0, -0.3], [0.5, 0.6, 0.3])], camera=floor_camera(0.0, 2))
    with Tracer(device, shaders, scene, SIZE) as tracer:
        item = ao(scene, np.inf, spp=spp)
        image = tracer.run(item)["visibility"]
    np.testing.assert_allclose(image * spp, np.rint(image * spp), atol=1e-4)
    assert image.min() >= 0.0
    assert image.max() <= 1.0
    assert item.statistics["spp"] == spp
    assert (item.statistics["standard_error"]["visibility"] is None) == (spp == 1)

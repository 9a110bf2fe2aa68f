"""Light of glowing bodies that no light of the scene stands for, against closed forms."""

from __future__ import annotations

import dataclasses
from collections.abc import Container, Sequence

import numpy as np
import pytest
import scene_text as text
from meshes import showing
from oracle.closed_forms import rectangle_form_factor
from oracle.monte_carlo import worst_deviation
from passes.pass_harness import make_scene, quad
from passes.ray_harness import Tracer

from ssdo_gl.effects.emitters import EmittersPass, EmittersSettings
from ssdo_gl.passes.rays import GlowTreePass
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.emissive_meshes import MAX_LIGHTS, SAMPLE_COUNT
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.light_bodies import MOST_PANELS
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

SIZE = (24, 16)
# Of 24 runs of 8 rays a pixel in 384 misses a panel that brings a fifth of its light.
RUNS = 48
CAMERA = Camera((0.5, 1.6, 0.2), (0.5, 0.0, 0.2), up=(0.0, 0.0, -1.0), fov_y=60.0)
FLOOR = quad([-10, 0, 10], [20, 0, 0], [0, 0, -20])
# As far as rays start off the floor: see tests/effects/shadows/test_traced_shadows.py.
ALLOWANCE = 2e-4
# What the filter does not blur, a few pixels wide, can be compared pixel by pixel.
UNFILTERED = {"emitters.rays": 64, "emitters_filter.filter": "none"}
# RMSE over the mean close to a lamp. Where all of its light is filtered it is 1.5.
BLUR_BOUND = 0.5
# Deviation of pictures by 16 rays a pixel from seed to seed, over their mean. If only how far the
# middles of strips are counts it is 2.1.
STRIP_NOISE = 1.8
# Drawn by area, where triangles subtend little, it is .85.
TUBE_NOISE = 0.4
ONE_FRAME = {"emitters_filter.filter": "none", "emitters.summed_panels": 0}
ROOM_OF_WALL = (
    text.camera([0, 0, 3], [0, 0, 0])
    + text.material("grey", 0.5, 0.5, 0.5)
    + text.material("glow", 0, 0, 0, emission=[8, 4, 2])
)
ROOM = (
    text.camera([0, 2.5, 3], [0, 0.2, 0])
    + text.material("grey", 0.5, 0.5, 0.5)
    + text.material("black", 0, 0, 0)
    + text.material("glow", 0, 0, 0, emission=[8, 4, 2])
    + text.floor(6, "grey")
    + text.box([-0.3, 0, -0.3], [0.3, 0.5, 0.3], "grey")
)


def panels(count: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return corner and edges of panels that face every way, none before another from below."""
    rng = np.random.default_rng(count)
    found = []
    for i in range(count):
        place = np.array([0.6 * (i % 4) - 0.4, 2.0, 0.6 * (i // 4) - 0.6])
        edge_u, edge_v = (0.1 * rng.normal(size=3) for _ in range(2))
        found.append((place, edge_u, edge_v))
    return found


def glowing(count: int, two_sided: bool) -> tuple[Scene, list[np.ndarray]]:
    """Return a floor under `count` panels, and the corners of each."""
    shapes = panels(count)
    emissions = [(3.0, 2.0, 1.0), (1.0, 4.0, 9.0)]
    materials = [Material(albedo=(0.5,) * 3)] + [
        Material(albedo=(0.0,) * 3, emission=e, two_sided_emission=two_sided) for e in emissions
    ]
    objects = [SceneObject(0, 0)] + [SceneObject(1 + i, 1 + i % 2) for i in range(count)]
    scene = make_scene(
        [FLOOR, *(quad(*shape) for shape in shapes)],
        materials=materials,
        objects=objects,
        camera=CAMERA,
    )
    return scene, [np.array([c, c + u, c + u + v, c + v]) for c, u, v in shapes]


@pytest.mark.parametrize("two_sided", [False, True])
@pytest.mark.parametrize("count", [1, 11])
def test_many_panels_match_lamberts_formula(device, shaders, count: int, two_sided: bool) -> None:
    scene, corners = glowing(count, two_sided)
    features = dataclasses.replace(RayFeatures.of(scene), glow_is_direct=True)
    with Tracer(device, shaders, scene, SIZE) as tracer:
        many, run = (
            tracer.runs(
                EmittersPass(EmittersSettings(rays, summed_panels=0), features, is_crowd=False),
                RUNS,
                [GlowTreePass(stand_ins=False)],
            )
            for rays in (64, 8)
        )
        summed = tracer.runs(
            EmittersPass(EmittersSettings(8), features, is_crowd=False),
            2,
            [GlowTreePass(stand_ins=False)],
        )
        at = tracer.positions_ws()
    runs = many["emitters_raw"][..., :3]
    assert (run["emitters_whole"] == 1.0).all()
    exact = np.zeros((*at.shape[:2], 3))
    for i, panel in enumerate(corners):
        emission = np.array(scene.materials[1 + i % 2].emission)
        front = np.cross(panel[1] - panel[0], panel[3] - panel[0])
        seen = np.einsum("yxk,k->yx", at - panel[0], front) > 0.0
        factor = [
            [rectangle_form_factor(panel - p, np.array([0.0, 1.0, 0.0])) for p in r] for r in at
        ]
        factor = np.abs(factor) * (seen | two_sided)
        exact += np.pi * factor[..., None] * emission
    assert exact.max() > 0.0
    assert worst_deviation(runs, exact, ALLOWANCE * exact.max()) <= 1.0
    means, whole = runs.mean(axis=(1, 2)), exact.mean(axis=(0, 1))
    assert worst_deviation(means, whole, ALLOWANCE * exact.max()) <= 1.0
    assert worst_deviation(means, whole * 1.01, ALLOWANCE * exact.max()) > 1.0
    # The filter is told their sum, and its noise as of rays drawn apart: points of a sequence have
    # less, on one panel next to none.
    light, variance = np.moveaxis(run["emitters_light"], -1, 0)
    np.testing.assert_allclose(light, run["emitters_raw"][..., :3].sum(axis=-1), rtol=1e-5)
    # Summed up they need no rays, which find next to nothing before them.
    found = summed["emitters_whole"][..., :3]
    np.testing.assert_allclose(found, np.broadcast_to(exact, found.shape), atol=2e-4 * exact.max())
    np.testing.assert_allclose(summed["emitters_raw"].mean(), 1.0, atol=1e-3)
    assert (0.0 if count == 1 else 0.1) < light.var(axis=0, ddof=1).mean() / variance.mean() < 1.2


def room(count: int, lit: Sequence[int]) -> Scene:
    """Return a block on a floor under `count` balls, of which those numbered `lit` glow."""
    balls = "".join(
        text.ball(
            [0.5 * i - 1, 0.8, 0.3 * (i % 2)], 0.1, "glow" if i in lit else "black", segments=8
        )
        for i in range(count)
    )
    return read_description(ROOM + balls, "room")


def direct(scene: Scene, **fields: object) -> np.ndarray:
    """Return the direct light of a picture of `scene`."""
    with Renderer(scene, Settings(size=(48, 32), **fields)) as renderer:
        return renderer.render(["direct"]).images["direct"].astype(np.float64)


def traced(scene: Scene, rays: int = 256) -> np.ndarray:
    """Return direct light by many rays to the triangles of all that is a light."""
    return direct(scene, method="direct", shadows="traced", shadow_rays=rays)


def assert_alike(found: np.ndarray, exact: np.ndarray) -> None:
    assert found.mean(axis=(0, 1)) == pytest.approx(exact.mean(axis=(0, 1)), rel=0.01)
    assert np.sqrt(((found - exact) ** 2).mean()) < 0.15 * exact.mean()


def test_balls_light_as_their_triangles_do() -> None:
    scene = room(2, lit=[0, 1])
    assert_alike(direct(scene, method="gi", overrides=UNFILTERED), traced(scene))


def test_what_lies_close_to_a_lamp_is_not_blurred_in_a_picture() -> None:
    """Under a tube light changes within the few pixels that a filter takes together."""
    ends = {"base": [-1.2, 0.08, 0.9], "top": [1.2, 0.08, 0.9]}
    tube = text.body("cylinder", "glow", **ends, radius=0.02, segments=8)
    scene = read_description(ROOM + tube, "room")
    found = direct(scene, method="gi", antialias=16)
    exact = direct(scene, method="gi", antialias=16, overrides=UNFILTERED)
    assert np.sqrt(((found - exact) ** 2).mean()) < BLUR_BOUND * exact.mean()


def boxes_on_a_wall() -> Scene:
    """Return 25 thin boxes that glow; their narrow sides alone light the wall."""
    boxes = "".join(
        text.box([x, y, 0.0], [x + 0.4, y + 0.4, 0.02], "glow")
        for x in np.arange(-1.25, 1.0, 0.5).tolist()
        for y in np.arange(-1.25, 1.0, 0.5).tolist()
    )
    wall = text.quad([-4, -4, 0], [8, 0, 0], [0, 8, 0], "grey")
    return read_description(ROOM_OF_WALL + wall + boxes, "room")


def test_few_rays_tell_how_much_of_a_sum_arrives() -> None:
    """Of most sides others hide much; rays to those that send the most tell it without a bias."""
    scene = boxes_on_a_wall()
    summed = ONE_FRAME | {"emitters.summed_panels": 150}
    found, many = (
        np.mean([direct(scene, method="gi", overrides=each, seed=i) for i in range(4)])
        for each in (summed, summed | {"emitters.rays": 64})
    )
    assert found == pytest.approx(many, rel=0.02)


def test_rays_find_the_narrow_sides_of_boxes_that_hang_on_a_wall() -> None:
    """They lie within spheres around fronts that send far more."""
    scene = boxes_on_a_wall()
    runs = [direct(scene, method="gi", overrides=ONE_FRAME, seed=seed) for seed in range(6)]
    noise = np.std(runs, axis=0, ddof=1).mean() / np.mean(runs)
    assert noise < STRIP_NOISE


def test_points_of_a_long_tube_are_drawn_where_it_is_near() -> None:
    """Of its triangles most of the area is ten times as far away as the wall is."""
    tube = text.body("cylinder", "glow", base=[-1, 0, 0.1], top=[1, 0, 0.1], radius=0.012)
    wall = text.quad([-4, -4, 0], [8, 0, 0], [0, 8, 0], "grey")
    scene = read_description(ROOM_OF_WALL + wall + tube, "room")
    runs = [direct(scene, method="gi", overrides=ONE_FRAME, seed=seed) for seed in range(6)]
    assert np.std(runs, axis=0, ddof=1).mean() < TUBE_NOISE * np.mean(runs)


def test_no_pixel_beneath_a_body_is_brighter_than_it_can_be() -> None:
    """Of small triangles that nearly touch a floor points alone brought four times as much."""
    ball = text.ball([0, 0.3, 0], 0.3, "glow", segments=64)
    materials = ROOM_OF_WALL.removeprefix(text.camera([0, 0, 3], [0, 0, 0]))
    camera = text.camera([0, 1.2, 3], [0, 0.2, 0])
    scene = read_description(camera + materials + text.floor(6, "grey") + ball, "room")
    runs, many = (
        np.array([direct(scene, method="gi", overrides=each, seed=i) for i in range(8)])
        for each in (ONE_FRAME, ONE_FRAME | {"emitters.rays": 64})
    )
    filled = 0.5 * np.array([8.0, 4.0, 2.0])
    assert (many.mean(axis=0).max(axis=(0, 1)) > 0.5 * filled).all()
    assert (runs.max(axis=(0, 1, 2)) < filled).all()
    assert runs.mean() == pytest.approx(many.mean(), rel=0.01)


def test_more_bodies_than_may_be_lights_shine_all() -> None:
    """A ball has eight sample rectangles, of which a scene may have 32."""
    scene = room(5, lit=range(5))
    assert len(scene.lights) == MAX_LIGHTS == 4 * SAMPLE_COUNT
    each = [traced(room(5, lit=[i])) for i in range(5)]
    assert_alike(direct(scene, method="gi", overrides=UNFILTERED), np.sum(each, axis=0))


def test_panels_with_an_image_light_from_where_it_is_bright() -> None:
    panel = text.quad([-0.9, 0.7, 0.6], [0, 0.3, -0.9], [1.8, 0, 0], "glow")
    scene = read_description(ROOM + panel, "room")
    pixels = np.zeros((16, 16, 4), np.float32)
    pixels[2:9, 6:15], pixels[..., 3] = 1.0, 1.0
    scene = showing(scene, pixels)
    pictures = [direct(scene, method="gi", seed=i, overrides=UNFILTERED) for i in range(4)]
    assert_alike(np.mean(pictures, axis=0), traced(scene, 4096))


def strips(count: int, lit: Container[int]) -> str:
    """Return strips side by side over the floor, of which those numbered `lit` glow."""
    corners = ([0.05 * i - 0.95, 0.7, -0.8] for i in range(count))
    names = ("glow" if i in lit else "black" for i in range(count))
    return "".join(
        text.quad(corner, [0.02, 0, 0], [0, 0, 1.6], name)
        for corner, name in zip(corners, names, strict=True)
    )


@pytest.mark.parametrize("count", [4, 5])
def test_few_panels_alone_are_exact_lights_beside_panes(count: int) -> None:
    """What is translucent casts another shadow of each light in each frame, for rays to walk to."""
    pane = text.material("pane", 0.5, 0.5, 0.5, roughness=0.5, opacity=0.5)
    pane += text.quad([-0.9, 0.2, 0.4], [1.8, 0, 0], [0, 0.4, 0], "pane")
    scene = read_description(ROOM + pane + strips(count, range(count)), "room")
    assert len(scene.lights) == count
    with Renderer(scene, Settings(size=SIZE, method="gi")) as renderer:
        ran = {item.name for item in renderer.render(["beauty"]).passes if item.ran}
    assert "shadow_map" not in ran
    assert ("emitters" in ran) == (count > MOST_PANELS)
    if count > MOST_PANELS:
        found = [direct(scene, method="gi", seed=i, overrides=UNFILTERED) for i in range(4)]
        exact = [
            direct(scene, method="direct", shadows="traced", shadow_rays=64, seed=i)
            for i in range(4)
        ]
        assert_alike(np.mean(found, axis=0), np.mean(exact, axis=0))


def test_panels_beyond_all_lights_take_the_others_along() -> None:
    """As rays go to some of them anyway, no exact light is made of the others, and no map."""
    scene = read_description(ROOM + strips(36, range(36)), "room")
    assert len(scene.lights) == MAX_LIGHTS
    glossy = dataclasses.replace(
        scene, materials=[dataclasses.replace(m, specular=1.0) for m in scene.materials]
    )
    with Renderer(glossy, Settings(size=SIZE, method="gi")) as renderer:
        ran = {item.name for item in renderer.render(["beauty"]).passes if item.ran}
    assert "emitters" in ran
    assert "shadow_map" not in ran
    found = [direct(scene, method="gi", seed=i, overrides=UNFILTERED) for i in range(4)]
    exact = [
        sum(
            direct(
                read_description(ROOM + strips(36, part), "room"),
                method="direct",
                shadows="traced",
                shadow_rays=64,
                seed=i,
            )
            for part in (range(18), range(18, 36))
        )
        for i in range(4)
    ]
    assert_alike(np.mean(found, axis=0), np.mean(exact, axis=0))


def test_what_glows_is_gathered_once() -> None:
    """By shadow rays, not by those that gather light."""
    scene = room(5, lit=range(5))
    means = []
    for method in ("gi", "reference-gi"):
        with Renderer(scene, Settings(size=(48, 32), method=method, spp=256)) as renderer:
            means.append(renderer.render(["beauty"]).images["beauty"].mean())
    assert means[0] == pytest.approx(means[1], rel=0.02)

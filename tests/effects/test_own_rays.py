"""Per-pixel rays at rest, and more where a neighbour in front may shade."""

from __future__ import annotations

import dataclasses
import gc
import weakref
from typing import Any

import numpy as np
import pytest
from passes.pass_harness import box, make_scene, quad

from ssdo_gl.effects import gathered_light, own_rays
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.passes.far_probes import FarFieldSettings
from ssdo_gl.render_result import Drawing
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, MapEnvironment
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.settings import Settings

SIZE = (64, 48)
SKY = ConstantEnvironment((1.0, 0.5, 0.25))
WALL = quad([-3, -3, 0], [6, 0, 0], [0, 6, 0])
# A black plate so near to the wall that no pixel shows more than a sliver of what it covers.
PLATE = quad([-0.5, -1.5, 0.02], [1, 0, 0], [0, 2, 0])
CAMERA = Camera((0.0, 1.9, 2.0), (0.0, 0.3, 0.0), fov_y=40.0)
MATERIALS = [Material(albedo=(0.5,) * 3), Material(albedo=(0.0,) * 3)]


def plate() -> Scene:
    objects = [SceneObject(0, 0), SceneObject(1, 1)]
    return make_scene(
        [WALL, PLATE], materials=MATERIALS, objects=objects, environment=SKY, camera=CAMERA
    )


def drawn(scene: Scene, method: str = "gi", **fields: Any) -> np.ndarray:
    settings = Settings(method=method, size=SIZE, radius=0.3, **fields)
    with Renderer(scene, settings) as renderer:
        return renderer.render(("beauty",)).images["beauty"][..., :3]


def renderer_of(scene: Scene) -> Renderer:
    return Renderer(scene, Settings(method="gi", size=SIZE, radius=0.3, temporal="off"))


def live(renderer: Renderer) -> Drawing:
    return renderer.draw(("beauty",), camera=CAMERA, index=0, count=4)


def beauty(drawing: Drawing) -> np.ndarray:
    return np.array(drawing.planes["beauty"].read()[..., :3])


def at_rest(renderer: Renderer) -> np.ndarray:
    while not (drawing := live(renderer)).is_settled:
        pass
    return beauty(drawing)


def test_what_an_edge_in_front_shades_is_as_dark_as_by_paths() -> None:
    def error(**overrides: int) -> float:
        found = drawn(plate(), overrides=overrides)
        return float(np.square(found - paths).mean())

    paths = drawn(plate(), "reference-gi", spp=256)
    assert error() < 0.5 * error(**{"far_field.edge_rays": 0})


@pytest.mark.parametrize(
    "scene",
    [
        make_scene([WALL], materials=MATERIALS[:1], environment=SKY, camera=CAMERA),
        make_scene([box([-4] * 3, [4] * 3)], materials=MATERIALS[:1], camera=CAMERA),
    ],
    ids=["plane", "corners"],
)
def test_no_pixel_of_what_is_open_or_hollow_has_any(scene: Scene) -> None:
    some = drawn(scene)
    assert np.array_equal(some, drawn(scene, overrides={"far_field.edge_rays": 0}))


def test_a_window_has_them_at_rest_and_then_no_more_is_traced(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    traced: list[tuple[int, int]] = []
    original = own_rays.OwnRaysPass._trace

    def record(item: Any, context: Any, rays: Any, rows: tuple[int, int]) -> None:
        traced.append(rows)
        original(item, context, rays, rows)

    monkeypatch.setattr(own_rays.OwnRaysPass, "_trace", record)
    with renderer_of(plate()) as renderer:
        first = beauty(live(renderer))
        assert len(traced) == 1
        while not (drawing := live(renderer)).is_settled:
            pass
        last, count = beauty(drawing), len(traced)
        again = beauty(live(renderer))
    assert 1 <= count == len(traced)
    assert not np.array_equal(first, last)
    assert np.array_equal(last, again)
    # Together all rows, each once.
    assert [low for low, _ in traced] == [0, *(high for _, high in traced[:-1])]


def test_what_only_tracing_reads_is_not_kept_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    guides: list[weakref.ref[Any]] = []
    original = own_rays.OwnRaysPass._guide

    def remembered(item: Any, context: Any) -> Any:
        made = original(item, context)
        guides.append(weakref.ref(made))
        return made

    monkeypatch.setattr(own_rays.OwnRaysPass, "_guide", remembered)
    with renderer_of(plate()) as renderer:
        while not live(renderer).is_settled:
            pass
        gc.collect()
        assert len(guides) == 1
        assert guides[0]() is None


def test_a_frame_that_was_given_up_has_its_rays_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with renderer_of(plate()) as renderer:
        expected = at_rest(renderer)
    original = own_rays.OwnRaysPass._trace
    turns = []

    def give_up(*arguments: Any) -> None:
        original(*arguments)
        turns.append(None)
        if len(turns) == 2:
            raise InterruptedError

    monkeypatch.setattr(own_rays.OwnRaysPass, "_trace", give_up)
    with renderer_of(plate()) as renderer:
        with pytest.raises(InterruptedError):
            at_rest(renderer)
        assert np.array_equal(at_rest(renderer), expected)


def test_pixels_that_estimators_of_half_the_size_leave_out_trace_at_full_size() -> None:
    """A governor tries lower quality before the picture is refined: of the same view."""
    with renderer_of(plate()) as renderer:
        expected = at_rest(renderer)
    with renderer_of(plate()) as renderer:
        full = renderer.settings
        renderer.use(dataclasses.replace(full, resolution_scale=0.5))
        assert not np.array_equal(at_rest(renderer), expected)
        renderer.use(full)
        assert np.array_equal(at_rest(renderer), expected)


def gap(width: float = 1.0, camera: Camera = CAMERA) -> Scene:
    """Return a wall under the sky through a gap between four black lids, which most rays miss."""
    lids = [quad([x, -50, 3], [100, 0, 0], [0, 100, 0]) for x in (-100 - width / 2, width / 2)]
    lids += [quad([-width / 2, y, 3], [width, 0, 0], [0, 100, 0]) for y in (-100.0, width)]
    objects = [SceneObject(0, 0), *(SceneObject(i, 1) for i in range(1, 5))]
    return make_scene(
        [WALL, *lids], materials=MATERIALS, objects=objects, environment=SKY, camera=camera
    )


def pictures(scene: Scene, **fields: Any) -> np.ndarray:
    return np.array([drawn(scene, seed=seed, **fields) for seed in range(6)])


def test_rays_that_follow_the_light_are_quieter_and_find_as_much(monkeypatch) -> None:
    scene = gap()
    guided = pictures(scene)

    def no_guide(item: Any, context: Any) -> Any:
        size = context.inputs["far_radiance"].size
        return make_texture(context.gl, size, 4, "f4", np.zeros((size[1], size[0], 4), "f4"))

    monkeypatch.setattr(own_rays.OwnRaysPass, "_guide", no_guide)
    even = pictures(scene)
    assert guided.std(axis=0).mean() < 0.75 * even.std(axis=0).mean()
    assert guided.mean() == pytest.approx(even.mean(), rel=0.03)


def test_light_from_few_directions_is_averaged_over_pixels_about(monkeypatch) -> None:
    averaged, even = pictures(gap()), drawn(plate())
    fill = own_rays.fill

    def by_no_variance(context: Any, made: Any, shader: str, *others: Any) -> None:
        if shader == "effects/own_spread.frag":
            defines, uniforms, reads = others
            size = reads["t_light"].size
            none = make_texture(context.gl, size, 2, "f4", np.zeros((*size[::-1], 2), "f4"))
            others = defines, uniforms, {**reads, "t_light": none}
        fill(context, made, shader, *others)

    monkeypatch.setattr(own_rays, "fill", by_no_variance)
    noisy = pictures(gap())
    assert averaged.std(axis=0).mean() < 0.6 * noisy.std(axis=0).mean()
    assert averaged.mean() == pytest.approx(noisy.mean(), rel=0.03)
    # Where light comes from everywhere nothing is.
    assert np.array_equal(even, drawn(plate()))


def test_light_that_few_rays_find_is_spread_and_none_of_it_lost(monkeypatch) -> None:
    def of_pixels_alone(item: Any, context: Any, rays: Any) -> Any:
        far, near, places, *_, rare, aimed = rays.traced
        numbers = np.frombuffer(places.read(), np.int32)[::2]
        shown = []
        for parts in ((far, rare, aimed), (near,)):
            found, *more = (np.frombuffer(part.read(), np.float32).reshape(-1, 4) for part in parts)
            found = found + (*(1.0, 1.0, 1.0), 0.0) * sum(more, np.zeros_like(found))
            of_pixels = np.where(numbers[:, None] != 0, found[abs(numbers) - 1], 0.0)
            data = of_pixels.astype(np.float32)
            shown.append(make_texture(context.gl, places.size, 4, "f4", data))
        return places, *shown

    spread = pictures(gap(0.5))
    monkeypatch.setattr(own_rays.OwnRaysPass, "_averaged", of_pixels_alone)
    dots = pictures(gap(0.5))
    assert spread.max() < 0.3 * dots.max()
    assert spread.std(axis=0).mean() < 0.4 * dots.std(axis=0).mean()
    assert spread.mean() == pytest.approx(dots.mean(), rel=0.03)


def test_all_frames_of_a_view_use_the_rays_of_a_surface_seen_along_itself() -> None:
    camera = Camera((0.0, -2.6, 0.3), (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), fov_y=30.0)
    places = slice(SIZE[1] // 2 + 6, None)
    one, several = (
        pictures(gap(camera=camera), antialias=count).std(axis=0)[places].mean() for count in (1, 4)
    )
    assert several < one


def test_no_frame_takes_rays_of_a_wall_for_those_of_its_floor() -> None:
    """Half of the sky, behind the wall, is a hundred times as bright as the other."""
    image = np.full((16, 32, 3), 0.02, np.float32)
    # The middle columns lie along -z.
    image[:, 8:24] = 2.0
    floor, wall = quad([-3, 0, 3], [6, 0, 0], [0, 0, -3]), quad([-3, 0, 0], [6, 0, 0], [0, 3, 0])
    scene = make_scene(
        [floor, wall],
        objects=[SceneObject(0, 0), SceneObject(1, 0)],
        materials=MATERIALS,
        environment=MapEnvironment(image),
        camera=Camera((0.0, 1.0, 2.5), (0.3, 0.0, 0.0), fov_y=40.0),
    )
    joint = drawn(scene, antialias=4).sum(axis=2)[16:28, 8:56]
    # Dots are 3.9 times as bright as their row where some frames show the floor by the wall's rays.
    assert (joint / np.median(joint, axis=1, keepdims=True)).max() < 2.0


def slivers() -> Scene:
    """Return bars a third of a pixel wide under the sky, of which few show at a pixel's centre."""
    bars = [quad([0.031 * i - 1.0, -1.0, 0.0], [0.01, 0, 0], [0, 2.0, 0]) for i in range(64)]
    # So that the view is not of a box alone.
    ground = quad([-9, -9, -3], [18, 0, 0], [0, 18, 0])
    return make_scene([*bars, ground], materials=MATERIALS[:1], environment=SKY, camera=CAMERA)


def test_a_frame_traces_rays_of_what_no_frame_before_has_shown(monkeypatch) -> None:
    traced = []
    original = gathered_light.trace

    def noting(*arguments: Any, **more: Any) -> None:
        traced.append(more["many"])
        original(*arguments, **more)

    monkeypatch.setattr(gathered_light, "trace", noting)
    found = drawn(slivers(), antialias=4)
    # But of the one whose pixels have traced.
    assert traced == 3 * [FarFieldSettings().edge_rays]
    paths = drawn(slivers(), "reference-gi", antialias=4, spp=64)
    assert found == pytest.approx(paths, rel=0.15)
    assert found.mean() == pytest.approx(paths.mean(), rel=0.01)


def test_pixels_have_rays_only_where_light_is_gathered(monkeypatch) -> None:
    counts = []
    original = own_rays.places_of

    def record(chosen: Any, *arguments: Any) -> Any:
        counts.append(len(chosen))
        return original(chosen, *arguments)

    monkeypatch.setattr(own_rays, "places_of", record)
    for scale in (1.0, 0.5):
        drawn(plate(), resolution_scale=scale)
    assert counts[0] == 4 * counts[1]


def test_every_pixel_of_a_huge_frame_has_a_place_that_devices_have() -> None:
    size = (8192, 4320)
    chosen, many = np.arange(0, size[0] * size[1], 7), 1000
    places, pixels = own_rays.places_of(chosen, many, size)
    assert max(pixels.shape) <= 16384
    columns, rows = pixels.reshape(-1, 2)[: len(chosen)].astype(int).T
    assert np.array_equal(columns + size[0] * rows, chosen)
    assert np.array_equal(np.flatnonzero(places), chosen)
    # Floats hold no odd number above 2^24.
    assert places.dtype == np.int32
    found = places[rows, columns, 0]
    assert np.array_equal(abs(found), np.arange(1, len(chosen) + 1))
    assert (found[:many] < 0).all()
    assert (found[many:] > 0).all()
    assert (pixels.reshape(-1, 2)[len(chosen) :] == -1.0).all()


def test_how_pixels_are_laid_out_changes_no_picture(monkeypatch) -> None:
    usual = drawn(plate())
    monkeypatch.setattr(own_rays, "PIXELS_PER_ROW", 7)
    monkeypatch.setattr(own_rays, "MOST_ROWS", 3)
    assert np.array_equal(drawn(plate()), usual)


def courtyard_with_a_pane() -> Scene:
    scene = load_scene("courtyard")
    glass = Material(albedo=(0.6, 0.7, 0.8), alpha=0.4, blends=True)
    pane = SceneObject(len(scene.meshes), len(scene.materials))
    return dataclasses.replace(
        scene,
        meshes=(*scene.meshes, quad([-1.0, 0.2, 0.0], [2.0, 0.0, 0.0], [0.0, 1.2, 0.0])),
        materials=(*scene.materials, glass),
        objects=(*scene.objects, pane),
    )


def test_what_is_translucent_does_not_keep_pixels_from_tracing() -> None:
    def error(method: str = "gi") -> float:
        settings = Settings(method=method, size=SIZE, antialias=16)
        with Renderer(scene, settings) as renderer:
            found = renderer.render().images["beauty"][..., :3].astype(float)
        return float(np.mean((found - paths) ** 2 / (paths**2 + 0.01)))

    scene = courtyard_with_a_pane()
    with Renderer(scene, Settings("reference-gi", size=SIZE, antialias=16, spp=16)) as renderer:
        paths = renderer.render().images["beauty"][..., :3].astype(float)
    assert error() < 0.02 * error("bounce")


def test_frames_of_a_pane_depend_on_none_before() -> None:
    def frame(renderer: Renderer, index: int) -> np.ndarray:
        drawing = renderer.draw(("beauty",), camera=scene.camera, index=index, count=16)
        return beauty(drawing)

    scene = courtyard_with_a_pane()
    settings = Settings("gi", size=SIZE, temporal="off")
    with Renderer(scene, settings) as renderer, Renderer(scene, settings) as other:
        first, second = frame(renderer, 0), frame(renderer, 1)
        assert np.array_equal(second, frame(other, 1))
    assert not np.array_equal(first, second)

"""Skips over time: what cannot have changed is kept, what may have is not.

After every change the images are those of a renderer that has seen nothing else.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from properties.planned_and_full import (
    AGREEMENT,
    BLACK,
    DAWN,
    FRONT,
    GREY,
    LAMP,
    OFF,
    PILE,
    QUAD,
    SIZE,
    at,
    make_scene,
)

from ssdo_gl.gpu.program import Program
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Motion
from ssdo_gl.settings import AOVS, Settings

SCENE = make_scene(*PILE, lights=[LAMP], environment=DAWN)
SETTINGS = Settings("bounce", size=SIZE, radius=0.5, samples=32, steps=4)


def painted(scene, albedo):
    materials = tuple(dataclasses.replace(m, albedo=albedo) for m in scene.materials)
    return dataclasses.replace(scene, materials=materials)


def with_object(scene, number, **changes):
    objects = list(scene.objects)
    objects[number] = dataclasses.replace(objects[number], **changes)
    return dataclasses.replace(scene, objects=tuple(objects))


def names(result, kept):
    """Return the passes that ran, or those whose results were kept."""
    return {row.name for row in result.passes if ("kept" in row.reason if kept else row.ran)}


def assert_same(device, shaders, scene, images, **settings):
    """Compare with what a fresh renderer shows with every effect."""
    full = dataclasses.replace(SETTINGS, effects="full", **settings)
    with Renderer(scene, full, device=device, shaders=shaders) as fresh:
        wanted = fresh.render(AOVS).images
    for name, image in wanted.items():
        bound = AGREEMENT * max(1.0, float(np.abs(image).max(initial=0.0)))
        assert float(np.abs(image - images[name]).max(initial=0.0)) <= bound, name


@pytest.fixture
def renderer(device, shaders):
    with Renderer(SCENE, SETTINGS, device=device, shaders=shaders) as made:
        made.render(AOVS)
        yield made


REDDER = dataclasses.replace(LAMP, intensity=(20.0, 20.0, 19.0))
# A change, and a pass that must run again for it.
CHANGES = {
    "nothing": ({}, None),
    "the light's colour": ({"lights": (REDDER,)}, "direct"),
    "the sky's colour": (
        {"environment": dataclasses.replace(DAWN, ground=(0.2, 0.2, 0.201))},
        "directional",
    ),
    "the camera": ({"camera": dataclasses.replace(FRONT, position=(0.0, 0.0, 6.001))}, "gbuffer"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_still_view_is_kept_and_one_that_almost_is_is_not(device, shaders, renderer, change):
    changes, runs = CHANGES[change]
    scene = dataclasses.replace(SCENE, **changes)
    renderer.use_scene(scene)
    result = renderer.render(AOVS)
    assert names(result, kept=False) >= ({runs} if runs else set())
    assert bool(names(result, kept=False)) == bool(runs)
    assert_same(device, shaders, scene, result.images)


def test_lamps_in_view_leave_no_trail(device, shaders):
    """Before a box: their image is cleared only where one is seen, which differs by view."""
    glowing = Material(albedo=GREY, emission=(3.0, 2.0, 1.0))
    small = at(-0.7, -0.4, 0.8) @ np.diag([0.3, 0.3, 0.3, 1.0])
    lamp = (QUAD, small, glowing)
    scene = make_scene(*PILE, lamp, lights=[LAMP])
    plain = dataclasses.replace(SETTINGS, method="direct")
    with Renderer(scene, plain, device=device, shaders=shaders) as renderer:
        for x in (0.0, 0.15, -0.1, 9.0, 0.05):
            camera = dataclasses.replace(FRONT, position=(x, 0.2, 6.0), target=(x, 0.0, 0.0))
            seen = dataclasses.replace(scene, camera=camera)
            renderer.use_scene(seen)
            found = renderer.render(("beauty",)).images["beauty"]
            full = dataclasses.replace(plain, effects="full")
            with Renderer(seen, full, device=device, shaders=shaders) as fresh:
                wanted = fresh.render(("beauty",)).images["beauty"]
            assert np.any(wanted > 2.9) == (x < 9.0)
            assert float(np.abs(found - wanted).max()) <= AGREEMENT * 3.0


def test_another_seed_is_another_frame(device, shaders, renderer):
    renderer.use(dataclasses.replace(SETTINGS, seed=1))
    result = renderer.render(AOVS)
    assert "directional" in names(result, kept=False)
    assert names(result, kept=True) >= {"gbuffer", "back_faces", "shadow_map"}
    assert_same(device, shaders, SCENE, result.images, seed=1)


SHADOWS = {
    "another camera": (
        dataclasses.replace(
            SCENE, camera=dataclasses.replace(FRONT, position=(1.0, 0.5, 5.0), fov_y=30.0)
        ),
        False,
    ),
    "another colour of the light": (
        dataclasses.replace(SCENE, lights=(REDDER,)),
        # The map could be kept. A light counts as changed whatever of it has.
        True,
    ),
    "another place of the light": (
        dataclasses.replace(SCENE, lights=(dataclasses.replace(LAMP, position=(1.5, 3.0, 2.4)),)),
        True,
    ),
    "a caster moved": (with_object(SCENE, 1, world_from_object=at(-0.6, -0.4, 0)[None]), True),
    "a caster gone": (dataclasses.replace(SCENE, objects=SCENE.objects[:2]), True),
}


@pytest.mark.parametrize("case", SHADOWS)
def test_shadow_maps_are_kept_while_light_and_casters_stand(device, shaders, renderer, case):
    scene, is_made_again = SHADOWS[case]
    renderer.use_scene(scene)
    result = renderer.render(AOVS)
    assert ("shadow_map" in names(result, kept=False)) == is_made_again
    assert ("shadow_map" in names(result, kept=True)) != is_made_again
    assert_same(device, shaders, scene, result.images)


def test_what_moves_casts_its_shadow_anew(device, shaders):
    spinning = with_object(SCENE, 2, motion=Motion(spin=(0.0, 45.0, 0.0)))
    with Renderer(spinning, SETTINGS, device=device, shaders=shaders) as moving:
        moving.render(AOVS)
        still = moving.render(AOVS)
        later = moving.render(AOVS, seconds=0.5)
    assert not names(still, kept=False)
    assert "shadow_map" in names(later, kept=False)
    assert np.any(later.images["direct"] != still.images["direct"])


@pytest.fixture
def compiled(monkeypatch):
    """Collect every program that is compiled."""
    found: list[Program] = []
    replace = Program.replace

    def watched(self, vertex, fragment):
        found.append(self)
        replace(self, vertex, fragment)

    monkeypatch.setattr(Program, "replace", watched)
    return found


STEPS = {
    "as it is": (SCENE, {"direct", "shadow_map", "directional", "bounce"}),
    "the light off": (dataclasses.replace(SCENE, lights=(OFF,)), {"directional", "bounce"}),
    "everything black": (painted(SCENE, BLACK), {"direct", "shadow_map", "directional"}),
    "the sky gone": (
        dataclasses.replace(SCENE, environment=None), {"direct", "shadow_map", "bounce"},
    ),
    "a plain sky": (
        dataclasses.replace(SCENE, environment=ConstantEnvironment(GREY)),
        {"direct", "shadow_map", "directional", "bounce"},
    ),
    "nothing lit": (
        dataclasses.replace(SCENE, environment=None, lights=(OFF,)), set(),
    ),
}  # fmt: skip
DECIDED = {"direct", "shadow_map", "directional", "ssao", "bounce"}
# The pictures of a running scene.
WANTED = ("display",)


def test_a_change_in_a_running_scene_changes_the_next_plan_and_compiles_nothing_twice(
    device, compiled
):
    library = ShaderLibrary(device.gl)
    counts = []
    with Renderer(SCENE, SETTINGS, device=device, shaders=library) as running:
        for _ in range(2):
            for scene, expected in STEPS.values():
                running.use_scene(scene)
                before = len(compiled)
                result = running.render(WANTED)
                planned = {item.name for item in running._planned.graph.order}
                assert planned & DECIDED == expected
                assert names(result, kept=False) | names(result, kept=True) == planned
                counts.append(len(compiled) - before)
    first, again = counts[: len(STEPS)], counts[len(STEPS) :]
    # Each change compiles the variants that it needs and nothing else; seen again, none.
    assert first[0] > max(first[1:]) > 0
    assert again == [0] * len(STEPS)
    assert len({id(program) for program in compiled}) == len(compiled) == len(library._by_name)


@pytest.mark.parametrize("step", list(STEPS)[1:])
def test_after_such_a_change_the_images_are_right(device, shaders, renderer, step):
    scene, _ = STEPS[step]
    renderer.use_scene(scene)
    assert_same(device, shaders, scene, renderer.render(AOVS).images)
    renderer.use_scene(SCENE)
    assert_same(device, shaders, SCENE, renderer.render(AOVS).images)


def test_paint_of_another_colour_is_seen_at_once(device, shaders, renderer):
    scene = painted(SCENE, (0.5, 0.5, 0.4))
    renderer.use_scene(scene)
    result = renderer.render(AOVS)
    assert "gbuffer" in names(result, kept=False)
    assert_same(device, shaders, scene, result.images)

"""The Python interface: many frames, several renderers, and the documented examples."""

from __future__ import annotations

import dataclasses
import doctest

import numpy as np
import pytest

import ssdo_gl
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError

SMALL = Settings(size=(32, 18), samples=8)


def test_the_documented_examples_run():
    """The docstrings of the interface are examples that run."""
    results = doctest.testmod(ssdo_gl.renderer)
    assert results.attempted >= 5
    assert results.failed == 0


def test_public_names():
    assert {"load_scene", "Renderer", "render", "Settings"} <= set(ssdo_gl.__all__)
    for name in ssdo_gl.__all__:
        assert getattr(ssdo_gl, name)
    with pytest.raises(AttributeError, match="no attribute 'rendr'"):
        ssdo_gl.rendr  # noqa: B018


def test_a_static_second_frame_runs_no_pass():
    with Renderer(ssdo_gl.load_scene("cornell_meso"), SMALL) as renderer:
        ran = [row.name for row in renderer.render().passes if row.ran]
        second = {row.name: row for row in renderer.render().passes}
        assert "gbuffer" in ran
        for name in ran:
            assert not second[name].ran
            assert "kept" in second[name].reason


def test_a_moved_camera_keeps_what_is_the_scenes():
    scene = ssdo_gl.load_scene("cornell_meso")
    with Renderer(scene, SMALL) as renderer:
        renderer.render()
        moved = renderer.render(camera=dataclasses.replace(scene.camera, position=(0.1, 0, 3.5)))
        kept = {row.name for row in moved.passes if "kept" in row.reason}
        # What rays find, and the light on surfaces, is the scene's, whoever looks.
        of_the_scene = {"bvh_upload", "surface_tables", "material_table", "emitter_tables"}
        cache = {"surfels", "surfel_rays", "surfel_sky", "surfel_direct", "surface_cache"}
        assert kept == of_the_scene | cache | {"bright_tables"}


def test_a_picture_is_seen_from_the_camera_that_is_given():
    scene = load_scene("corner")
    place = scene.camera.orbit(20.0)
    flags = {"size": (32, 18), "method": "direct"}
    expected = ssdo_gl.render(scene.with_camera(place), **flags)
    assert np.array_equal(ssdo_gl.render("corner", camera=place, **flags), expected)
    assert np.array_equal(ssdo_gl.render(scene, camera=place, **flags), expected)
    assert not np.array_equal(ssdo_gl.render("corner", camera="fit", **flags), expected)
    for given in ((0, 1, 3), True):
        with pytest.raises(SettingError, match="camera"):
            ssdo_gl.render("corner", camera=given, **flags)


def test_what_is_no_scene_is_answered_with_all_that_is_one():
    mesh = load_scene("corner").meshes[0]
    with pytest.raises(SceneError, match="expected a Scene, or its name or path, got a Mesh"):
        ssdo_gl.render(mesh)


def test_renderers_do_not_disturb_each_other():
    """Two contexts in one process: each call draws with its own."""
    scene = ssdo_gl.load_scene("corner")
    with Renderer(scene, SMALL) as first, Renderer(scene, SMALL) as second:
        before = first.render().images["beauty"]
        second.render()
        first.use(dataclasses.replace(SMALL, seed=1))
        first.use(SMALL)
        assert np.array_equal(before, first.render().images["beauty"])
        assert first.device.gl.error == second.device.gl.error == "GL_NO_ERROR"


def test_timed_frames_recompute_what_depends_on_the_view(monkeypatch):
    with Renderer(ssdo_gl.load_scene("corner"), SMALL) as renderer:
        run, drawn = renderer._run, []
        monkeypatch.setattr(renderer, "_run", lambda *rest: (drawn.append(1), run(*rest))[1])
        result = renderer.render(frames=3, time_passes=True)
    assert len(result.frame_ms) == 3
    # One makes what is kept, another compiles what computes a view again.
    assert len(drawn) == 2 + 3
    times = {row.name: row.gpu_ms for row in result.passes if row.ran}
    assert times["gbuffer"] > 0.0
    assert result.setup_ms > 0.0


def test_time_moves_an_animated_scene():
    with Renderer(ssdo_gl.load_scene("carousel"), SMALL) as renderer:
        start = renderer.render().images["beauty"]
        later = renderer.render(seconds=0.7).images["beauty"]
        again = renderer.render(seconds=0.0).images["beauty"]
    assert not np.array_equal(start, later)
    assert np.array_equal(start, again)


def test_antialiasing_softens_edges_and_keeps_areas():
    scene = ssdo_gl.load_scene("cornell_meso")
    images = []
    for count in (1, 8):
        with Renderer(scene, dataclasses.replace(SMALL, antialias=count)) as renderer:
            images.append(renderer.render(["albedo"]).images["albedo"])
    assert len(np.unique(images[1])) > 2 * len(np.unique(images[0]))
    # Eight samples of the same areas: the mean moves by a fraction of a percent.
    assert images[1].mean() == pytest.approx(images[0].mean(), rel=0.02)


def test_settings_are_checked():
    with pytest.raises(SettingError, match="samples = 0"):
        ssdo_gl.render("corner", samples=0)


def test_fields_that_were_not_given_yield_to_the_scene(device, shaders):
    """As flags do, both where a renderer is made and where it gets other settings."""
    scene = dataclasses.replace(load_scene("corner"), render={"samples": 16, "size": (20, 10)})
    with Renderer(scene, Settings(steps=4), device=device, shaders=shaders) as renderer:
        assert (renderer.settings.samples, renderer.settings.steps) == (16, 4)
        assert renderer.render().images["beauty"].shape == (10, 20, 4)
        renderer.use(Settings(samples=64))
        assert (renderer.settings.samples, renderer.settings.size) == (64, (20, 10))


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"wanted": ["beauty", "shine"]}, "image 'shine': choose of beauty, .*, display"),
        ({"wanted": ["beuty"]}, "image 'beuty': .*; did you mean 'beauty'"),
        ({"wanted": [None]}, "image None"),
        ({"wanted": "beauty"}, "expected a list of names"),
        ({"wanted": None}, "images = None: expected a list of names"),
        ({"wanted": [["beauty"]]}, r"image \['beauty'\]: choose of"),
        ({"seconds": float("nan")}, "seconds = nan"),
        ({"seconds": "1"}, "seconds = '1': expected a finite number"),
        ({"frames": 0}, "frames = 0"),
        ({"frames": "2"}, "frames = '2': expected a whole number"),
    ],
)
def test_what_cannot_be_rendered_is_refused_by_name(asked, said):
    """A black image of a name that does not exist would be taken for an answer."""
    with Renderer(load_scene("corner"), SMALL) as renderer:
        with pytest.raises(SettingError, match=said):
            renderer.render(**asked)
        if said.startswith("image"):
            with pytest.raises(SettingError, match=said):
                renderer.time_frame(asked["wanted"])

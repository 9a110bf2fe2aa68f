"""Files that are opened in a viewer: scenes, models and presets, good and bad."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from window.driven_viewer import SETTINGS, FakeHost, ask, said, settle

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.window import scene_flight
from ssdo_gl.window.actions import perform
from ssdo_gl.window.input.bindings import Action, Command
from ssdo_gl.window.opening import opened
from ssdo_gl.window.opening.opened import open_file


def test_bad_file_keeps_the_scene_and_says_why(gl, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    bad = tmp_path / "broken.obj"
    bad.write_text("v nonsense")
    assert not open_file(str(bad), viewer)
    assert "broken.obj" in said(viewer)
    assert any(line.is_fault for line in viewer.messages.lines)
    settle(viewer)
    assert np.array_equal(viewer.presenter.pixels(), before)


def test_dropped_model_replaces_the_scene(gl, viewer, tmp_path) -> None:
    settle(viewer)
    before = viewer.presenter.pixels()
    model = tmp_path / "triangle.obj"
    model.write_text("v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n")
    assert open_file(str(model), viewer)
    settle(viewer)
    assert viewer.source == str(model)
    assert viewer.settings.samples == SETTINGS.samples
    assert viewer.view.method == viewer.settings.method
    assert viewer.diagonal == pytest.approx(100.0 * 2**0.5)
    assert not np.array_equal(viewer.presenter.pixels(), before)
    assert viewer.presenter.pixels().std() > 5.0


def test_a_stray_decides_neither_the_pace_nor_what_fits_the_view(gl, viewer, tmp_path) -> None:
    model = tmp_path / "stray.obj"
    faces = "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
    body = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    model.write_text(body + faces)
    assert open_file(str(model), viewer)
    diagonal = viewer.diagonal
    ask(viewer, Command.FIT)
    expected = np.add(viewer.flight.position, viewer.flight.glide)
    model.write_text(f"{body}v 500 0 0\nv 500.1 0 0\nv 500 0.1 0\n{faces}f 5 6 7\n")
    assert open_file(str(model), viewer)
    assert viewer.diagonal == diagonal
    ask(viewer, Command.FIT)
    assert np.allclose(np.add(viewer.flight.position, viewer.flight.glide), expected)


def test_dropped_preset_is_taken_over_and_a_bad_one_is_not(gl, viewer, tmp_path) -> None:
    viewer.read_preset = load_preset
    good = tmp_path / "mine.toml"
    good.write_text('[settings]\nmethod = "ssdo"\nsamples = 24\n')
    assert not open_file(str(good), viewer), "the scene is still the same"
    assert (viewer.view.method, viewer.settings.samples) == ("ssdo", 24)
    assert viewer.source == "cornell_meso"
    bad = tmp_path / "bad.toml"
    bad.write_text("[settings]\nsamples = -3\n")
    before = viewer.settings
    assert not open_file(str(bad), viewer)
    assert viewer.settings == before
    assert viewer.messages.lines[-1].is_fault
    assert "bad.toml" in viewer.messages.lines[-1].text
    assert "samples" in viewer.messages.lines[-1].text
    assert list(viewer.presets) == ["mine"]


@pytest.mark.parametrize(
    "fields",
    [
        {"samples": 10**6},
        {"exposure": float("nan")},
        {"overrides": {"ssao.strenth": 2.0}},
        {"overrides": {"nothing.strength": 2.0}},
        {"estimater": "march"},
    ],
)
def test_preset_that_nobody_has_checked_is_a_message(gl, viewer, tmp_path, fields) -> None:
    viewer.read_preset = lambda path: fields
    file = tmp_path / "mine.toml"
    file.write_text("[settings]\n")
    before = viewer.settings, viewer.view
    open_file(str(file), viewer)
    assert (viewer.settings, viewer.view) == before
    assert viewer.messages.lines[-1].is_fault
    assert "mine.toml" in said(viewer)
    assert not viewer.presets


@pytest.mark.parametrize("error", [MemoryError(), RecursionError("deep"), ValueError("a\nb")])
def test_file_that_makes_a_reader_fail_is_a_message(gl, viewer, monkeypatch, error) -> None:
    def load(path: str) -> None:
        raise error

    monkeypatch.setattr(opened, "load_scene", load)
    before = viewer.scene
    assert not open_file("some.glb", viewer)
    assert viewer.scene is before
    assert "some.glb: cannot be opened" in said(viewer)
    assert "\n" not in said(viewer)


def test_scene_whose_settings_do_not_fit_is_shown_without_them(gl, viewer, tmp_path) -> None:
    file = tmp_path / "other.toml"
    file.write_text(
        '[render]\nestimator = "zbuffer"\nmethod = "ssao"\n[[object]]\nshape = "box"\n'
        "min = [0, 0, 0]\nmax = [1, 1, 1]\n"
    )
    viewer.settings = dataclasses.replace(viewer.settings, method="ssdo")
    assert open_file(str(file), viewer)
    assert "opened other.toml" in said(viewer)
    assert (viewer.settings.method, viewer.settings.estimator) == ("ssdo", None)
    settle(viewer)


@pytest.mark.parametrize("key", ["_take", "start_flight"])
def test_scene_that_cannot_be_flown_through_leaves_the_one_before(
    gl, viewer, tmp_path, monkeypatch, key: str
) -> None:
    settle(viewer)
    before = viewer._state()
    model = tmp_path / "triangle.obj"
    model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    def fail(*_: object) -> None:
        raise ValueError("no")

    target = viewer if key == "_take" else scene_flight
    monkeypatch.setattr(target, key, fail)
    assert not open_file(str(model), viewer)
    assert viewer._state() == before
    settle(viewer)


def test_saved_preset_can_be_chosen_again(gl, viewer) -> None:
    perform(Action(Command.SAVE_PRESET), viewer, FakeHost())
    viewer.settings = dataclasses.replace(viewer.settings, samples=64, overrides={"a.b": 1})
    viewer.choose_method("direct")
    viewer.choose_preset("preset-001")
    assert viewer.settings == SETTINGS
    assert viewer.view.method == SETTINGS.method


def test_what_is_asked_of_one_model_does_not_keep_scenes_out(gl, make_viewer, tmp_path) -> None:
    model = tmp_path / "model.obj"
    model.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n")
    viewer = make_viewer(str(model), up="z", normals="flat", ground="off", light="studio")
    other = tmp_path / "other.obj"
    other.write_text(model.read_text())
    assert open_file(str(other), viewer)
    loading = viewer.original.loading
    assert (loading.up, loading.normals, loading.ground) == (None, "flat", "off")
    assert open_file("corner", viewer), said(viewer)
    assert viewer.original.loading.light == "studio"

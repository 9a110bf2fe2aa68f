"""Scenes that are another one with changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError


def loaded(folder: Path, text: str) -> Scene:
    path = folder / "mine.toml"
    path.write_text(text)
    return load_scene(path)


def test_a_base_alone_is_the_base(tmp_path: Path) -> None:
    base, scene = load_scene("cornell_meso"), loaded(tmp_path, 'base = "cornell_meso"')
    assert scene.camera == base.camera
    assert scene.lights == base.lights
    assert (scene.title, scene.render, scene.environment) == (base.title, base.render, None)
    assert scene.triangle_count == base.triangle_count


def test_what_a_file_says_replaces_what_its_base_says(tmp_path: Path) -> None:
    text = """
base = "cornell_meso"
title = "Mine"
[camera]
exposure = 1.5
[environment]
kind = "constant"
radiance = [1, 2, 3]
[render]
method = "ssao"
[[edit]]
light = 1
emitted = [1, 1, 1]
place = [0, 0.5, 0]
"""
    base, scene = load_scene("cornell_meso"), loaded(tmp_path, text)
    assert scene.title == "Mine"
    assert scene.camera.exposure == 1.5
    assert scene.camera.position == base.camera.position
    assert scene.environment == ConstantEnvironment((1.0, 2.0, 3.0))
    assert scene.render == {**base.render, "method": "ssao"}
    assert scene.lights[0].emitted == (1.0, 1.0, 1.0)
    assert scene.lights[0].place == pytest.approx((0.0, 0.5, 0.0))
    # The body that is seen of it goes along.
    assert scene.objects != base.objects


def test_an_environment_can_be_taken_away(tmp_path: Path) -> None:
    assert load_scene("courtyard").environment is not None
    assert loaded(tmp_path, 'base="courtyard"\n[environment]\nkind="none"').environment is None


def test_a_model_beside_the_file_can_be_a_base(tmp_path: Path) -> None:
    (tmp_path / "triangle.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    scene = loaded(tmp_path, 'base = "triangle.obj"\n[camera]\nexposure = 0.5')
    assert scene.triangle_count == 1
    assert scene.camera.exposure == 0.5
    assert scene.metering_slack is None


def test_another_method_drops_the_estimator_of_the_base(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        'base = "corner"\n[render]\nmethod = "ssao"\nestimator = "zbuffer"'
    )
    scene = loaded(tmp_path, 'base = "a.toml"\n[render]\nmethod = "ssdo"')
    assert scene.render["method"] == "ssdo"
    assert "estimator" not in scene.render


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('base = "mine.toml"', "does not follow from mine.toml in turn"),
        ('base = "../other.toml"', "must not leave the folder"),
        ('base = "missing.toml"', "no such file"),
        ('base = "corne"', "no built-in scene is called that; did you mean 'corner'"),
        ('base = "corner"\n[[object]]\nshape = "box"', "object"),
        ('base = "corner"\n[[edit]]\nlight = 99', "light"),
        ('base = "corner"\n[[edit]]\nmaterial = 99', "material"),
        (
            'base = "corner"\n[[edit]]\nmaterial = 1\nroughness = 2',
            "roughness = 2: expected",
        ),
        ('base = "corner"\n[[edit]]\nmaterial = 1\nplace = [0, 0, 0]', "unknown key 'place'"),
        ('base = "corner"\n[environment]\nrotation_y = 10', "no map to turn"),
    ],
)
def test_faults_are_named(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(SceneError, match=said) as error:
        loaded(tmp_path, text)
    assert "mine.toml" in str(error.value)


def test_long_chains_and_circles_are_told_apart(tmp_path: Path) -> None:
    def chain(*bases: str) -> Scene:
        for number, base in enumerate(bases):
            (tmp_path / f"{number}.toml").write_text(f'base = "{base}"')
        return load_scene(tmp_path / "0.toml")

    numbered = [f"{number}.toml" for number in range(1, 17)]
    assert chain(*numbered[:15], "corner").triangle_count > 0
    with pytest.raises(SceneError, match="at most 16 scenes"):
        chain(*numbered, "corner")
    with pytest.raises(SceneError, match=r"15\.toml: base = '0.toml': expected a scene that does"):
        chain(*numbered[:15], "0.toml")


def model(folder: Path, name: str = "model.obj") -> None:
    (folder / name).write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nf 1 2 3\nf 1 2 4\n")


def test_a_file_says_how_its_base_is_read(tmp_path: Path) -> None:
    model(tmp_path)
    text = 'base = "model.obj"\n[load]\nup = "z"\nlight = "studio"\n'
    scene = loaded(tmp_path, text)
    asked = load_scene(tmp_path / "model.obj", up="z", light="studio")
    assert scene.bounds()[1] == pytest.approx(asked.bounds()[1])
    assert scene.environment.name == asked.environment.name == "studio"
    # Flags win; more light is beside the file's, not in its place.
    assert load_scene(tmp_path / "mine.toml", light="file").environment is None
    assert load_scene(tmp_path / "mine.toml", no_default_light=True).environment is None
    assert scene.add(load_scene("corner").lights[0]).environment is scene.environment


def test_the_way_of_reading_a_base_is_checked(tmp_path: Path) -> None:
    model(tmp_path)
    for line, fault in {
        'up = "x"': r"\[load\] up = 'x': expected one of y, z",
        "upp = 1": r"\[load\]: unknown key 'upp'; did you mean 'up'\?",
        'light = "../a.hdr"': r"\[load\] light = '../a.hdr': must not leave the folder",
        'light = "a.hdr"': r"\[load\] light = 'a.hdr': no such file",
        'camera = "Top"': r"mine.toml: \[load\] camera 'Top'",
        'light = "sky:3"': r"mine.toml: \[load\] light = 'sky:3': the sun is below",
    }.items():
        with pytest.raises(SceneError, match=fault):
            loaded(tmp_path, f'base = "model.obj"\n[load]\n{line}\n')


def test_all_of_a_scene_is_framed_whatever_camera_it_has(tmp_path: Path) -> None:
    text = 'base = "corner"\n[camera]\nposition = [9, 0, 0]\ntarget = [0, 0, 0]\nfov_y = 20.0\n'
    loaded(tmp_path, text)
    camera = load_scene(tmp_path / "mine.toml", camera="fit").camera
    assert camera == load_scene("corner").framed(None, 20.0, 0.0)
    loaded(tmp_path, text + 'projection = "orthographic"\n')
    assert load_scene(tmp_path / "mine.toml", camera="fit").camera.height is not None

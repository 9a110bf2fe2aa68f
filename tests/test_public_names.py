"""What `import ssdo_gl` offers, and how its objects describe themselves."""

from __future__ import annotations

import dataclasses
import io
import json
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import ssdo_gl
from ssdo_gl.images.display import picture_of
from ssdo_gl.images.files import OutputError


@pytest.fixture(scope="module")
def result():
    scene = ssdo_gl.load_scene("corner")
    with ssdo_gl.Renderer(scene, ssdo_gl.Settings(size=(16, 9), samples=8)) as renderer:
        return renderer.render(["beauty", "display", "depth"])


def test_everything_public_is_listed_and_there():
    public = {name for name in dir(ssdo_gl) if not name.startswith("__")}
    assert public == set(ssdo_gl.__all__) - {"__version__"}
    assert all(getattr(ssdo_gl, name) for name in ssdo_gl.__all__)


def test_listing_imports_nothing():
    code = "import sys, ssdo_gl; dir(ssdo_gl); ssdo_gl.Camera; assert 'moderngl' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_descriptions_are_one_short_line(result):
    scene = ssdo_gl.load_scene("courtyard")
    texture = ssdo_gl.Texture(np.zeros((2, 3, 4), np.uint8), "checker")
    material = ssdo_gl.Material("brick", albedo=(0.5, 0.2, 0.1), albedo_texture=texture)
    assert repr(material) == (
        "Material(name='brick', albedo=(0.5, 0.2, 0.1), albedo_texture=Texture('checker', 3x2))"
    )
    assert repr(scene).startswith("Scene('Courtyard under an open sky', ")
    assert f"{scene.triangle_count} triangles" in repr(scene)
    for item in (scene, *scene.meshes, *scene.objects, *scene.materials, result):
        assert len(repr(item)) < 200 and "\n" not in repr(item)
    assert repr(result).startswith("RenderResult(beauty display depth, 16x9, gi, ")


def test_settings_describe_what_was_given():
    assert repr(ssdo_gl.Settings()) == "Settings()"
    given = ssdo_gl.Settings(samples=64, overrides={"bounce.strength": 2.0})
    assert repr(given) == "Settings(samples=64, overrides={'bounce.strength': 2.0})"


def test_a_result_is_saved_as_pictures(result, tmp_path):
    result.save(tmp_path / "a.png")
    assert {path.name for path in tmp_path.iterdir()} == {"a.png", "a-depth.png"}
    with Image.open(tmp_path / "a.png") as image:
        shown = picture_of("display", result.images["display"])
        np.testing.assert_array_equal(np.asarray(image), shown)


def test_a_result_is_saved_as_numbers(result, tmp_path):
    result.save(str(tmp_path / "a.npz"))
    with np.load(tmp_path / "a.npz") as file:
        np.testing.assert_array_equal(file["depth"], result.images["depth"])
        assert json.loads(str(file["meta"]))["size"] == [16, 9]


# Of codes: half a step of the 16 bits of `display`, and the shader's pow().
SAME_PICTURE = 0.5 / 65535.0 + 4e-6


@pytest.mark.parametrize(
    ("scene", "chosen"),
    [
        ("sphere_on_plane", {}),
        ("corner", {"exposure": 1.5, "background": "#3366aa"}),
        ("sphere_on_plane", {"background": "transparent", "antialias": 4}),
        ("corner", {"overrides": {"tone_map.curve": "aces", "tone_map.exposure": 2.0}}),
    ],
)
def test_a_beauty_alone_has_the_picture_of_its_display(scene, chosen):
    settings = ssdo_gl.Settings("direct", size=(32, 18), **chosen)
    with ssdo_gl.Renderer(ssdo_gl.load_scene(scene), settings) as renderer:
        beauty = renderer.render()
        display = renderer.render(["display"]).images["display"]
    shown = beauty._shown_images()["display"]
    np.testing.assert_allclose(shown, display, rtol=0, atol=SAME_PICTURE)
    assert list(beauty.images) == ["beauty"]


def test_a_beauty_alone_is_exposed_where_that_is_left_to_the_picture():
    square = np.array([[-1.0, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]])
    lamp = ssdo_gl.PointLight(position=(0, 1.0, 0), intensity=(900.0, 900.0, 900.0))
    soot = ssdo_gl.Material(albedo=(0.02, 0.02, 0.02))
    scene = ssdo_gl.Scene.from_arrays(square, [[0, 1, 2], [0, 2, 3]], material=soot, lights=[lamp])
    assert scene.metering_slack is not None
    with ssdo_gl.Renderer(scene, ssdo_gl.Settings("direct", size=(32, 18))) as renderer:
        result = renderer.render()
        with Image.open(io.BytesIO(result._repr_png_())) as image:
            seen = np.asarray(image)[result.images["beauty"][..., 3] > 0.0]
        assert 100 < np.median(seen) < 250
        assert renderer.render(["display"]).metering_slack is None


def test_a_file_of_no_known_kind_is_refused(result, tmp_path):
    with pytest.raises(OutputError, match="suffix must be one of"):
        result.save(tmp_path / "a.tif")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ["png", "jpg", "webp", "exr", "npz"])
def test_a_beauty_is_saved_in_every_format(suffix, result, tmp_path):
    beauty = dataclasses.replace(result, images={"beauty": result.images["beauty"]})
    beauty.save(tmp_path / f"a.{suffix}")
    assert [path.name for path in tmp_path.iterdir()] == [f"a.{suffix}"]


def test_a_notebook_shows_the_picture(result):
    with Image.open(io.BytesIO(result._repr_png_())) as image:
        shown = picture_of("display", result.images["display"])
        np.testing.assert_array_equal(np.asarray(image), shown)


NUMPY_SETTINGS = {
    "radius": np.float32(0.5),
    "size": (np.int64(16), np.int32(9)),
    "samples": np.int16(16),
    "seed": np.int32(3),
    "resolution_scale": np.float32(0.5),
    "overrides": {"bounce.strength": np.float32(2.0)},
}


def test_numbers_of_numpy_are_settings(tmp_path):
    """They have no bit_length, overflow at their own size, and JSON takes none of them."""
    settings = ssdo_gl.Settings("bounce", **NUMPY_SETTINGS)
    camera = ssdo_gl.Camera((1, 1, 4), (0, 0, 0), fov_y=np.float32(30), exposure=np.float32(1))
    with ssdo_gl.Renderer(ssdo_gl.load_scene("corner"), settings) as renderer:
        result = renderer.render(camera=camera)
    for name in ("a.npz", "a.exr"):
        result.save(tmp_path / name)
    assert {path.name for path in tmp_path.iterdir()} == {"a.npz", "a.exr"}

"""A kind of light that only this file knows: one class and one shader, each in its folder."""

from __future__ import annotations

import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scene_text import body, camera, light, material

from ssdo_gl import resources
from ssdo_gl.gpu.shader import light_kinds_source
from ssdo_gl.math3d import Vector, vector
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene import lights
from ssdo_gl.scene.lights import KINDS, PointLight, PunctualLight, kind_number
from ssdo_gl.scene.lights.base import ShaderRow
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.material import Color
from ssdo_gl.settings import Settings


@dataclass(frozen=True)
class LobeLight(PunctualLight):
    """Shines along `direction`, by the fourth power of the cosine."""

    kind = "lobe"
    direction_fields = ("direction",)

    position: Vector
    direction: Vector
    intensity: Color

    @classmethod
    def from_table(cls, table, **common):
        direction = vector(np.array(table.direction("direction")))
        return cls(table.vector("position"), direction, table.color("intensity"), **common)

    def shader_row(self) -> ShaderRow:
        return ShaderRow(self.source, np.asarray(self.direction))


@pytest.fixture(autouse=True)
def _renderers_share_a_device() -> None:
    """None do here: shaders of other tests know nothing of a new kind."""


LOBE_GLSL = """
float lobe_falloff(Light light, vec3 to_light)
{
    float cosine = max(dot(-to_light, light.axis_vs), 0.0);
    return cosine * cosine * cosine * cosine;
}
"""


# A floor seen from straight above, and a lamp over its middle that shines down.
def floor_and_lamp(shadow: str) -> str:
    return (
        camera([0, 4, 0], [0, 0, 0], 40)
        + material("white", 1, 1, 1)
        + body("plane", "white", point=[0, 0, 0], normal=[0, 1, 0], size=20)
        + light(
            "lobe", position=[0, 2, 0], direction=[0, -1, 0], intensity=[3, 2, 1], shadow=shadow
        )
    )


@pytest.fixture
def lobe(monkeypatch, tmp_path):
    """Put a module among those of lights, and its shader beside the shipped ones."""
    folder = tmp_path / "shaders"
    shutil.copytree(str(resources.folder("shaders")), folder)
    (folder / "lights" / "lobe.glsl").write_text(LOBE_GLSL, encoding="utf-8")
    shipped = resources.folder
    monkeypatch.setattr(resources, "folder", lambda k: folder if k == "shaders" else shipped(k))
    (tmp_path / "lobe_light.py").write_text(
        f"import sys\nLobeLight = sys.modules[{__name__!r}].LobeLight\n", encoding="utf-8"
    )
    monkeypatch.setattr(lights, "__path__", [*lights.__path__, str(tmp_path)])
    found = lights.found_kinds()
    del sys.modules["ssdo_gl.scene.lights.lobe_light"], lights.lobe_light
    assert [kind for kind in found if kind not in KINDS] == ["lobe"]
    monkeypatch.setitem(KINDS, "lobe", found["lobe"])


@pytest.mark.parametrize("shadow", ["map", "none", "ssdo"])
@pytest.mark.parametrize("traced", [False, True])
@pytest.mark.usefixtures("lobe")
def test_a_new_kind_lights_a_picture(tmp_path: Path, shadow: str, traced: bool) -> None:
    if traced and shadow == "ssdo":
        pytest.skip("light through SSDO is not traced")
    file = tmp_path / "lobe.toml"
    file.write_text(floor_and_lamp(shadow), encoding="utf-8")
    scene = load_scene(file)
    settings = Settings(
        size=(33, 33),
        method="ssdo" if shadow == "ssdo" else "direct",
        shadows="traced" if traced else "map",
        shadow_rays=1,
        filter="none",
    )
    name = "directional" if shadow == "ssdo" else "direct"
    with Renderer(scene, settings) as renderer:
        result = renderer.render([name, "position_ws"])
    x, _, z = np.moveaxis(result.images["position_ws"][..., :3].astype(np.float64), -1, 0)
    distance = np.sqrt(4.0 + x * x + z * z)
    # Of the cosine, four powers are the lobe's and one is the white floor's.
    intensity = np.array([3.0, 2.0, 1.0])[:, None, None]
    wanted = (2.0 / distance) ** 5 / distance**2 * intensity / np.pi
    # The stored normal is good to 6e-5 radians, and the light is up to 45 degrees off it.
    np.testing.assert_allclose(np.moveaxis(result.images[name], -1, 0)[:3], wanted, rtol=3e-4)


@pytest.mark.usefixtures("lobe")
def test_its_keys_are_its_fields(tmp_path: Path) -> None:
    file = tmp_path / "lobe.toml"
    file.write_text(floor_and_lamp("map") + "cone = 3\n", encoding="utf-8")
    with pytest.raises(ValueError, match="unknown key 'cone'"):
        load_scene(file)
    assert LobeLight.keys() == ("position", "direction", "intensity")


def test_an_unlisted_kind_is_refused_not_drawn_as_a_point() -> None:
    light = LobeLight((0, 0, 0), (0, 0, -1), (1, 1, 1))
    with pytest.raises(ValueError, match=r"LobeLight.*is not in list"):
        kind_number(light)


def test_kinds_keep_their_numbers_in_shaders() -> None:
    assert kind_number(PointLight((0, 0, 0), (1, 1, 1))) == [*KINDS].index("point")
    for number, kind in enumerate(KINDS.values()):
        assert f"#define LIGHT_{kind.kind.upper()} {number}\n" in light_kinds_source()

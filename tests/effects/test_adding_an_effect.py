"""What docs/adding-an-effect.md tells people to write works as it stands there."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import ssdo_gl.effects
from ssdo_gl import resources
from ssdo_gl.effects import registry
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.options.resolve import settings_for
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene

PAGE = (Path(__file__).parents[2] / "docs" / "adding-an-effect.md").read_text(encoding="utf-8")
STRENGTH = 3.0


def block(language: str) -> str:
    (text,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)
    return text


@pytest.fixture
def shaders(device, tmp_path):
    """The shipped shaders, and the one of the page."""
    folder = tmp_path / "shaders"
    shutil.copytree(str(resources.folder("shaders")), folder)
    (folder / "effects" / "headlight.frag").write_text(block("glsl"), encoding="utf-8")
    device.activate()
    return ShaderLibrary(device.gl, folder)


@pytest.fixture
def headlight(monkeypatch, tmp_path):
    """The module of the page in the folder of effects, which is all that makes it one."""
    folder = tmp_path / "effects"
    folder.mkdir()
    (folder / "headlight.py").write_text(block("python"), encoding="utf-8")
    monkeypatch.setattr(ssdo_gl.effects, "__path__", [*ssdo_gl.effects.__path__, str(folder)])
    monkeypatch.setattr(registry, "_EFFECTS", registry.found_effects())
    yield
    del sys.modules["ssdo_gl.effects.headlight"], ssdo_gl.effects.headlight


def test_the_example_lights_what_faces_the_camera(headlight, device, shaders):
    scene = load_scene("corner")
    wanted = ["beauty", "headlight", "albedo", "normal_ws", "position_ws", "depth"]
    assert set(wanted) <= set(registry.image_names())
    pictures = []
    for strength in (0.0, STRENGTH):
        overrides = {"headlight.strength": strength}
        given = {"size": (48, 32), "method": "direct", "overrides": overrides}
        chosen = settings_for(scene.render, given)
        with Renderer(scene, chosen, device=device, shaders=shaders) as renderer:
            pictures.append(renderer.render(wanted).images)
    dark, lit = pictures
    surface = lit["depth"][..., 0] > 0.0
    to_eye = np.asarray(scene.camera.position) - lit["position_ws"]
    to_eye /= np.linalg.norm(to_eye, axis=-1, keepdims=True)
    cosine = np.maximum((lit["normal_ws"] * to_eye).sum(-1, keepdims=True), 0.0)
    expected = lit["albedo"] / np.pi * STRENGTH * cosine
    # Normals have 16 bits along each axis of their code: 6.5e-5.
    np.testing.assert_allclose(lit["headlight"][surface], expected[surface], atol=2e-4)
    added = lit["beauty"][..., :3] - dark["beauty"][..., :3]
    np.testing.assert_allclose(added[surface], lit["headlight"][surface], atol=1e-5)
    assert expected.max() > 0.1


def test_every_attribute_that_the_page_names_exists():
    from ssdo_gl.effects.effect import Effect

    rows = re.findall(r"^\| (`.*?`) \|", PAGE, re.MULTILINE)
    named = [name for row in rows for name in re.findall(r"`(\w+)(?:\(\))?`", row)]
    assert named and [name for name in named if not hasattr(Effect, name)] == []

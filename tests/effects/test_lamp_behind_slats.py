"""The direct light of a lamp behind a louvre shows no lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scene_text as text

import ssdo_gl
from ssdo_gl.effects import direct
from ssdo_gl.passes.light_draws import Edge
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

# RMS of the light of a picture against shadow rays, over the mean; .0385 was measured.
RMS_BOUND = 0.06
SLATS = [[1.3 + 0.2 * i, 0.8 + 0.2 * i] for i in range(13)]
LOUVRE = (
    text.camera([2.5, 1.4, 3.9], [2.5, 1, 0], 60)
    + text.material("grey", 0.6, 0.6, 0.6)
    + text.lamp([1.3, 2.75, 0.8], [2.4, 0, 0], [0, 0, 2.4], [8, 8, 8])
    + "".join(text.box([x, 2.55, 0.8], [x + 0.015, 2.65, 3.2], "grey") for x, _ in SLATS)
    + "".join(text.box([1.3, 2.55, z], [3.7, 2.65, z + 0.015], "grey") for _, z in SLATS)
    + text.box([0, -0.1, 0], [5, 0, 4], "grey")
    + text.box([0, 0, -0.1], [5, 2.8, 0], "grey")
)
MOVING = text.ball([2.5, 0.4, 2], 0.3, "grey") + "animate = { orbit = [0, 90, 0] }\n"


def test_no_lines_under_a_louvre(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All that lies before a lamp is looked at, however many slats."""
    file = tmp_path / "louvre.toml"
    file.write_text(LOUVRE)
    asked: list[Any] = []

    def edge(kind: str, defines: Any, uniforms: Any, tables: Any) -> Any:
        asked.append(uniforms["u_shaft_steps"])
        return Edge(kind, defines, uniforms, tables)

    monkeypatch.setattr(direct, "Edge", edge)
    found = ssdo_gl.render(file, size=(96, 54), method="gi", aov="direct")[40:]
    assert set(asked) == {direct.MOST_STEPS}
    traced = {"shadows": "traced", "shadow_rays": 256}
    reference = ssdo_gl.render(file, size=(96, 54), method="direct", aov="direct", **traced)[40:]
    error = np.sqrt(np.mean((found - reference) ** 2))
    assert error < RMS_BOUND * reference.mean()


def test_a_window_looks_for_slats_once_however_bodies_move(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "louvre.toml"
    file.write_text(LOUVRE + MOVING)
    looked = []
    original = direct.slats_of
    monkeypatch.setattr(direct, "slats_of", lambda t: looked.append(t) or original(t))
    scene = load_scene(str(file))
    with Renderer(scene, Settings("gi", size=(24, 16))) as renderer:
        for seconds in (0.0, 0.1, 0.2):
            renderer.draw(["beauty"], camera=scene.camera, seconds=seconds)
        assert len(looked) == 1
        # A picture depends on nothing before it.
        renderer.render(seconds=0.3)
        assert len(looked) == 2

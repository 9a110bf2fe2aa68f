"""Exposure of model files is measured from their picture, once, and said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.cli import main
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

SIZE = (48, 27)
# A quad that glows by 1000 and nothing else: it would be white.
GLOWING = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl lamp\nf 1 2 3 4\n"


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    (tmp_path / "lamp.mtl").write_text("newmtl lamp\nKd 0 0 0\nKe 1000 1000 1000\n")
    path = tmp_path / "lamp.obj"
    path.write_text(f"mtllib lamp.mtl\n{GLOWING}")
    return path


@pytest.mark.parametrize("method", ["direct", "bounce"])
@pytest.mark.parametrize("size", [SIZE, (96, 54)])
def test_a_glow_alone_is_not_white(lamp: Path, method: str, size: tuple[int, int]) -> None:
    with Renderer(load_scene(lamp), Settings(size=size, method=method)) as renderer:
        result = renderer.render(["display", "depth"])
        # log2(0.35 / 1000), to a tenth, whatever method and size.
        assert result.settings.exposure == pytest.approx(-11.5)
        assert result.notes == ("exposure -11.5 EV, measured from the picture",)
        seen = result.images["display"][result.images["depth"][..., 0] > 0.0][:, :3]
        # sRGB code of 1000 / 2^11.5 = 0.345.
        assert seen == pytest.approx(0.623, abs=0.01)
        again = renderer.render(["display"], camera=Camera((0.5, 0.5, 9.0), (0.5, 0.5, 0.0)))
        assert again.notes == () and again.settings.exposure == result.settings.exposure


def test_a_given_exposure_holds(lamp: Path) -> None:
    with Renderer(load_scene(lamp), Settings(size=SIZE, exposure=-3.0)) as renderer:
        assert renderer.render(["display"]).settings.exposure == -3.0


def test_arrays_are_not_exposed(lamp: Path) -> None:
    with Renderer(load_scene(lamp), Settings(size=SIZE)) as renderer:
        result = renderer.render(["beauty"])
    assert result.notes == ()
    assert np.max(result.images["beauty"]) == pytest.approx(1000.0)


def test_the_command_says_it(lamp: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(lamp), "--snapshot", str(lamp.with_suffix(".png")), "--size", "48x27"]) == 0
    assert "exposure -11.5 EV, measured from the picture" in capsys.readouterr().err


def test_scene_files_say_their_own_exposure() -> None:
    assert load_scene("courtyard").metering_slack is None

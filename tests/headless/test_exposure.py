"""Exposure of model files is measured from their picture, once, and said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.cli import main
from ssdo_gl.options.resolve import resolved
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
        assert result.notes[0] == "exposure -11.5 EV, measured from the picture"
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


ROOM = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\n"
WALLS = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 4 1 5 8\nf 2 3 7 6\n"


def test_the_radius_of_models_is_where_the_error_is_least(lamp: Path) -> None:
    room = lamp.with_name("room.obj")
    room.write_text(ROOM + WALLS)
    assert load_scene(room).default_radius() == pytest.approx(0.64 * 3**0.5)
    for method, share in (("gi", 0.08), ("bounce", 0.64)):
        radius = resolved(Settings(method), load_scene(room)).radius
        assert radius == pytest.approx(share * 3**0.5)
    room.write_text(ROOM + "f 1 2 3\nf 2 7 5\n")
    low, high = load_scene(room).bounds()
    expected = 0.32 * float(np.linalg.norm(high - low))
    assert load_scene(room).default_radius() == pytest.approx(expected)
    assert load_scene("sphere_on_plane").reach == 0.08


def test_what_metering_prepares_is_shown_as_progress(lamp: Path) -> None:
    lamp.write_text(ROOM + WALLS)
    stages: set[str] = set()
    with Renderer(load_scene(lamp), Settings("gi", size=SIZE)) as renderer:
        renderer.render(["display"], progress=lambda stage, *_: stages.add(stage))
    assert "surface cache" in stages


@pytest.mark.parametrize(("method", "is_said"), [("bounce", True), ("direct", False)])
def test_light_that_must_come_from_beyond_the_radius_is_said(
    lamp: Path, method: str, is_said: bool
) -> None:
    """The lamp sees nothing but the open, and no sky is there."""
    settings = Settings(size=SIZE, method=method)
    with Renderer(load_scene(lamp, light="file"), settings) as renderer:
        notes = renderer.render(["display"]).notes
    assert any("directions are open within R = " in note for note in notes) is is_said

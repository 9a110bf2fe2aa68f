"""Sun and sky by the time of day, against Preetham's own numbers and what the sun does."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.cli import main
from ssdo_gl.scene.environment.daylight import SUN, UNITS_PER_KLX, Daylight, SkyEnvironment, sky
from ssdo_gl.scene.environment.environment_light import irradiance
from ssdo_gl.scene.formats import read_description
from ssdo_gl.scene.lights import DirectionalLight
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError

FLOOR = '[[object]]\nshape = "box"\nmin = [-1.0, -1.0, -1.0]\nmax = [1.0, 0.0, 1.0]\n'
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# The equinox of spring, when the sun stands over the equator.
EQUINOX = 81.0


def described(environment: str, more: str = "") -> Scene:
    return read_description(f"[environment]\n{environment}\n{FLOOR}{more}", "sky.toml")


@pytest.mark.parametrize("latitude", [-30.0, 0.0, 45.0, 60.0])
def test_at_noon_of_the_equinox_the_sun_is_as_high_as_the_pole_is_low(latitude: float) -> None:
    noon = Daylight(12.0, latitude, EQUINOX).to_sun
    assert math.degrees(math.asin(noon[1])) == pytest.approx(90.0 - abs(latitude), abs=0.01)
    # South is +z, seen from the northern half.
    assert noon[2] == pytest.approx(math.sin(math.radians(latitude)), abs=1e-3)


def test_the_sun_goes_from_east_to_west() -> None:
    rising, setting = (Daylight(hour, day=EQUINOX).to_sun for hour in (6.0, 18.0))
    assert rising == pytest.approx([1.0, 0.0, 0.0], abs=1e-3)
    assert setting == pytest.approx([-1.0, 0.0, 0.0], abs=1e-3)
    assert not Daylight(0.0).is_day and Daylight(12.0).is_day
    # With north turned to -x, east is -z.
    turned = Daylight(6.0, day=EQUINOX, north=90.0).to_sun
    assert turned == pytest.approx([0.0, 0.0, -1.0], abs=1e-3)


def test_the_zenith_has_the_luminance_and_colour_of_the_paper() -> None:
    """The fit's value, worked out by hand for a turbidity of 2 and the sun at 60 degrees."""
    day = Daylight(8.0, 0.0, EQUINOX, turbidity=2.0)
    theta = math.acos(day.to_sun[1])
    assert math.degrees(theta) == pytest.approx(60.0, abs=0.01)
    chi = (4 / 9 - 2 / 120) * (math.pi - 2 * theta)
    luminance = (4.0453 * 2 - 4.9710) * math.tan(chi) - 0.2155 * 2 + 2.4192
    rgb = day.radiance(np.array([0.0, 1.0, 0.0])) / UNITS_PER_KLX
    assert rgb @ LUMINANCE == pytest.approx(luminance, rel=2e-3)
    # Clear sky is blue: x and y of the paper's figures are near .25.
    assert rgb[2] > 2.0 * rgb[0]


def test_the_sky_is_brightest_beside_the_sun_and_the_same_on_either_side() -> None:
    day = Daylight(15.0)
    east, up, south = day.to_sun
    across = np.array([south, 0.0, -east]) / math.hypot(east, south)
    angles = np.linspace(-0.5, 0.5, 11)
    ring = np.cos(angles)[:, None] * day.to_sun + np.sin(angles)[:, None] * across
    levels = day.radiance(ring) @ LUMINANCE
    assert levels == pytest.approx(levels[::-1])
    assert levels.argmax() == 5
    assert up > 0.5


def test_low_sunlight_is_weak_and_red() -> None:
    high, low = (Daylight(hour).sun().irradiance for hour in (12.0, 19.0))
    assert sum(low) < 0.2 * sum(high)
    assert low[0] / low[2] > 2.0 * high[0] / high[2]
    # Sunlight through one clear atmosphere: about 100 klx on what faces it.
    assert 80.0 < high @ LUMINANCE / UNITS_PER_KLX < 115.0


def test_the_map_holds_the_sky_and_lit_ground() -> None:
    day = Daylight(10.0)
    environment = sky(day)
    up = irradiance(environment, np.array([[0.0, 1.0, 0.0]]))[0]
    down = irradiance(environment, np.array([[0.0, -1.0, 0.0]]))[0]
    sun = np.asarray(day.sun().irradiance) * day.to_sun[1]
    assert down == pytest.approx(0.2 * (up + sun), rel=0.01)
    assert environment.image.min() > 0.0
    seen = environment.sample(np.array([0.0, 0.8, -0.6]))
    assert seen == pytest.approx(day.radiance(np.array([0.0, 0.8, -0.6])), rel=0.02)


def test_a_scene_file_has_the_day_and_its_sun() -> None:
    scene = described('kind = "sky"\nhour = 9.5\nturbidity = 4.0')
    assert isinstance(scene.environment, SkyEnvironment)
    assert scene.environment.daylight == Daylight(9.5, turbidity=4.0)
    (sun,) = scene.lights
    assert isinstance(sun, DirectionalLight)
    assert (sun.name, sun.direction) == (SUN, Daylight(9.5, turbidity=4.0).sun().direction)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("hour = 1.0", "hour"),
        ("hour = 25.0", "hour"),
        ("turbidity = 1.0", "turbidity"),
        ("latitude = 91.0", "latitude"),
        ("sun = true", "sun"),
    ],
)
def test_days_that_are_none_are_refused(keys: str, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        described(f'kind = "sky"\n{keys}')


def test_a_base_at_another_hour_moves_its_sun(tmp_path: Path) -> None:
    base = tmp_path / "day.toml"
    base.write_text(f'[environment]\nkind = "sky"\n{FLOOR}')
    later = tmp_path / "later.toml"
    later.write_text('base = "day.toml"\n[environment]\nkind = "sky"\nhour = 18.0\n')
    scene = load_scene(later)
    (sun,) = scene.lights
    assert isinstance(sun, DirectionalLight)
    assert sun.direction == Daylight(18.0).sun().direction
    assert sun.irradiance == Daylight(18.0).sun().irradiance


def test_a_base_without_a_sun_gets_that_of_its_day(tmp_path: Path) -> None:
    later = tmp_path / "later.toml"
    later.write_text('base = "corner"\n[environment]\nkind = "sky"\nhour = 18.0\n')
    assert [light.name for light in load_scene(later).lights] == ["", SUN]
    # One that was taken away stays so at another hour.
    (tmp_path / "dark.toml").write_text('base = "later.toml"\n[[edit]]\nlight = 2\nremove = true\n')
    darker = tmp_path / "darker.toml"
    darker.write_text('base = "dark.toml"\n[environment]\nkind = "sky"\nhour = 9.0\n')
    assert [light.name for light in load_scene(darker).lights] == [""]


def test_the_light_of_an_hour_is_a_flag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = load_scene("corner", light="sky:9")
    assert [light.name for light in scene.lights] == [SUN]
    assert isinstance(scene.environment, SkyEnvironment)
    assert load_scene("corner", light="sky").environment.daylight.hour == 15.0  # type: ignore[union-attr]
    for text, said in (
        ("sky:2", "the sun is below the horizon"),
        ("sky:25", "sky:HOUR (0 to 24)"),
        ("sky:noon", "sky:HOUR (0 to 24)"),
        ("sky:", "sky:HOUR (0 to 24)"),
    ):
        assert main(["corner", "--light", text, "--snapshot", str(tmp_path / "a.png")]) == 2
        assert said in capsys.readouterr().err


def test_a_day_that_was_edited_is_saved() -> None:
    from ssdo_gl.settings import Settings
    from ssdo_gl.window.saving.scene_files import scene_text

    scene = load_scene("corner", light="sky")
    day = dataclasses.replace(Daylight(), hour=17.25, north=30.0)
    text = scene_text(
        "corner",
        scene,
        load={"light": "sky"},
        camera=scene.camera,
        lights=scene.lights,
        sources=range(len(scene.lights)),
        materials=scene.materials,
        environment=sky(day),
        settings=Settings(size=(64, 36)),
    )
    again = read_description(text, "saved.toml")
    assert isinstance(again.environment, SkyEnvironment)
    assert again.environment.daylight == day

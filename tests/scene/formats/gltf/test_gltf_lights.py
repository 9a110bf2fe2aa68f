"""Punctual lights of glTF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from glb_writer import load

from ssdo_gl.scene.lights import DirectionalLight, PointLight, SpotLight
from ssdo_gl.scene.scene_error import SceneError


def test_punctual_lights_shine_along_minus_z(glb, tmp_path: Path) -> None:
    lights = [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 4, "name": "sun"},
        {"type": "point", "intensity": 2},
        {"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
    ]
    down = [-(2**-0.5), 0, 0, 2**-0.5]  # a quarter turn about x takes -z to -y
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    glb.json["scenes"] = [{"nodes": [0, 1, 2, 3]}]
    glb.json["nodes"] = [
        {"mesh": 0},
        *(
            {
                "translation": [1, 2, 3],
                "rotation": down,
                "extensions": {"KHR_lights_punctual": {"light": index}},
            }
            for index in range(3)
        ),
    ]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    sun, point, spot = scene.lights
    assert isinstance(sun, DirectionalLight)
    assert sun.direction == pytest.approx((0, -1, 0), abs=1e-12)
    assert sun.irradiance == (4.0, 2.0, 0.0)
    assert isinstance(point, PointLight)
    assert point.position == pytest.approx((1, 2, 3))
    assert point.intensity == (2.0, 2.0, 2.0)
    assert isinstance(spot, SpotLight)
    assert np.radians(spot.inner_angle) == pytest.approx(0.1)
    assert np.radians(spot.outer_angle) == pytest.approx(0.2)
    assert scene.camera.exposure != 0.0


@pytest.mark.parametrize(
    ("kind", "scale", "expected"),
    [
        ("point", [0, 0, 0], (1, 2, 3)),
        ("directional", [1, 1, 0], (0, 0, -1)),
        ("spot", [2, 3, 0], (0, 0, -1)),
        ("spot", [0, 0, 0], None),
    ],
)
def test_lights_shine_whatever_the_scale_of_their_node(
    kind: str, scale: list[float], expected: tuple[float, ...] | None, glb, tmp_path: Path
) -> None:
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": kind, "name": "lamp"}]}}
    glb.json["scenes"] = [{"nodes": [0, 1]}]
    extension = {"KHR_lights_punctual": {"light": 0}}
    node = {"translation": [1, 2, 3], "scale": scale, "extensions": extension}
    glb.json["nodes"] = [{"mesh": 0}, node]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    scene = load(glb, tmp_path)
    dropped = [note for note in scene.notes if "light lamp dropped" in note]
    assert len(dropped) == (expected is None)
    if expected is not None:
        (light,) = scene.lights
        assert getattr(light, "direction", light.place) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("light", "message"),
    [
        ({"type": "point", "intensity": 1e39}, "light 0: intensity = "),
        ({"type": "area"}, "light 0: unknown type 'area'"),
        ({"type": "spot", "spot": {"outerConeAngle": np.nan}}, "light 0: outerConeAngle = nan"),
    ],
)
def test_bad_lights_are_refused_by_number(light, message: str, glb, tmp_path: Path) -> None:
    glb.json["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    glb.json["nodes"] = [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    glb.json["meshes"] = [{"primitives": [glb.triangle()]}]
    with pytest.raises(SceneError, match=message):
        load(glb, tmp_path)

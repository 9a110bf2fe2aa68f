"""A small thing on a wide ground is lit by what the ground near it sends back, not by all of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import ssdo_gl

# .0167 for .0076 where texels of the ground are as wide as the car.
GLOW_BOUND = 0.1
CAR = """
[camera]
position = [3.2, 0.7, 3.6]
target = [0, 0.4, 0]
fov_y = 40
[environment]
kind = "constant"
radiance = [0.1, 0.12, 0.15]
[materials.ground]
albedo = [0.5, 0.5, 0.5]
[materials.blue]
albedo = [0.1, 0.2, 0.5]
[[object]]
shape = "plane"
point = [0, 0, 0]
normal = [0, 1, 0]
size = 200
material = "ground"
[[object]]
shape = "box"
min = [-2, 0.3, -0.85]
max = [2, 0.9, 0.85]
material = "blue"
[[object]]
shape = "box"
min = [-1.6, 0, -0.95]
max = [-1, 0.6, -0.75]
repeat = { count = [2, 1, 2], step = [2.6, 0, 1.7] }
material = "ground"
[[light]]
kind = "area"
corner = [-1.5, 0.28, -0.5]
edge_u = [3, 0, 0]
edge_v = [0, 0, 1]
radiance = [3, 0.15, 0.1]
"""
# The front of the body, which hardly sees what is lit under it.
FRONT = np.s_[34:46, 123:138, 0]


def test_a_glow_under_a_car_does_not_light_its_front(tmp_path: Path) -> None:
    file = tmp_path / "car.toml"
    file.write_text(CAR)
    found, reference = (
        ssdo_gl.render(file, size=(160, 90), method=method, **settings)[FRONT].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 128}))
    )
    assert found == pytest.approx(reference, rel=GLOW_BOUND)

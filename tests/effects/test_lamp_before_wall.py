"""What a lamp close to a wall lights is seen by little else, and sends little into the room."""

from __future__ import annotations

from pathlib import Path

import pytest

import ssdo_gl

# .39 where texels of the wall are three times as wide as the strip. The paths err by .6 %.
MEAN_BOUND = 0.06
ROOM = """
[camera]
position = [2.5, 1.4, 3.9]
target = [2.5, 1.2, 0]
fov_y = 70
[materials.wall]
albedo = [0.9, 0.9, 0.9]
[[object]]
shape = "box"
min = [-0.1, -0.1, -0.1]
max = [5.1, 0, 4.1]
material = "wall"
repeat = { count = [1, 2, 1], step = [0, 2.7, 0] }
[[object]]
shape = "box"
min = [-0.1, 0, 0]
max = [0, 2.6, 4]
material = "wall"
repeat = { count = [2, 1, 1], step = [5.1, 0, 0] }
[[object]]
shape = "box"
min = [-0.1, 0, -0.1]
max = [5.1, 2.6, 0]
material = "wall"
repeat = { count = [1, 1, 2], step = [0, 0, 4.1] }
[[light]]
kind = "area"
corner = [0.5, 2, 0.01]
edge_u = [0, 0.04, 0]
edge_v = [4, 0, 0]
radiance = [30, 30, 30]
[[light]]
kind = "area"
corner = [0.01, 2, 0.5]
edge_u = [0, 0, 3]
edge_v = [0, 0.04, 0]
radiance = [30, 30, 30]
[[light]]
kind = "area"
corner = [4.99, 2, 0.5]
edge_u = [0, 0.04, 0]
edge_v = [0, 0, 3]
radiance = [30, 30, 30]
"""


def test_strips_that_face_walls_light_a_room_by_little(tmp_path: Path) -> None:
    file = tmp_path / "strips.toml"
    file.write_text(ROOM)
    found, reference = (
        ssdo_gl.render(file, size=(64, 36), method=method, **settings)[..., :3].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 256}))
    )
    assert found == pytest.approx(reference, rel=MEAN_BOUND)

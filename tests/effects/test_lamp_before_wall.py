"""What a lamp close to a wall lights is seen by little else, and sends little into the room."""

from __future__ import annotations

from pathlib import Path

import pytest
import scene_text as text

import ssdo_gl

# .39 where texels of the wall are three times as wide as the strip. The paths err by .6 %.
MEAN_BOUND = 0.06
STRIP = [30, 30, 30]
ROOM = (
    text.camera([2.5, 1.4, 3.9], [2.5, 1.2, 0], 70)
    + text.material("wall", 0.9, 0.9, 0.9)
    + text.box([-0.1, -0.1, -0.1], [5.1, 0, 4.1], "wall")
    + text.box([-0.1, 2.6, -0.1], [5.1, 2.7, 4.1], "wall")
    + text.box([-0.1, 0, 0], [0, 2.6, 4], "wall")
    + text.box([5, 0, 0], [5.1, 2.6, 4], "wall")
    + text.box([-0.1, 0, -0.1], [5.1, 2.6, 0], "wall")
    + text.box([-0.1, 0, 4], [5.1, 2.6, 4.1], "wall")
    + text.lamp([0.5, 2, 0.01], [0, 0.04, 0], [4, 0, 0], STRIP)
    + text.lamp([0.01, 2, 0.5], [0, 0, 3], [0, 0.04, 0], STRIP)
    + text.lamp([4.99, 2, 0.5], [0, 0.04, 0], [0, 0, 3], STRIP)
)


def test_strips_that_face_walls_light_a_room_by_little(tmp_path: Path) -> None:
    file = tmp_path / "strips.toml"
    file.write_text(ROOM)
    found, reference = (
        ssdo_gl.render(file, size=(64, 36), method=method, **settings)[..., :3].mean()
        for method, settings in (("gi", {}), ("reference-gi", {"spp": 256}))
    )
    assert found == pytest.approx(reference, rel=MEAN_BOUND)

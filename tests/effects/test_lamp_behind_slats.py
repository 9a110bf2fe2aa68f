"""The direct light of a lamp behind a louvre shows no lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import ssdo_gl

# RMS of the light of one frame against that of 256 points, over the mean; .19 by 16 points.
RMS_BOUND = 0.1
LOUVRE = """
[camera]
position = [2.5, 1.4, 3.9]
target = [2.5, 1, 0]
fov_y = 60
[materials.grey]
albedo = [0.6, 0.6, 0.6]
[[light]]
kind = "area"
corner = [1.3, 2.75, 0.8]
edge_u = [2.4, 0, 0]
edge_v = [0, 0, 2.4]
radiance = [8, 8, 8]
[[object]]
shape = "box"
min = [1.3, 2.55, 0.8]
max = [1.315, 2.65, 3.2]
material = "grey"
repeat = { count = [13, 1, 1], step = [0.2, 1, 1] }
[[object]]
shape = "box"
min = [1.3, 2.55, 0.8]
max = [3.7, 2.65, 0.815]
material = "grey"
repeat = { count = [1, 1, 13], step = [1, 1, 0.2] }
[[object]]
shape = "box"
min = [0, -0.1, 0]
max = [5, 0, 4]
material = "grey"
[[object]]
shape = "box"
min = [0, 0, -0.1]
max = [5, 2.8, 0]
material = "grey"
"""


def test_no_lines_under_a_louvre(tmp_path: Path) -> None:
    file = tmp_path / "louvre.toml"
    file.write_text(LOUVRE)
    found, reference = (
        ssdo_gl.render(file, size=(96, 54), method="gi", aov="direct", overrides=overrides)[40:]
        for overrides in ({}, {"direct.penumbra_rays": 256})
    )
    error = np.sqrt(np.mean((found - reference) ** 2))
    assert error < RMS_BOUND * reference.mean()

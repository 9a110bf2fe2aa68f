"""Small scenes and sizes for tests of the command."""

from __future__ import annotations

TINY = ["--size", "32x18"]
SMALL = [*TINY, "--samples", "8"]
BOX = """
[[object]]
shape = "box"
min = [0, 0, 0]
max = [1, 1, 1]
"""
# A box on a floor, under a sky of one colour.
SKY = f"""
[camera]
position = [1.5, 2.2, 3]
target = [0.5, 0.1, 1.2]
[environment]
kind = "constant"
radiance = [1, 1, 1]
[[object]]
shape = "box"
min = [-9, 0, -9]
max = [9, 0.1, 9]
{BOX}
"""


def scene_file(folder, text=BOX, name="scene.toml"):
    path = folder / name
    path.write_text(text)
    return str(path)

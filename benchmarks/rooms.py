"""Closed rooms for measurements: drawn at random, or of boxes around a model."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ssdo_gl.scene.formats import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

# Nothing stands nearer to the camera than this.
CLEAR = 1.3


def random_room(seed: int) -> Scene:
    """Return a closed room of some metres with lamps, a partition and bodies, by `seed`."""
    return read_description("\n".join(_drawn(np.random.default_rng(seed))), f"room-{seed}.toml")


def _drawn(rng: np.random.Generator) -> Iterator[str]:
    """Yield the lines of a scene file."""
    width, height, depth = rng.uniform((3.0, 2.4, 3.0), (6.0, 3.5, 6.0))
    side = rng.choice((-1.0, 1.0))
    eye = np.array([side * (width / 2 - 0.4), rng.uniform(1.0, 1.8), depth / 2 - 0.4])
    aim = [-side * width / 6, rng.uniform(0.4, 0.9), -depth / 4]
    yield f"[camera]\nposition = {_list(eye)}\ntarget = {_list(aim)}\nfov_y = 65"
    yield _material("wall", rng.uniform(0.3, 0.85) * rng.uniform(0.85, 1.0, 3))
    yield _box([-width / 2, 0, -depth / 2], [width / 2, height, depth / 2], "wall")
    if rng.random() < 0.5:
        # A partition from the far wall, open above.
        x = rng.uniform(-width / 4, width / 4)
        top = height * rng.uniform(0.5, 0.9)
        yield _box([x, 0, -depth / 2], [x + 0.1, top, rng.uniform(-depth / 4, 0)], "wall")
    for index in range(rng.integers(4, 9)):
        yield _material(f"m{index}", rng.uniform(0.1, 0.9, 3))
        size = rng.uniform(0.2, 1.2, 3)
        low, high = [-width / 2, 0, -depth / 2] + size / 2, [width / 2, 0.8, depth / 2] - size / 2
        place = rng.uniform(low, np.maximum(low, high))
        turn = rng.uniform(0, 360)
        if np.linalg.norm((place - eye)[[0, 2]]) < CLEAR:
            continue
        if rng.random() < 0.7:
            yield _box(-size / 2, size / 2, f"m{index}")
            yield f"transform = {{ translate = {_list(place)}, rotate = [0, {turn:.1f}, 0] }}"
        else:
            yield f'[[object]]\nshape = "sphere"\ncenter = {_list(place)}'
            yield f'radius = {size.min() / 2:.4f}\nmaterial = "m{index}"'
    for _ in range(rng.integers(1, 3)):
        x, z = rng.uniform((-width / 3, -depth / 3), (width / 3, depth / 3))
        color = rng.uniform(0.6, 1.0, 3)
        if rng.random() < 0.7:
            edge = rng.uniform(0.2, 0.8)
            yield _lamp([x, height - 0.02, z], edge, 6.0 * color / edge**2)
        else:
            place, intensity = [x, rng.uniform(1.2, height - 0.2), z], 4.0 * color
            yield f'[[light]]\nkind = "point"\nposition = {_list(place)}'
            yield f"intensity = {_list(intensity)}"


def model_room(path: Path) -> Scene:
    """Return a model on the floor of a closed room, between two boxes, under a lamp."""
    low, high = load_scene(path).bounds()
    middle, reach = (low + high) / 2, float((high - low).max())

    def at(x: float, y: float, z: float) -> list[float]:
        """Return a point in units of the model, from the middle of the floor under it."""
        return [middle[0] + x * reach, low[1] + y * reach, middle[2] + z * reach]

    lines = [
        f"[camera]\nposition = {_list(at(1.0, 1.1, 1.6))}\ntarget = {_list(at(0, 0.4, 0))}",
        "fov_y = 55",
        _material("wall", [0.7, 0.68, 0.64]),
        _material("red", [0.6, 0.1, 0.08]),
        _material("blue", [0.1, 0.2, 0.5]),
        _box(at(-1.8, 0, -1.8), at(1.8, 2.4, 1.8), "wall"),
        _box(at(-1.3, 0, -1.4), at(-0.8, 1.2, -0.9), "red"),
        _box(at(0.7, 0, -1.2), at(1.2, 0.6, -0.7), "blue"),
        f'[[object]]\nshape = "mesh"\npath = "{path.name}"',
        _lamp(at(-0.3, 2.39, -0.3), 0.6 * reach, [14.0, 13.0, 12.0]),
    ]
    return read_description("\n".join(lines), f"room of {path}", path)


def _list(values: object) -> list[float]:
    return [round(float(value), 7) for value in np.asarray(values)]


def _material(name: str, albedo: object) -> str:
    return f"[materials.{name}]\nalbedo = {_list(albedo)}"


def _box(low: object, high: object, material: str) -> str:
    corners = f"min = {_list(low)}\nmax = {_list(high)}"
    return f'[[object]]\nshape = "box"\n{corners}\nmaterial = "{material}"'


def _lamp(middle: object, edge: float, radiance: object) -> str:
    """Return a square that shines down."""
    corner = np.asarray(middle) - [edge / 2, 0, edge / 2]
    edges = f"edge_u = [{edge:.7f}, 0, 0]\nedge_v = [0, 0, {edge:.7f}]"
    return (
        f'[[light]]\nkind = "area"\ncorner = {_list(corner)}\n{edges}\nradiance = {_list(radiance)}'
    )

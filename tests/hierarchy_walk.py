"""Walks the records of a hierarchy as a ray would, in float64, and checks all that it meets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.raytracing.bvh import BOX_MARGIN, Bvh


def decode(bvh: Bvh) -> tuple[dict[int, NDArray[np.float64]], int]:
    """Walk the records; return the primitives' vertices by record and the depth.

    Asserts on the way that every child lies inside its quantised box and that no record
    is reached twice.
    """
    records = bvh.records()
    found: dict[int, NDArray[np.float64]] = {}
    seen = {0}

    def bounds(record: int, is_leaf: bool, level: int) -> tuple[NDArray[np.float64], int]:
        words = records[record]
        if is_leaf:
            vertices = words[:12].view(np.float32).astype(np.float64).reshape(4, 3)
            found[record] = vertices
            return np.stack([vertices.min(axis=0), vertices.max(axis=0)]), level
        origin = words[:3].view(np.float32).astype(np.float64)
        step = np.exp2([float(words[3] >> 8 * axis & 255) - 127.0 for axis in range(3)])
        inner, total = words[3] >> 24 & 15, words[3] >> 28
        boxes, depths = [], [level + 1]
        for child in range(int(total)):
            assert words[10] % 4 == 0
            place = int(words[10]) + child
            assert place not in seen
            seen.add(place)
            box, depth = bounds(place, child >= inner, level + 1)
            low = origin + step * [words[4 + axis] >> 8 * child & 255 for axis in range(3)]
            high = origin + step * [words[7 + axis] >> 8 * child & 255 for axis in range(3)]
            # Half of the margin: the parent's box grew by it, and so did this one.
            assert np.all(low <= box[0] - 0.5 * BOX_MARGIN)
            assert np.all(high >= box[1] + 0.5 * BOX_MARGIN)
            boxes.append(box)
            depths.append(depth)
        merged = np.stack([np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)])
        return merged, max(depths)

    if records[0, 3] >> 28 == 0:
        return found, 1
    _, depth = bounds(0, False, 0)
    unused = sorted(set(range(len(records))) - seen)
    assert not records[unused].any()
    return found, depth


def check_hierarchy(bvh: Bvh, triangle_count: int) -> None:
    """Assert that boxes hold their children, and that every triangle is there once, as it is."""
    vertices, depth = decode(bvh)
    numbers = bvh.records()[:, 12]
    assert depth == bvh.depth
    used = bvh.primitive_triangles[bvh.primitive_triangles >= 0]
    assert sorted(used) == list(range(triangle_count))
    for record, found in vertices.items():
        number = numbers[record]
        for second, columns in enumerate(([0, 1, 2], [0, 2, 3])):
            triangle = bvh.primitive_triangles[number, second]
            if triangle < 0:
                np.testing.assert_array_equal(found[3], found[2])
                continue
            corners = bvh.primitive_corners[number, second]
            np.testing.assert_array_equal(
                found[columns], bvh.triangles.positions[triangle, corners]
            )

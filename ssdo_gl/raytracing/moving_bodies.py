"""Hierarchies of scenes in which bodies move: of each body a tree of its own, built once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ssdo_gl.math3d import IntArray
from ssdo_gl.raytracing.content_digest import content_key
from ssdo_gl.raytracing.pairs import Pairs, pair_triangles, pair_vertices
from ssdo_gl.raytracing.split import BinaryTree, BoxArray, Report, build_binary, ignored
from ssdo_gl.raytracing.triangles import SceneTriangles, scene_triangles
from ssdo_gl.scene.geometry import SceneObject, are_mirrored
from ssdo_gl.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class _SplitBody:
    """What moves as one, or not at all: its `count` triangles as pairs, and their hierarchy."""

    count: int
    pairs: Pairs
    tree: BinaryTree


# Of the scene that was built last, by what they were made from.
_kept: dict[bytes, _SplitBody] = {}


def has_moving_bodies(scene: Scene) -> bool:
    """Return whether any object of a scene moves."""
    return any(item.motion is not None for item in scene.objects)


def hierarchy_of_bodies(
    scene: Scene, triangles: SceneTriangles, report: Report = ignored
) -> tuple[Pairs, BinaryTree] | None:
    """Return pairs and the hierarchy of what stands and what moves.

    While bodies move, boxes of their trees change and the few nodes above these, which takes a
    third of the time. What is returned depends on the scene alone, not on what was built before.

    Parameters
    ----------
    scene : Scene
        At one time, with the motions of what moves.
    triangles : SceneTriangles
        All of it.
    report : callable
        Told which share of the work is done, [0, 1].

    Returns
    -------
    None
        If a triangle has no area where its body is built.
    """
    bodies: dict[bytes, _SplitBody] = {}
    pairs, trees = list[Pairs](), list[BinaryTree]()
    key, last = b"", tuple[SceneObject, ...]()
    for items, rows in _parts(scene):
        if items is not last:  # copies follow one another
            part, last = replace(scene, objects=items), items
            key = content_key(part)
            # What stands comes first, and is most of a scene that takes long.
            if key not in bodies:
                bodies[key] = _kept.get(key) or _split(part, ignored if pairs else report)
        body = bodies[key]
        if body.count != len(rows):
            return None
        named = body.pairs.triangles
        pairs.append(Pairs(np.where(named < 0, -1, rows[named]), body.pairs.corners))
        trees.append(body.tree)
    _kept.clear()
    _kept.update(bodies)
    joined = Pairs(
        np.concatenate([one.triangles for one in pairs]),
        np.concatenate([one.corners for one in pairs]),
    )
    vertices = pair_vertices(triangles.positions, joined)
    return joined, joined_trees(trees, vertices.min(axis=1), vertices.max(axis=1))


def joined_trees(trees: Sequence[BinaryTree], low: BoxArray, high: BoxArray) -> BinaryTree:
    """Return one hierarchy of several, whose primitives are numbered one after the other.

    Parameters
    ----------
    trees : sequence of BinaryTree
        What they say of boxes is not looked at.
    low, high : ndarray, shape (P, 3), float32 or float64
        Of all primitives.
    """
    counts = np.array([(len(tree.left) + 1) // 2 for tree in trees])
    starts = np.cumsum(counts) - counts
    top = build_binary(
        np.minimum.reduceat(low, starts, axis=0), np.maximum.reduceat(high, starts, axis=0)
    )
    # The top's nodes, then those of all trees; its leaves become the roots of these.
    nodes = len(top.left) + np.cumsum([0, *(len(tree.left) for tree in trees)])
    left, primitive = [top.left], [np.full(len(top.left), -1)]
    for tree, node, start in zip(trees, nodes[:-1], starts, strict=True):
        left.append(np.where(tree.left < 0, -1, tree.left + node))
        primitive.append(np.where(tree.primitive < 0, -1, tree.primitive + start))
    all_left, all_primitive = np.concatenate(left), np.concatenate(primitive)
    leaves = np.flatnonzero(top.left < 0)
    roots = nodes[top.primitive[leaves]]
    all_left[leaves], all_primitive[leaves] = all_left[roots], all_primitive[roots]
    return _with_boxes(all_left, all_primitive, low, high)


def _with_boxes(left: IntArray, primitive: IntArray, low: BoxArray, high: BoxArray) -> BinaryTree:
    """Return the tree below node 0, level by level, each node's box around its primitives."""
    levels = [np.zeros(1, dtype=np.int64)]
    while len(inner := levels[-1][left[levels[-1]] >= 0]):
        levels.append((left[inner][:, None] + (0, 1)).reshape(-1))
    starts = np.cumsum([0, *(len(level) for level in levels)])
    order = np.concatenate(levels)
    is_inner = left[order] >= 0
    new_left = np.where(is_inner, 2 * np.cumsum(is_inner) - 1, -1)
    own = primitive[order]
    boxes_low, boxes_high = low[own], high[own]
    for first, last in zip(starts[-2::-1], starts[:0:-1], strict=True):
        node = np.flatnonzero(is_inner[first:last]) + first
        one, two = new_left[node], new_left[node] + 1
        boxes_low[node] = np.minimum(boxes_low[one], boxes_low[two])
        boxes_high[node] = np.maximum(boxes_high[one], boxes_high[two])
    return BinaryTree(boxes_low, boxes_high, new_left, own, starts)


def _parts(scene: Scene) -> Iterator[tuple[tuple[SceneObject, ...], IntArray]]:
    """Yield all that stands, then each body that moves, as it is built, and their triangles."""
    still, rows_of_still = list[SceneObject](), list[IntArray]()
    moving: list[tuple[tuple[SceneObject], IntArray]] = []
    first = 0
    for item in scene.objects:
        count, copies = len(scene.meshes[item.mesh].triangles), len(item.world_from_object)
        rows = np.arange(first, first + count * copies).reshape(copies, count)
        first += count * copies
        if item.motion is None:
            still.append(item)
            rows_of_still.append(rows.reshape(-1))
            continue
        # Wherever it has gone, mirrored or not: what is built of it stays the same.
        homes = [np.diag([side, 1.0, 1.0, 1.0]) for side in (1.0, -1.0)]
        built = [(replace(item, world_from_object=home[None]),) for home in homes]
        sides = are_mirrored(item.world_from_object)
        moving += [(built[side], own) for side, own in zip(sides.astype(int), rows, strict=True)]
    if still:
        yield tuple(still), np.concatenate(rows_of_still)
    yield from moving


def _split(scene: Scene, report: Report) -> _SplitBody:
    triangles = scene_triangles(scene)
    pairs = pair_triangles(triangles.positions, triangles.vertices)
    vertices = pair_vertices(triangles.positions, pairs)
    tree = build_binary(vertices.min(axis=1), vertices.max(axis=1), report)
    return _SplitBody(triangles.count, pairs, tree)

"""Bounding-volume hierarchy for ray tracing in shaders: 64-byte records, four boxes each.

What a traversal step costs on llvmpipe is fetches (one takes the time of some 50
multiplications) and divergent stores, not arithmetic. So boxes are quantised to 8 bits
relative to their node, in the manner of Ylitie, Karras, Laine, "Efficient Incoherent
Ray Traversal on GPUs Through Compressed Wide BVHs" (2017); nodes and primitives are
records of one array, so that a step fetches once whatever it finds; and siblings lie
side by side, from a multiple of four on, so that one short number names all of them.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import IntArray
from ssdo_gl.raytracing.content_digest import content_key
from ssdo_gl.raytracing.moving_bodies import has_moving_bodies, hierarchy_of_bodies
from ssdo_gl.raytracing.pairs import Pairs, pair_triangles, pair_vertices
from ssdo_gl.raytracing.split import BinaryTree, Report, build_binary, ignored
from ssdo_gl.raytracing.triangles import SceneTriangles, scene_triangles
from ssdo_gl.raytracing.widen import best_cuts, open_nodes
from ssdo_gl.scene.geometry import spans
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError

WIDTH = 4
RECORD_WORDS, NODE_WORDS = 16, 11
# A waiting entry of the traversal is one 32-bit word, 22 bits of which name the group of
# four records that siblings take, a sixth of them unused.
MAX_RECORDS = WIDTH << 22
# Boxes grow by this much, normalised frame (coordinates within [-1, 1]). The shader's
# slab test rounds positions to a few 2^-24 = 6e-8; 1e-6 covers 16 such roundings, so a
# ray never misses the box of a triangle that it hits.
BOX_MARGIN = 1e-6
# A box edge is a byte times a power of two; 2^-40 is far below float32 resolution in
# the frame, so even a box without extent has a normal number as its scale.
MIN_EXPONENT = -40
# Hierarchies kept by `cached_bvh`: the scene on screen and the ones just left.
CACHE_SIZE = 3


@dataclass(frozen=True, eq=False)
class Bvh:
    """A hierarchy over pairs of triangles, ready for upload.

    Attributes
    ----------
    nodes : ndarray, shape (N, 11), uint32
        Root first. Words 0-2 = origin x, y, z (float32 bits);
        3 = exponents of x, y, z (biased by 127, 8 bits each) and in the top byte the
        number of inner children (low 4 bits) and of all children; 4-9 = low x, y, z and
        high x, y, z of the four children, one byte each, in units of 2^exponent from
        the origin; 10 = record of the first child, a multiple of four; the others follow
        it, inner ones first.
    node_records, primitive_records : ndarray, shape (N,) and (P,), int32
        Which records they are, of `record_count`.
    primitive_triangles : ndarray, shape (P, 2), int32
        Index into `triangles`, -1 where there is no second one.
    primitive_corners : ndarray, shape (P, 2, 3), int8
        Corner of the source triangle that each vertex of (v0, v1, v2), (v0, v2, v3) is.
    depth : int
        Levels of nodes, >= 1: as many entries can wait in a depth-first traversal,
        because the children of one node that wait share an entry.
    """

    triangles: SceneTriangles
    nodes: NDArray[np.uint32]
    node_records: NDArray[np.int32]
    primitive_records: NDArray[np.int32]
    primitive_triangles: NDArray[np.int32]
    primitive_corners: NDArray[np.int8]
    record_count: int
    depth: int

    def records(self) -> NDArray[np.uint32]:
        """Make the records, (record_count, 16), which a texture holds then.

        Record 0 is the root. Words 0 to 10 of a node are as in `nodes`. Words of a primitive:
        0-11 = vertices v0 to v3 (float32 bits, normalised frame) of triangles (v0, v1, v2) and
        (v0, v2, v3), a single triangle repeats v2 as v3, which no ray hits; 12 = its number. All
        others are 0.
        """
        triangles, corners = self.primitive_triangles, self.primitive_corners
        pairs = Pairs(triangles.astype(np.int64), corners.astype(np.int64))
        vertices = pair_vertices(self.triangles.positions, pairs)
        count = len(vertices)
        records = np.zeros((self.record_count, RECORD_WORDS), dtype=np.uint32)
        records[self.node_records, :NODE_WORDS] = self.nodes
        records[self.primitive_records, :12] = vertices.reshape(count, 12).view(np.uint32)
        records[self.primitive_records, 12] = np.arange(count)
        return records

    @cached_property
    def root(self) -> NDArray[np.uint32]:
        """The first three texels of the root, (3, 4), read-only."""
        root = np.append(self.nodes[0], np.uint32(0)).reshape(3, 4)
        root.flags.writeable = False
        return root


def build_bvh(scene: Scene, report: Report = ignored) -> Bvh:
    """Build the hierarchy of all triangles of `scene`.

    Parameters
    ----------
    report : callable
        Told which share of the work is done, [0, 1].

    Raises
    ------
    SceneError
        If the scene has more than some sixteen million triangles.
    """
    count = sum(
        len(scene.meshes[item.mesh].triangles) * len(item.world_from_object)
        for item in scene.objects
    )
    if count > MAX_RECORDS:  # each has a record in the table of surfaces
        raise _too_many(count)
    triangles = scene_triangles(scene)
    report(0.1)
    # A row is missing where a triangle has no area.
    if triangles.count == count and has_moving_bodies(scene):
        parts = hierarchy_of_bodies(scene, triangles, lambda share: report(0.1 + 0.8 * share))
        if parts is not None:
            return _packed(triangles, *parts)
    return build_from_triangles(triangles, report)


def build_from_triangles(triangles: SceneTriangles, report: Report = ignored) -> Bvh:
    """Build the hierarchy over triangles that are already in the normalised frame."""
    if triangles.count == 0:
        # A root without children, which no ray leaves with a hit.
        root, place = np.zeros((1, NODE_WORDS), dtype=np.uint32), np.zeros(1, dtype=np.int32)
        none, corners = np.empty((0, 2), dtype=np.int32), np.empty((0, 2, 3), dtype=np.int8)
        return Bvh(triangles, root, place, place[:0], none, corners, 1, 1)
    pairs = pair_triangles(triangles.positions, triangles.vertices)
    vertices = pair_vertices(triangles.positions, pairs)
    report(0.4)
    tree = build_binary(
        vertices.min(axis=1), vertices.max(axis=1), lambda share: report(0.4 + 0.5 * share)
    )
    return _packed(triangles, pairs, tree)


def _packed(triangles: SceneTriangles, pairs: Pairs, tree: BinaryTree) -> Bvh:
    """Collapse a binary tree into nodes of up to four children, breadth first."""
    cuts = best_cuts(tree, WIDTH)
    nodes, node_records, primitives, primitive_records = ([] for _ in range(4))
    level, places = np.array([0]), np.array([0])
    used, depth = WIDTH, 0
    while len(level):
        node_records.append(places)
        depth += 1
        inner_nodes, inner_places = [], []
        for span in spans(len(level)):
            children, inner, total = _children(tree, cuts, level[span])
            firsts = used + WIDTH * np.arange(len(children))
            nodes.append(_pack(tree, level[span], children, inner, total, firsts))
            used += WIDTH * len(children)
            is_child = children >= 0
            flat = children[is_child]
            flat_places = (firsts[:, None] + np.arange(WIDTH))[is_child]
            is_leaf = tree.left[flat] < 0
            primitives.append(tree.primitive[flat[is_leaf]])
            primitive_records.append(flat_places[is_leaf])
            inner_nodes.append(flat[~is_leaf])
            inner_places.append(flat_places[~is_leaf])
        level, places = np.concatenate(inner_nodes), np.concatenate(inner_places)
    order = np.concatenate(primitives)
    if max(used, 2 * len(order)) > MAX_RECORDS:
        raise _too_many(triangles.count)
    return Bvh(
        triangles,
        np.concatenate(nodes),
        np.concatenate(node_records).astype(np.int32),
        np.concatenate(primitive_records).astype(np.int32),
        pairs.triangles[order].astype(np.int32),
        pairs.corners[order].astype(np.int8),
        used,
        depth,
    )


def _too_many(count: int) -> SceneError:
    return SceneError(
        f"{count} triangles: ray tracing takes up to some sixteen million; "
        "use a screen-space method or a simpler model"
    )


_cache: OrderedDict[bytes, Bvh] = OrderedDict()


def cached_bvh(scene: Scene, report: Report = ignored) -> Bvh:
    """Return the hierarchy of `scene`, built once for each content; see `build_bvh`."""
    key = content_key(scene)
    if key in _cache:
        _cache.move_to_end(key)
        return _cache[key]
    bvh = build_bvh(scene, report)
    _cache[key] = bvh
    while len(_cache) > CACHE_SIZE:
        _cache.popitem(last=False)
    return bvh


def _children(
    tree: BinaryTree, cuts: NDArray[np.int8], nodes: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the children (K, 4) of wide nodes, and how many are inner ones, and all, (K,).

    Inner children first, then leaves, then -1.
    """
    children = open_nodes(tree, cuts, nodes)
    is_child = children >= 0
    is_inner = is_child & (tree.left[children] >= 0)
    kind = np.where(is_inner, 0, np.where(is_child, 1, 2))
    children = np.take_along_axis(children, np.argsort(kind, axis=1, kind="stable"), axis=1)
    return children, is_inner.sum(axis=1), is_child.sum(axis=1)


def _pack(
    tree: BinaryTree,
    level: IntArray,
    children: IntArray,
    inner: IntArray,
    total: IntArray,
    first_child: IntArray,
) -> NDArray[np.uint32]:
    """Return words 0 to 10 of a level's nodes, child boxes rounded outwards."""
    low, high = (box.astype(np.float64) for box in (tree.low[level], tree.high[level]))
    origin = (low - 2.0 * BOX_MARGIN).astype(np.float32)
    extent = high + 2.0 * BOX_MARGIN - origin
    exponent = np.ceil(np.log2(extent / 255.0)).astype(np.int64)
    np.maximum(exponent, MIN_EXPONENT, out=exponent)
    step = np.exp2(exponent.astype(np.float64))[:, None]
    relative_low = tree.low[children].astype(np.float64) - BOX_MARGIN - origin[:, None]
    relative_high = tree.high[children].astype(np.float64) + BOX_MARGIN - origin[:, None]
    low_byte = np.clip(np.floor(relative_low / step), 0, 255).astype(np.uint32)
    high_byte = np.clip(np.ceil(relative_high / step), 0, 255).astype(np.uint32)
    shift = (8 * np.arange(WIDTH, dtype=np.uint32))[None, :, None]
    biased = (exponent + 127).astype(np.uint32)
    words = np.empty((len(level), NODE_WORDS), dtype=np.uint32)
    words[:, 0:3] = origin.view(np.uint32)
    counts = (inner | total << 4).astype(np.uint32)
    words[:, 3] = biased[:, 0] | biased[:, 1] << 8 | biased[:, 2] << 16 | counts << 24
    words[:, 4:7] = np.bitwise_or.reduce(low_byte << shift, axis=1)
    words[:, 7:10] = np.bitwise_or.reduce(high_byte << shift, axis=1)
    words[:, 10] = first_child
    return words

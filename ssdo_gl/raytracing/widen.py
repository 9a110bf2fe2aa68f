"""Which nodes of a binary hierarchy become the children of one wide node.

The cost of a wide hierarchy is the summed surface of its inner nodes: the expected
number of nodes that a random ray opens. Its minimum over all ways of cutting the binary
tree is found by dynamic programming from the leaves up (Ylitie et al. 2017, section
3.1); opening the child of largest surface greedily leaves nodes a quarter emptier.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import IntArray
from ssdo_gl.raytracing.split import BinaryTree, half_area


def best_cuts(tree: BinaryTree, width: int) -> NDArray[np.int8]:
    """Return how every node's subtree is best shared out, shape (N, width + 1), int8.

    Column i tells what to do with a node that may occupy up to i slots of its parent:
    0 leaves it whole, in one slot; k > 0 replaces it by its two children, of which the
    first may occupy up to k slots and the second up to i - k. Column ``width`` is also
    how the node itself is opened when it becomes a wide node.
    """
    node_count = len(tree.left)
    # cost[:, i]: least cost of a subtree that occupies up to i slots. Leaves cost
    # nothing here, since every cut has the same ones.
    cost = np.zeros((node_count, width + 1))
    cuts = np.zeros((node_count, width + 1), dtype=np.int8)
    area = half_area(tree.low, tree.high)
    for level in range(len(tree.level_starts) - 2, -1, -1):
        nodes = np.arange(tree.level_starts[level], tree.level_starts[level + 1])
        nodes = nodes[tree.left[nodes] >= 0]
        left = tree.left[nodes]
        shared = {
            slots: np.stack([cost[left, k] + cost[left + 1, slots - k] for k in range(1, slots)])
            for slots in range(2, width + 1)
        }
        whole = area[nodes] + shared[width].min(axis=0)
        cost[nodes, 1] = whole
        for slots, options in shared.items():
            choice = np.argmin(options, axis=0)
            least = np.take_along_axis(options, choice[None], axis=0)[0]
            cuts[nodes, slots] = np.where(least < whole, choice + 1, 0)
            cost[nodes, slots] = np.minimum(least, whole)
        # A node that is opened has to share out its slots even where staying whole
        # would be cheaper for its parent.
        cuts[nodes, width] = np.argmin(shared[width], axis=0) + 1
        cost[nodes, width] = shared[width].min(axis=0)
    return cuts


def open_nodes(tree: BinaryTree, cuts: NDArray[np.int8], level: IntArray) -> IntArray:
    """Return up to ``width`` descendants (K, width) of each node of `level`, -1 = none."""
    width = cuts.shape[1] - 1
    children = np.full((len(level), width), -1, dtype=np.int64)
    children[:, 0] = level
    budget = np.zeros((len(level), width), dtype=np.int64)
    budget[:, 0] = width
    used = np.ones(len(level), dtype=np.int64)
    rows = np.arange(len(level))
    for _ in range(width - 1):
        # Open the first slot that still asks for it, then look again.
        first = np.where(children >= 0, cuts[children, budget], 0)
        first[tree.left[children] < 0] = 0
        slot = np.argmax(first > 0, axis=1)
        share = first[rows, slot]
        opened = rows[share > 0]
        at, left_share = slot[opened], share[opened]
        left = tree.left[children[opened, at]]
        children[opened, used[opened]] = left + 1
        budget[opened, used[opened]] = budget[opened, at] - left_share
        children[opened, at] = left
        budget[opened, at] = left_share
        used[opened] += 1
    return children

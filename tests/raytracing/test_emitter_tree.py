"""The tree over emitters: each is in it once, within the bounds of all nodes above it."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.raytracing import emitter_tree as trees
from ssdo_gl.raytracing.emitter_tables import (
    BODY_CODE,
    ENTRY_TEXELS,
    KIND_PARALLELOGRAM,
    KIND_TRIANGLE,
    TWO_SIDED_CODE,
)
from ssdo_gl.raytracing.emitter_tree import EmitterTree, emitter_tree


def entries(count: int, seed: int = 0) -> np.ndarray:
    """Return rows of random triangles and parallelograms, some of which emit both ways."""
    rng = np.random.default_rng(seed)
    rows = np.zeros((count, ENTRY_TEXELS, 4), np.float32)
    rows[:, 0, :3] = rng.normal(size=(count, 3))
    rows[:, 1:3, :3] = 0.1 * rng.normal(size=(count, 2, 3))
    kinds = rng.choice([KIND_PARALLELOGRAM, KIND_TRIANGLE], count)
    rows[:, 0, 3] = kinds + BODY_CODE + TWO_SIDED_CODE * (rng.random(count) < 0.1)
    area = np.linalg.norm(np.cross(rows[:, 1, :3], rows[:, 2, :3]), axis=1)
    rows[:, 2, 3] = np.where(kinds == KIND_TRIANGLE, 0.5, 1.0) * area
    rows[:, 3, :3] = rng.random((count, 3))
    rows[:, 5, 3] = rng.random(count)
    return rows


def members(tree: EmitterTree) -> list[tuple[int, np.ndarray]]:
    """Return every node and the emitters under it."""
    found = []
    for level in range(tree.levels + 1):
        ends = [0, *tree.ends[2 ** (tree.levels - level) - 1 :: 2 ** (tree.levels - level)]]
        found += [(2**level - 1 + k, tree.order[ends[k] : ends[k + 1]]) for k in range(2**level)]
    return found


@pytest.mark.parametrize("count", [1, 2, 3, 37, 200])
def test_nodes_bound_what_is_under_them(count: int) -> None:
    rows = entries(count)
    tree = emitter_tree(rows)
    assert sorted(tree.order) == list(range(count))
    assert len(tree.nodes) == 2 ** (tree.levels + 1) - 1 and 2**tree.levels >= count
    code = rows[:, 0, 3].astype(int)
    for node, under in members(tree):
        (centre, area), (axis, cosine) = ((t[:3], t[3]) for t in tree.nodes[node, :2])
        reach, power = tree.nodes[node, 2, :3], tree.nodes[node, 2, 3]
        assert area == pytest.approx(rows[under, 2, 3].sum(), rel=1e-5)
        assert not len(under) or np.linalg.norm(axis) == pytest.approx(1.0)
        sides = np.where(code[under] & TWO_SIDED_CODE, 2.0, 1.0)
        sent = rows[under, 3, :3].mean(axis=1) * rows[under, 5, 3]
        whole = (rows[under, 2, 3] * sent * sides).sum()
        assert power == pytest.approx(whole, rel=1e-5)
        for row in rows[under]:
            corner, edge_u, edge_v = row[:3, :3]
            ends = [corner, corner + edge_u, corner + edge_v]
            if int(row[0, 3]) % TWO_SIDED_CODE == KIND_PARALLELOGRAM:
                ends.append(corner + edge_u + edge_v)
            assert (np.abs(np.array(ends) - centre) <= reach * (1 + 1e-5)).all()
            normal = np.cross(edge_u, edge_v)
            facing = normal @ axis / np.linalg.norm(normal)
            assert cosine <= facing + 1e-6
            if int(row[0, 3]) & TWO_SIDED_CODE:
                assert cosine == -1.0


@pytest.mark.parametrize("per_lamp", [12, 13, 16])
def test_what_lies_together_shares_nodes_wherever_it_faces(per_lamp: int) -> None:
    """A node of two lamps is large, and next to one of them seldom chosen, but sends much."""
    rows = entries(3 * per_lamp)
    rows[:, 0, 3] = KIND_PARALLELOGRAM
    lamp, side = np.arange(len(rows)) % 3, np.arange(len(rows)) // 3 % 2
    rows[:, 0, 0] += 40.0 * lamp
    rows[:, 1, :3], rows[:, 2, :3] = (0.1, 0.0, 0.0), (0.0, 0.1, 0.0)
    rows[side == 1, 2, 1] = -0.1
    tree = emitter_tree(rows)
    for node, under in members(tree):
        if node >= 3:
            assert len({*lamp[under]}) <= 1


def test_more_emitters_than_leaves_share_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trees, "MOST_LEVELS", 3)
    tree = emitter_tree(entries(100))
    assert tree.levels == 3
    assert sorted(tree.order) == list(range(100))
    assert max(len(under) for node, under in members(tree) if node >= 7) <= 13


def test_each_triangle_of_a_hundred_balls_has_a_leaf_of_its_own() -> None:
    tree = emitter_tree(entries(26_400))
    assert len(np.unique(tree.leaves)) == 26_400


def test_no_emitters_are_a_tree_without_power() -> None:
    tree = emitter_tree(entries(0))
    assert len(tree.order) == 0 and not tree.nodes.any()

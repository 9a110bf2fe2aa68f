"""A tree over all that glows, from which rays draw what matters to a point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.rays.ray_libraries import GlowTree, bvh_of, emitters_of, in_rows
from ssdo_gl.raytracing.emitter_tables import (
    KIND_PARALLELOGRAM,
    STAND_IN_CODE,
    TWO_SIDED_CODE,
    UNLIT_CODE,
)
from ssdo_gl.raytracing.emitter_tree import emitter_tree


class GlowTreePass(RenderPass):
    """Writes `GLOW_TREE`, whose `GlowTree` comes with `glow_nodes`, and `GLOW_PLACES`.

    `glow_order` holds of the n-th emitter of the leaves its entry in the table of emitters; of the
    n-th of the tree its entry and leaf; and how many are of the leaves up to the n-th.
    `glow_places` holds of each slot which emitter of the tree it is, or the first of its cells,
    -1: none, and how many cells it has along an edge.

    Parameters
    ----------
    stand_ins : bool
        Whether bodies are of it that sample rectangles stand for, besides those that no light
        of the scene does.
    """

    name = "glow_tree"
    reads = ("bvh", "ray_emitters")
    writes: Mapping[str, TextureSpec] = {
        "glow_nodes": TextureSpec(4, "f4", own=True),
        "glow_order": TextureSpec(4, "i4", own=True),
        "glow_places": TextureSpec(2, "i4", own=True),
    }
    depends_on = ("geometry", "materials", "lights")

    def __init__(self, *, stand_ins: bool) -> None:
        self.codes = UNLIT_CODE + STAND_IN_CODE * stand_ins

    def execute(self, context: PassContext) -> Produced:
        """Build the tree."""
        tables = emitters_of(context)
        heads = tables.groups[:, 0, :3].astype(np.int64)
        chosen = heads[heads[:, 2] & self.codes != 0, :2]
        parts = [np.arange(first, first + count) for first, count in chosen]
        entries = np.concatenate(parts) if parts else np.arange(0, dtype=np.int64)
        tree = emitter_tree(tables.entries[entries])
        kinds = tables.entries[entries, 0, 3].astype(np.int64)
        joined = kinds % TWO_SIDED_CODE == KIND_PARALLELOGRAM
        of_scene = context.frame.scene.materials
        glow = [of_scene[int(i)] for i in np.unique(tables.entries[entries, 5, 2])]
        is_even = not any(m.has_holes or m.emission_texture is not None for m in glow)
        are_panels = joined.all() and is_even
        known = GlowTree(tree, self.codes, len(entries) if are_panels else 0)
        nodes = tree.nodes.reshape(-1, 4)
        order = np.zeros((max(len(entries), len(tree.ends)), 4), np.int32)
        of_all = order[: len(entries)].T
        of_all[0], of_all[1], of_all[2] = entries[tree.order], entries, tree.leaves
        order[: len(tree.ends), 3] = tree.ends
        bvh = bvh_of(context)
        places = np.full((bvh.primitive_triangles.size, 2), -1, np.int32)
        slots, firsts, counts = np.unique(
            tables.slots[entries], return_index=True, return_counts=True
        )
        places[slots] = np.stack([firsts, np.sqrt(counts)], axis=1)
        joined = joined[firsts]
        places[slots[joined] + 1] = places[slots[joined]]
        return {
            "glow_nodes": TextureWithFacts(in_rows(context.gl, nodes, "f4"), known),
            "glow_order": in_rows(context.gl, order, "i4"),
            "glow_places": in_rows(context.gl, places, "i4"),
        }

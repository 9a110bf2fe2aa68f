"""Tables from which rays are aimed at bright pieces of the surface cache."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import moderngl
import numpy as np

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, Produced, RenderPass, TextureWithFacts
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import FloatArray, IntArray
from ssdo_gl.passes.own_textures import facts_of
from ssdo_gl.passes.rays import bvh_of, in_rows, record_texture
from ssdo_gl.passes.surfels.surfel_textures import SURFELS_PER_ROW, SurfelSet, surfel_rows
from ssdo_gl.raytracing.bright_pieces import BrightPieces, bright_pieces, bright_surfels

BRIGHT_TABLES = ("bright_entries", "bright_nodes", "bright_order", "bright_faces")
# What rays/bright_pieces.glsl, which includes rays/emitter_tree.glsl, calls them.
SAMPLERS = ("t_ray_emitters", "t_glow_nodes", "t_glow_order", "t_bright_faces")
# Frames after which tables are made anew while light is spreading.
FRAMES = 16
# Every so manyth ray of a row tells enough of what rays meet.
STRIDE = 4
# As rays/surfel_hits.glsl packs what rays met.
NO_SURFEL = 0xFFFF


@dataclass(frozen=True, eq=False)
class Aims:
    """What the textures of `BRIGHT_TABLES` hold.

    Attributes
    ----------
    pieces : BrightPieces or None
        None where there is nothing to aim at.
    age : int
        Frames since they were made, while light is spreading.
    """

    surfels: SurfelSet
    pieces: BrightPieces | None
    age: int = 0


class BrightTablesPass(RenderPass):
    """Writes `BRIGHT_TABLES`, whose `Aims` come with the first.

    The table of emitters has the parallelograms to aim at, `bright_nodes` and `bright_order` a tree
    over them, as `GLOW_TREE`, but for the surfel of each in place of its entry; `bright_faces` the
    first of each surfel, and how many it has. While light is spreading they are made anew now and
    then alone: they say where rays go, not what these bring.
    """

    name = "bright_tables"
    reads = ("bvh", "surfel_points", "surfel_hits", "surface_cache")
    writes: Mapping[str, TextureSpec] = {
        "bright_entries": TextureSpec(4, "f4", own=True),
        "bright_nodes": TextureSpec(4, "f4", own=True),
        "bright_order": TextureSpec(4, "i4", own=True),
        "bright_faces": TextureSpec(2, "i4", own=True),
    }
    is_gradual = True
    lags = False

    def execute(self, context: PassContext) -> Produced:
        """Choose what to aim at."""
        known = facts_of(context, BRIGHT_TABLES[0], Aims)
        surfels: SurfelSet = context.facts["surfel_points"]
        self.is_settled = context.is_complete
        is_same = known is not None and known.surfels is surfels and known.age + 1 < FRAMES
        if known is not None and is_same and not context.is_complete:
            last = {name: context.last[name].texture for name in BRIGHT_TABLES}
            older = replace(known, age=known.age + 1)
            return {**last, BRIGHT_TABLES[0]: TextureWithFacts(last[BRIGHT_TABLES[0]], older)}
        light = np.frombuffer(context.inputs["surface_cache"].read(), np.float32)
        light = light.reshape(-1, 4)[: surfels.count, :3].mean(axis=1, dtype=np.float64)
        bright = bright_surfels(*_met(context.inputs["surfel_hits"], surfels.count), light)
        pieces = None
        if len(bright.numbers):
            triangles = bvh_of(context).triangles
            pieces = bright_pieces(bright, surfels.surfels.moved(triangles), triangles)
        return self._produced(context, Aims(surfels, pieces))

    def _produced(self, context: PassContext, aims: Aims) -> Produced:
        """Return the textures of `aims`, or a texel each."""
        gl, pieces = context.gl, aims.pieces
        if pieces is None:
            first, *others = (
                make_texture(gl, (1, 1), spec.components, spec.dtype, spec.components * [0])
                for spec in self.writes.values()
            )
        else:
            records = pieces.entries.reshape(-1, 16)
            first = record_texture(gl, len(records), "f4", lambda span: records[span])
            tree, count = pieces.tree, len(pieces.owners)
            order = np.zeros((max(count, len(tree.ends)), 4), np.int32)
            order[:count, :3] = np.stack([tree.order, pieces.owners, tree.leaves], axis=1)
            order[: len(tree.ends), 3] = tree.ends
            rows = surfel_rows(aims.surfels.count)
            faces = np.zeros((rows * SURFELS_PER_ROW, 2), np.int32)
            faces[pieces.surfels] = pieces.faces
            others = [
                in_rows(gl, tree.nodes.reshape(-1, 4), "f4"),
                in_rows(gl, order, "i4"),
                make_texture(gl, (SURFELS_PER_ROW, rows), 2, "i4", faces),
            ]
        rest = dict(zip(BRIGHT_TABLES[1:], others, strict=True))
        return {BRIGHT_TABLES[0]: TextureWithFacts(first, aims), **rest}


def bright_reads(context: PassContext) -> dict[str, moderngl.Texture]:
    """Return the textures of rays/bright_pieces.glsl, none where there is nothing to aim at."""
    if pieces_of(context) is None:
        return {}
    return {s: context.inputs[name] for s, name in zip(SAMPLERS, BRIGHT_TABLES, strict=True)}


def pieces_of(context: PassContext) -> BrightPieces | None:
    """Return what rays are to be aimed at."""
    aims = context.facts.get(BRIGHT_TABLES[0])
    return aims.pieces if isinstance(aims, Aims) else None


def _met(hits: moderngl.Texture, count: int) -> tuple[IntArray, FloatArray]:
    """Return the surfel that some rays of each of `count` have met, and its albedo there."""
    rows = surfel_rows(count)
    words = np.frombuffer(hits.read(), np.uint32)
    words = words.reshape(-1, rows, hits.width // SURFELS_PER_ROW, SURFELS_PER_ROW, hits.components)
    words = words[:, :, ::STRIDE]
    target = words[..., 0] & NO_SURFEL
    exists = (np.arange(rows * SURFELS_PER_ROW) < count).reshape(rows, 1, SURFELS_PER_ROW)
    has_met = (target != NO_SURFEL) & exists
    first, second = words[has_met][:, :2].T
    # With gloss the lowest bits are another number's.
    albedo = (first >> 16) + (second & NO_SURFEL) + (second >> 16)
    return target[has_met].astype(np.int64), albedo / (3.0 * NO_SURFEL)

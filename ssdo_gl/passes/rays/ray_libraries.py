"""What every pass that traces rays sets: defines and uniforms of the ray libraries."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.context import draws_on_cpu
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.raytracing.bvh import Bvh
from ssdo_gl.raytracing.emitter_tables import EmitterTables
from ssdo_gl.raytracing.emitter_tree import EmitterTree
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.geometry import spans
from ssdo_gl.scene.scene_error import SceneError

# Longer than any ray that starts within the scene's bounds: their diagonal is 2 in the
# normalised frame (`RAY_FAR` of shaders/rays/ray.glsl).
FAR_NS = 4.0
# Records of four texels in a row of a table: 16384 rows of 1024, what drivers take, hold
# those of sixteen million triangles. `shaders/rays/surface_data.glsl`: BVH_ROW_SHIFT.
RECORDS_PER_ROW = 1024
SHADING_TABLES = ("ray_surfaces", "ray_materials", "ray_atlas", "ray_data_atlas")
EMITTER_TABLES = ("ray_emitters", "ray_emitter_groups", "ray_map_cells")
# Nodes of a tree over emitters, and which entries of their table its leaves hold.
GLOW_TREE = ("glow_nodes", "glow_order")
# Texels in a row of what a tree is read from, whole nodes: shaders/rays/emitter_tree.glsl.
TREE_ROW = 1023
# Which of them a triangle is that a ray has hit.
GLOW_PLACES = "glow_places"


def record_texture(
    gl: moderngl.Context,
    count: int,
    dtype: str,
    part: Callable[[slice], NDArray[Any]],
    texels: int = 4,
) -> moderngl.Texture:
    """Return a texture of `count` records, 1024 to a row, in as many rows as are needed.

    `shaders/rays/surface_data.glsl` finds the first texel of record i at column i mod 1024,
    times `texels`, of row i / 1024.

    Parameters
    ----------
    part : callable
        Returns the records (n, 16) of a slice of them: no copy of all is made.
    texels : int
        Of a record: its first 4, 8, 12 or all 16 words are kept.

    Raises
    ------
    SceneError
        If the device's textures hold fewer.
    """
    rows = max(-(-count // RECORDS_PER_ROW), 1)
    most = int(gl.info["GL_MAX_TEXTURE_SIZE"])
    if rows > most:
        raise SceneError(
            f"{count} records for rays: textures of this device hold {most * RECORDS_PER_ROW}; "
            "use a screen-space method or a simpler model"
        )
    texture = make_texture(gl, (texels * RECORDS_PER_ROW, rows), 4, dtype)
    for span in spans(count, 64 * RECORDS_PER_ROW):
        records = part(span)
        filled = -(-len(records) // RECORDS_PER_ROW)
        image = np.zeros((filled * RECORDS_PER_ROW, 4 * texels), dtype=records.dtype)
        image[: len(records)] = records[:, : 4 * texels]
        place = (0, span.start // RECORDS_PER_ROW, texels * RECORDS_PER_ROW, filled)
        texture.write(image, viewport=place)
    return texture


def in_rows(gl: moderngl.Context, texels: NDArray[Any], dtype: str) -> moderngl.Texture:
    """Return `texels` (N, channels) in rows of `TREE_ROW`."""
    rows = max(-(-len(texels) // TREE_ROW), 1)
    image = np.zeros((rows * TREE_ROW, texels.shape[1]), texels.dtype)
    image[: len(texels)] = texels
    return make_texture(gl, (TREE_ROW, rows), texels.shape[1], dtype, image)


def ray_reads(features: RayFeatures, *, shades: bool = False) -> tuple[str, ...]:
    """Return the resources that rays need: all tables where hits are shaded."""
    return ("bvh", *SHADING_TABLES) if shades or features.cutouts else ("bvh",)


def ray_defines(context: PassContext, features: RayFeatures) -> dict[str, int]:
    """Return the defines of ``rays/bvh.glsl``, what includes it, and, if read, surfels' tables."""
    is_software = draws_on_cpu(context.gl)
    known = context.facts.get("surfel_splits")
    return {
        "BVH_LEVELS": bvh_of(context).depth,
        "BVH_STACK_IN_REGISTERS": int(is_software),
        "BVH_FUSES": int(not is_software),
        "RAY_SMOOTH_NORMALS": int(features.smooth_normals),
        "RAY_VERTEX_COLORS": int(features.vertex_colors),
        "RAY_TEXTURES": int(features.textures),
        "RAY_CUTOUTS": int(features.cutouts),
        "RAY_SINGLE_SIDED": int(features.single_sided),
        "RAY_SECOND_UVS": int(features.second_uvs),
        "GLOSSY": int(features.glossy),
        "LOBES": int(features.lobes),
        "RAY_NORMAL_MAPS": int(features.normal_maps),
        "RAY_TANGENTS": int(features.tangents),
        "GLOW_IS_DIRECT": int(features.glow_is_direct),
        **({} if known is None else {"SURFEL_DEPTH": known}),
    }


def bvh_of(context: PassContext) -> Bvh:
    """Return the hierarchy that the resource ``bvh`` holds."""
    bvh: Bvh = context.facts["bvh"]
    return bvh


def emitters_of(context: PassContext) -> EmitterTables:
    """Return the tables that the resources of `EMITTER_TABLES` hold."""
    tables: EmitterTables = context.facts["ray_emitters"]
    return tables


@dataclass(frozen=True, eq=False)
class GlowTree:
    """What `glow_nodes` holds: the tree, and of which groups, as codes of `EmitterTables`.

    `panel_count` is how many emitters it has, if all are parallelograms of even light, else 0.
    """

    tree: EmitterTree
    codes: int
    panel_count: int


def tree_of(context: PassContext) -> GlowTree:
    """Return what the resources of `GLOW_TREE` hold."""
    known: GlowTree = context.facts[GLOW_TREE[0]]
    return known


def tree_uniforms(context: PassContext) -> dict[str, object]:
    """Return the uniforms of ``rays/emitter_tree.glsl``."""
    known = tree_of(context)
    return {
        "u_tree_levels": known.tree.levels,
        "u_tree_count": len(known.tree.order),
        "u_tree_groups": known.codes,
    }


def ray_uniforms(context: PassContext) -> dict[str, object]:
    """Return the uniforms of ``rays/ray.glsl``, and of ``rays/emitters.glsl`` where it is read."""
    bvh, view = bvh_of(context), context.frame.view
    triangles = bvh.triangles
    values: dict[str, object] = {
        **view.uniforms(),
        # From view space to the normalised frame.
        "u_ns_from_vs": view.world_from_view,
        "u_eye_ns": tuple(
            ((view.position_ws - triangles.centre) / triangles.half_diagonal).tolist()
        ),
        "u_ns_per_unit": 1.0 / triangles.half_diagonal,
        "u_second_slot": bvh.primitive_triangles.size,
        "u_bvh_root": bvh.root,
    }
    if "ray_emitters" in context.inputs:
        tables = emitters_of(context)
        values["u_emitter_group_count"] = tables.group_count
        values["u_emitter_density"] = tables.density
    return values


def radius_ns(radius: float, context: PassContext) -> float:
    """Return a length in scene units, infinity included, in the normalised frame."""
    unit = bvh_of(context).triangles.half_diagonal
    return min(radius / unit, FAR_NS) if math.isfinite(radius) else FAR_NS


@lru_cache(maxsize=256)
def stream_of(seed: int, half: int) -> int:
    """Return the scrambling of one half of the samples, 32 bits."""
    return int(np.random.SeedSequence([seed, half]).generate_state(1, np.uint32)[0])

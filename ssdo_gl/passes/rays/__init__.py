"""Rays from shaders: the tables and uniforms they need, and passes that add them up."""

from __future__ import annotations

from ssdo_gl.passes.rays.accumulate import Schedule, SumOutput
from ssdo_gl.passes.rays.bvh_upload import BvhUploadPass
from ssdo_gl.passes.rays.glow_tree import GlowTreePass
from ssdo_gl.passes.rays.ray_libraries import (
    EMITTER_TABLES,
    GLOW_PLACES,
    GLOW_TREE,
    bvh_of,
    emitters_of,
    in_rows,
    radius_ns,
    ray_defines,
    ray_reads,
    ray_uniforms,
    record_texture,
    stream_of,
    tree_of,
    tree_uniforms,
)
from ssdo_gl.passes.rays.ray_pass import RayPass, asked_lights
from ssdo_gl.passes.rays.ray_tables import EmitterTablesPass, MaterialTablePass, SurfaceTablesPass

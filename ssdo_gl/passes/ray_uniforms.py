"""What every pass that traces rays sets: defines and uniforms of the ray libraries."""

from __future__ import annotations

import math

import moderngl
import numpy as np

from ssdo_gl.graph.frame import Frame
from ssdo_gl.scene.bvh import cached_bvh
from ssdo_gl.scene.bvh_triangles import normalised_frame

# Longer than any ray that starts within the scene's bounds: their diagonal is 2 in the
# normalised frame (`RAY_FAR` of shaders/lib/ray.glsl).
FAR_NS = 4.0
# Names under which llvmpipe and other software rasterizers report themselves.
SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "SwiftShader")


def ray_defines(gl: moderngl.Context, frame: Frame) -> dict[str, int]:
    """Return the defines of ``lib/bvh.glsl``."""
    is_software = any(name in gl.info["GL_RENDERER"] for name in SOFTWARE_RENDERERS)
    return {
        "BVH_LEVELS": cached_bvh(frame.scene).depth,
        "BVH_STACK_IN_REGISTERS": int(is_software),
    }


def bvh_uniforms(bvh: moderngl.Texture) -> dict[str, object]:
    """Return the uniforms of ``lib/bvh.glsl``."""
    return {"u_bvh_texel": (1.0 / bvh.width, 1.0 / bvh.height)}


def ray_uniforms(frame: Frame) -> dict[str, object]:
    """Return the uniforms of ``lib/ray.glsl``: from view space to the normalised frame."""
    centre, half_diagonal = normalised_frame(frame.scene)
    return {
        **frame.view.uniforms(),
        "u_ns_from_vs": frame.view.view_from_world.T,
        "u_eye_ns": tuple((frame.view.position_ws - centre) / half_diagonal),
        "u_ns_per_unit": 1.0 / half_diagonal,
    }


def radius_ns(radius: float, frame: Frame) -> float:
    """Return a length in scene units, infinity included, in the normalised frame."""
    _, half_diagonal = normalised_frame(frame.scene)
    return min(radius / half_diagonal, FAR_NS) if math.isfinite(radius) else FAR_NS


def stream_of(seed: int, half: int) -> int:
    """Return the scrambling of one half of the samples, 32 bits."""
    return int(np.random.SeedSequence([seed, half]).generate_state(1, np.uint32)[0])

"""Rewrites shaders so that a software rasterizer draws them faster, bit for bit the same."""

from __future__ import annotations

from ssdo_gl.gpu.software.flat_uniforms import with_flat_uniforms
from ssdo_gl.gpu.software.image_reads import with_image_reads

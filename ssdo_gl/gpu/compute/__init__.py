"""Full-screen shaders as compute shaders, where a device runs those faster."""

from __future__ import annotations

from ssdo_gl.gpu.compute.compute_program import ComputeProgram, can_compute
from ssdo_gl.gpu.compute.fragment_speed import computes_faster
from ssdo_gl.gpu.compute.kernel import Kernel, kernel_source
from ssdo_gl.gpu.compute.translation import compute_source
from ssdo_gl.gpu.compute.visible_surface import (
    CLEARS,
    IDS,
    INDICES,
    INSTANCES,
    PIXELS,
    STREAMS,
    TRIANGLES,
    visible_surface_source,
)

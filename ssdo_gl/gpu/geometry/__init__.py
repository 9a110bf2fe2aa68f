"""The scene's triangles on the device, and what draws them."""

from __future__ import annotations

from ssdo_gl.gpu.geometry.device_geometry import Geometry, Numbered
from ssdo_gl.gpu.geometry.draw_group import IMAGE_NAMES, Features, grouped
from ssdo_gl.gpu.geometry.instances import CLIP_MARGIN, NEAREST_CLIP_RATIO, CameraPose, Viewpoint
from ssdo_gl.gpu.geometry.triangle_rasterizer import TriangleRasterizer, can_rasterize
from ssdo_gl.gpu.geometry.visible_triangles import draw_surfaces

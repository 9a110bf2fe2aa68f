"""Linearly transformed cosines that stand for the lobes of glossy surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import moderngl
import numpy as np

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec

# Made by ``benchmarks/ltc_fit.py``.
TABLE_FILE = Path(__file__).with_name("lobe_transforms.npy")


class LobeTransformsPass(RenderPass):
    """Uploads `lobe_transforms`, linearly interpolated.

    Over cosine of the view and roughness, nodes from 0 to 1: the numbers of the matrix
    ((x, 0, y), (0, 1, 0), (z, 0, w)) that makes the lobe a clamped cosine, in the frame
    of the normal with the view in the plane of x and z (Heitz et al. 2016).
    """

    name = "lobe_transforms"
    writes: Mapping[str, TextureSpec] = {"lobe_transforms": TextureSpec(4, "f4", own=True)}
    depends_on = ()

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Return the table as a new texture."""
        table = np.load(TABLE_FILE, allow_pickle=False)
        texture = make_texture(context.gl, (table.shape[1], table.shape[0]), 4, "f4", table)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        return {"lobe_transforms": texture}

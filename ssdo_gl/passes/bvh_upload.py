"""The scene's triangles as a hierarchy that shaders can trace rays through."""

from __future__ import annotations

from collections.abc import Mapping

import moderngl
import numpy as np
from numpy.typing import NDArray

from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.scene.bvh import RECORD_WORDS, cached_bvh

# Records in a row of the texture: 256 of four texels are the 1024 that OpenGL 3.3
# guarantees. `shaders/lib/bvh.glsl` knows the number as BVH_ROW_SHIFT.
RECORDS_PER_ROW = 256


def folded(records: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Return records (R, 16) as an image (rows, 1024, 4), rows a power of two."""
    rows = -(-len(records) // RECORDS_PER_ROW)
    # Powers of two, so that texel centres are exact in float32 texture coordinates.
    rows = 1 << (rows - 1).bit_length()
    image = np.zeros((rows * RECORDS_PER_ROW, RECORD_WORDS), dtype=np.uint32)
    image[: len(records)] = records
    return image.reshape(rows, RECORDS_PER_ROW * RECORD_WORDS // 4, 4)


class BvhUploadPass(RenderPass):
    """Uploads `bvh`: the records of `scene.bvh.Bvh`, 256 to a row."""

    name = "bvh_upload"
    writes: Mapping[str, TextureSpec] = {"bvh": TextureSpec(4, "u4", own=True)}
    depends_on = ("geometry",)

    def execute(self, context: PassContext) -> dict[str, moderngl.Texture]:
        """Build the hierarchy unless the scene's is known, and return it as a texture."""
        image = folded(cached_bvh(context.frame.scene).records)
        size = image.shape[1], image.shape[0]
        return {"bvh": make_texture(context.gl, size, 4, "u4", image)}

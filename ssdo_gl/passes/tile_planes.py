"""What squares of the frame show, in a few numbers."""

from __future__ import annotations

from collections.abc import Hashable

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec


class TilePlanesPass(RenderPass):
    """Writes `tile_plane` and `tile_depths`, a texel for each square of the frame.

    Parameters
    ----------
    tile_size : int
        Pixels along a square's sides, a power of two.
    """

    def __init__(self, tile_size: int) -> None:
        self.name = "tile_planes"
        self.reads = ("z_vs", "normals_vs")
        spec = TextureSpec(4, scale=1.0 / tile_size, transient=True)
        self.writes = {"tile_plane": spec, "tile_depths": spec}
        self.depends_on = ("view",)
        self._tile_size = tile_size

    def settings_key(self) -> Hashable:
        """Return the size of the squares."""
        return self._tile_size

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen(
                "passes/tile_planes.frag", {"OPEN_TILE_SIZE": self._tile_size}
            ),
            context.target,
            context.frame.view.uniforms(),
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )

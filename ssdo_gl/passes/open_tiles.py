"""Squares of the frame in which nothing can be blocked."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from typing import Any

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings

# Within a ball that is at least three radii away, as `passes/open_tiles.frag` asks, a step of the
# projected ray is at most this much longer in space than in the middle: z / (z - R).
LARGEST_PERSPECTIVE = 1.5


def step_reach(settings: ScreenSpaceSettings, step_count: int) -> float:
    """Return how far along its ray the depth may lie that a step is tested with.

    ``front_slack`` strides of ``1 / (step_count - 1)`` each, which march.glsl spreads over
    the ray with a derivative of at most 1 + growth; never more than the whole ray.
    """
    part = settings.front_slack / max(step_count - 1, 1) * (1.0 + settings.step_growth)
    return settings.radius * min(1.0, part * LARGEST_PERSPECTIVE)


def uniforms(estimators: Sequence[tuple[ScreenSpaceSettings, int]], frame: Frame) -> dict[str, Any]:
    """Return the uniforms of ``passes/open_tiles.frag``, on the safe side for all `estimators`."""
    return {
        **frame.view.uniforms(),
        "u_radius": max(settings.radius for settings, _ in estimators),
        "u_bias": min(settings.bias for settings, _ in estimators),
        "u_step_reach": max(step_reach(settings, count) for settings, count in estimators),
    }


class OpenTilesPass(RenderPass):
    """Writes `open_tiles`: 1 for squares in which no direction of any point is blocked.

    Parameters
    ----------
    estimators : sequence of (ScreenSpaceSettings, int)
        Who will rely on it, and the fewest steps that each takes along a ray.
    tile_size : int
        Pixels along a square's sides, a power of two.
    """

    def __init__(
        self, estimators: Sequence[tuple[ScreenSpaceSettings, int]], tile_size: int
    ) -> None:
        self.name = "open_tiles"
        self.reads = ("tile_plane", "tile_depths")
        self.writes = {"open_tiles": TextureSpec(1, scale=1.0 / tile_size, transient=True)}
        self.depends_on = ("view",)
        self._estimators = tuple(estimators)
        self._tile_size = tile_size

    def settings_key(self) -> Hashable:
        """Return what the estimators ask for and the size of the squares."""
        return self._estimators, self._tile_size

    def execute(self, context: PassContext) -> None:
        """Draw one triangle over the target."""
        assert context.target is not None
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen(
                "passes/open_tiles.frag", {"OPEN_TILE_SIZE": self._tile_size}
            ),
            context.target,
            uniforms(self._estimators, context.frame),
            {f"t_{name}": context.inputs[name] for name in self.reads},
        )

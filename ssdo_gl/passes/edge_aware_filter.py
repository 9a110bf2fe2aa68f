"""Denoises an estimator's image along surfaces and brings it to the frame's size."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import same_as

if TYPE_CHECKING:
    import moderngl

_SEPARABLE, _UPSAMPLE, _BOX, _COPY = range(4)
# Squares of values below this stay finite in float32, and no light is as bright.
VALUE_BOUND = 1.8e19


@dataclass(frozen=True)
class EdgeAwareFilterSettings:
    """Settings of the edge-aware filter."""

    filter: str = same_as(
        "filter", doc="edge: separable, along the surface; naive: 4 x 4 box; none: leave the noise"
    )
    tap_radius: int = setting(
        3, "edge: pixels read on each side, along both axes", unit="px", low=2, high=16
    )
    depth_tolerance: float = setting(
        0.5,
        "distance from the tangent plane, in footprints of a pixel, at which a neighbour "
        "counts a quarter",
        unit="px",
        low=0.01,
        high=1000.0,
    )
    use_normals: bool = setting(True, "edge: neighbours that face elsewhere count less")


def uniforms(settings: EdgeAwareFilterSettings, frame: Frame, stride: int) -> dict[str, Any]:
    """Return the uniforms of `passes/edge_aware_filter.frag` that all its stages share."""
    return {
        **frame.view.uniforms(),
        "u_stride": stride,
        "u_depth_tolerance": settings.depth_tolerance,
        "u_value_bound": VALUE_BOUND,
    }


class EdgeAwareFilterPass(RenderPass):
    """Averages each pixel with neighbours that lie on the same surface.

    Neighbours count by their distance from the pixel's tangent plane, and by their
    normals. Values that are not finite, negative or absurdly large are left out, so
    one faulty texel stays without effect. Background comes out neutral: visibility 1,
    irradiance 0, both where they share a texture.

    Parameters
    ----------
    name : str
        Of the pass.
    settings : EdgeAwareFilterSettings
    source, result : str
        Resources: ``visibility_raw`` -> ``visibility``, and so on. The source may have
        half the frame's size; the result has all of it.
    is_visibility : bool
        One value (written to one channel) instead of rgb and a.
    holds_z : bool
        The source's last channel is the depth of its receiver, which saves a read. The
        last channel of a source of irradiance that does not hold it is visibility.
    """

    def __init__(
        self,
        name: str,
        settings: EdgeAwareFilterSettings,
        *,
        source: str,
        result: str,
        is_visibility: bool = False,
        holds_z: bool = False,
    ) -> None:
        self.name = name
        self.settings = settings
        self.reads = (source, "z_vs", "normals_vs")
        self.writes = {result: TextureSpec(1 if is_visibility else 4)}
        self.depends_on = ("view",)
        self._source = source
        self._switches = {
            "IS_VISIBILITY": int(is_visibility),
            "VALUE_HOLDS_Z": int(holds_z),
        }
        self._scratch: list[tuple[moderngl.Texture, moderngl.Framebuffer]] = []

    def settings_key(self) -> Hashable:
        """Return the settings and switches."""
        return self.settings, self._source, tuple(self._switches.items())

    def execute(self, context: PassContext) -> None:
        """Run the filter's stages, the last of them into the target."""
        target = context.target
        assert target is not None
        value = context.inputs[self._source]
        stride = 1 if value.size == target.size else 2
        if self.settings.filter == "none":
            self._draw(context, _COPY, value, target, stride)
            return
        if self.settings.filter == "naive":
            stages: list[tuple[int, tuple[int, int]]] = [(_BOX, (0, 0))]
        else:
            stages = [(_SEPARABLE, (1, 0)), (_SEPARABLE, (0, 1))]
        # At half size all of them write to scratch and the upsampling to the target.
        scratch = self._scratch_for(context, value, len(stages) - (stride == 1))
        for number, (stage, axis) in enumerate(stages):
            if number == len(scratch):
                self._draw(context, stage, value, target, stride, axis)
                return
            result, framebuffer = scratch[number]
            self._draw(context, stage, value, framebuffer, stride, axis)
            value = result
        self._draw(context, _UPSAMPLE, value, target, stride)

    def _draw(
        self,
        context: PassContext,
        stage: int,
        value: moderngl.Texture,
        target: moderngl.Framebuffer,
        stride: int,
        axis: tuple[int, int] = (0, 0),
    ) -> None:
        defines: Mapping[str, int] = {
            **self._switches,
            "STAGE": stage,
            "TAP_RADIUS": self.settings.tap_radius,
            "USE_NORMALS": int(self.settings.use_normals),
        }
        draw_fullscreen(
            context.gl,
            context.shaders.fullscreen("passes/edge_aware_filter.frag", defines),
            target,
            {**uniforms(self.settings, context.frame, stride), "u_axis": axis},
            {
                "t_value": value,
                "t_z_vs": context.inputs["z_vs"],
                "t_normals_vs": context.inputs["normals_vs"],
            },
        )

    def _scratch_for(
        self, context: PassContext, value: moderngl.Texture, count: int
    ) -> list[tuple[moderngl.Texture, moderngl.Framebuffer]]:
        """Return `count` textures of the size and format of `value`, to draw into."""
        fits = len(self._scratch) == count and all(
            t.size == value.size and t.components == value.components for t, _ in self._scratch
        )
        if not fits:
            for texture, framebuffer in self._scratch:
                framebuffer.release()
                texture.release()
            self._scratch = []
            for _ in range(count):
                texture = make_texture(context.gl, value.size, value.components, "f4")
                self._scratch.append((texture, make_framebuffer(context.gl, [texture])))
        return self._scratch

"""Denoises an estimator's image along surfaces and brings it to the frame's size."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.render_pass import PassContext, RenderPass
from ssdo_gl.graph.resource import TextureSpec
from ssdo_gl.math3d import Region
from ssdo_gl.passes.own_lookup import GATHERED
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import same_as

if TYPE_CHECKING:
    import moderngl

# The settings of all filters, which those of a single one overrule; and a pass of several.
FILTER = "edge_aware_filter"
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


def uniforms(settings: EdgeAwareFilterSettings, frame: Frame) -> dict[str, Any]:
    """Return the uniforms of `passes/edge_aware_filter.frag` that all its stages share."""
    return {
        **frame.view.uniforms(),
        "u_depth_tolerance": settings.depth_tolerance,
        "u_value_bound": VALUE_BOUND,
    }


@dataclass(frozen=True)
class Signal:
    """An image to filter.

    Attributes
    ----------
    source, result : str
        Resources: ``visibility_raw`` -> ``visibility``, and so on. The source may have
        half the frame's size; the result has all of it.
    is_visibility : bool
        One value (written to one channel) instead of rgb and a.
    holds_z : bool
        The source's last channel is the depth of its receiver, which saves a read. The
        last channel of a source of irradiance that does not hold it is visibility.
    is_of_gloss : bool
        The source holds 0 for the depth where a surface is not glossy: that counts for no
        neighbour. Others count as far as the lobe is wide against what normals differ by. The
        result holds anything outside the frame's `gloss_region`.
    """

    source: str
    result: str
    is_visibility: bool = False
    holds_z: bool = False
    is_of_gloss: bool = False


@dataclass(frozen=True)
class Levels:
    """What tells a filter which pixels are on one level of light.

    Attributes
    ----------
    source : str
        Resource of the sources' size: light, all colours together, and its variance.
    tolerance : float
        Squared difference of two pixels' light, in the sum of their variances, from which on they
        count less for each other.
    """

    source: str
    tolerance: float

    def uniforms(self) -> dict[str, float]:
        """Return those of `lib/edge_aware_filter.glsl`."""
        return {"u_noise_tolerance": self.tolerance}


class Stage(NamedTuple):
    """One stage of a filter: its kind, and along which axis it looks."""

    kind: int
    is_vertical: bool = False


def _stages(filter_name: str, stride: int) -> list[Stage]:
    """Return the stages of a filter; `stride` is 2 for images of half size."""
    if filter_name == "none":
        return [Stage(_COPY)]
    edge = [Stage(_SEPARABLE), Stage(_SEPARABLE, is_vertical=True)]
    stages = [Stage(_BOX)] if filter_name == "naive" else edge
    return [*stages, Stage(_UPSAMPLE)] if stride > 1 else stages


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
    *signals : Signal
        One, or two of irradiance and of the same size: two take .64 of the time of two
        passes, because what weighs a neighbour is looked up once.
    parts_edges : bool
        Pixels at contacts, which trace many rays, and others do not mix. Where a source holds
        depths, those of the former are negative; else `gathered_near` tells.
    leaves_last : bool
        Whoever reads the results runs the last stage, see `LastStage`: they have the
        sources' size.
    scale : float
        Of the sources, relative to the frame.
    levels : Levels or None
        Tells which pixels are on one level of light, where the sources have the frame's size.
    factor : str or None
        An image of the frame's size: its rgb times the first source, once that is filtered.
    """

    overwrites: ClassVar[bool] = True

    def __init__(
        self,
        name: str,
        settings: EdgeAwareFilterSettings,
        *signals: Signal,
        parts_edges: bool = False,
        leaves_last: bool = False,
        scale: float = 1.0,
        levels: Levels | None = None,
        factor: str | None = None,
    ) -> None:
        self.factor = factor
        self.levels = levels if settings.filter == "edge" else None
        self.leaves_last = leaves_last
        self.name = name
        self.settings = settings
        self.signals = signals
        self.parts_edges = parts_edges
        says_edges = any(signal.holds_z for signal in signals)
        edges = GATHERED[1:] if parts_edges and not says_edges else ()
        gloss = ("gloss",) if any(signal.is_of_gloss for signal in signals) else ()
        light = () if self.levels is None else (self.levels.source,)
        times = () if factor is None else (factor,)
        sources = (signal.source for signal in signals)
        of_surface = ("z_vs", "normals_vs", *edges, *gloss)
        self.reads = (*sources, *of_surface, *light, *times)
        self._textures = {f"t_{name}": name for name in of_surface}
        size = scale if leaves_last else 1.0
        self.writes = {
            signal.result: TextureSpec(1 if signal.is_visibility else 4, scale=size)
            for signal in signals
        }
        self.depends_on = ("view",)
        self._switches = {
            "SIGNAL_COUNT": len(signals),
            "IS_VISIBILITY": int(any(signal.is_visibility for signal in signals)),
            "IS_OF_GLOSS": int(any(signal.is_of_gloss for signal in signals)),
            "Z_SIGNALS": sum(signal.holds_z << i for i, signal in enumerate(signals)),
            "PARTS_EDGES": (1 if says_edges else 2) if parts_edges else 0,
        }
        self._scratch: list[tuple[list[moderngl.Texture], moderngl.Framebuffer]] = []

    def renamed(self, names: Mapping[str, str]) -> EdgeAwareFilterPass:
        """Return one that writes the same to resources of other names."""
        signals = [replace(s, result=names.get(s.result, s.result)) for s in self.signals]
        return self.like(self.name, *signals)

    def like(self, name: str, *signals: Signal) -> EdgeAwareFilterPass:
        """Return one of another name that filters other images in the same way."""
        return EdgeAwareFilterPass(name, self.settings, *signals, **self.named)

    def defines_of(self, stage: Stage, stride: int, *, is_first: bool) -> dict[str, int]:
        """Return the defines of ``lib/edge_aware_filter.glsl``."""
        return {
            **self._switches,
            "STAGE": stage.kind,
            "IS_VERTICAL": int(stage.is_vertical),
            "STRIDE": stride,
            "IS_FIRST": int(is_first),
            "TAP_RADIUS": self.settings.tap_radius,
            "USE_NORMALS": int(self.settings.use_normals),
            "KNOWS_NOISE": 0,
        }

    def execute(self, context: PassContext) -> None:
        """Run the filter's stages, the last of them into the target."""
        target = context.target
        assert target is not None
        values = [context.inputs[signal.source] for signal in self.signals]
        stride = 1 if values[0].size == context.inputs["z_vs"].size else 2
        levels = self.levels if stride == 1 else None
        light = None if levels is None else context.inputs[levels.source]
        stages = _stages(self.settings.filter, stride)
        stages = stages[:-1] if self.leaves_last else stages
        scratch = self._scratch_for(context, values, light, len(stages) - 1)
        for number, stage in enumerate(stages):
            is_last = number == len(scratch)
            results, framebuffer = ([], target) if is_last else scratch[number]
            knows_noise = stage.kind == _SEPARABLE and light is not None
            defines = {
                **self.defines_of(stage, stride, is_first=number == 0),
                "KNOWS_NOISE": int(knows_noise),
                "LEAVES_NOISE": int(knows_noise and not is_last),
                "HAS_FACTOR": int(is_last and self.factor is not None),
            }
            textures = {f"t_value_{i}": value for i, value in enumerate(values)}
            textures |= {sampler: context.inputs[name] for sampler, name in self._textures.items()}
            if is_last and self.factor is not None:
                textures["t_factor"] = context.inputs[self.factor]
            values_of_levels: dict[str, float] = {}
            if levels is not None and light is not None:
                textures["t_light"] = light
                values_of_levels = levels.uniforms()
            draw_fullscreen(
                context.gl,
                context.shaders.fullscreen("passes/edge_aware_filter.frag", defines),
                framebuffer,
                {
                    **uniforms(self.settings, context.frame),
                    **values_of_levels,
                },
                textures,
                region=self._region(context.frame, 0 if is_last else self.settings.tap_radius),
            )
            values, light = results[: len(values)], results[-1] if knows_noise and results else None

    def _region(self, frame: Frame, rows: int) -> Region | None:
        """Return where to draw so that `rows` more to each side may be read afterwards."""
        if frame.gloss_region is None or not self.signals[0].is_of_gloss:
            return None
        x, y, width, height = frame.gloss_region
        first, end = max(y - rows, 0), min(y + height + rows, frame.view.size[1])
        return x, first, width, end - first

    def _scratch_for(
        self,
        context: PassContext,
        values: list[moderngl.Texture],
        light: moderngl.Texture | None,
        count: int,
    ) -> list[tuple[list[moderngl.Texture], moderngl.Framebuffer]]:
        """Return `count` sets of textures like `values`, and `light`, to draw into."""
        shapes = values if light is None else [*values, light]
        wanted = [(value.size, value.components) for value in shapes]
        fits = len(self._scratch) == count and all(
            [(t.size, t.components) for t in textures] == wanted for textures, _ in self._scratch
        )
        if not fits:
            for textures, framebuffer in self._scratch:
                framebuffer.release()
                for texture in textures:
                    texture.release()
            self._scratch = []
            for _ in range(count):
                textures = [make_texture(context.gl, *shape, "f4") for shape in wanted]
                self._scratch.append((textures, make_framebuffer(context.gl, textures)))
        return self._scratch


class LastStage(NamedTuple):
    """The last stage of a filter of one image, run by the pass that reads the result."""

    settings: EdgeAwareFilterSettings
    stage: Stage
    defines: Mapping[str, int]
    wiring: Mapping[str, str]

    def uniforms(self, context: PassContext) -> dict[str, Any]:
        """Return the uniforms of ``lib/edge_aware_filter.glsl``."""
        return uniforms(self.settings, context.frame)


def without_last_stage(
    whole: EdgeAwareFilterPass, scale: float
) -> tuple[EdgeAwareFilterPass | None, LastStage]:
    """Return what runs the other stages of a filter of one image, if there are any, and the last.

    Parameters
    ----------
    scale : float
        Of its source, relative to the frame.
    """
    (signal,) = whole.signals
    stride = 1 if scale == 1.0 else 2
    stages = _stages(whole.settings.filter, stride)
    source, rest = signal.source, None
    if len(stages) > 1:
        source = f"{signal.result}_before_last"
        first = replace(signal, result=source)
        rest = whole.like(whole.name, first).changed(leaves_last=True, scale=scale)
    defines = whole.defines_of(stages[-1], stride, is_first=rest is None)
    wiring = {"t_value_0": source, **{f"t_{name}": name for name in whole.reads[1:]}}
    return rest, LastStage(whole.settings, stages[-1], defines, wiring)


def joined_filters(
    passes: Sequence[RenderPass], order: Sequence[RenderPass]
) -> tuple[RenderPass, ...]:
    """Return `passes` with filters of equal settings and sizes in pairs, where they can be.

    Parameters
    ----------
    order : sequence of RenderPass
        Those of them that will run, each behind what it reads.
    """
    specs = {name: spec for item in order for name, spec in item.writes.items()}
    # Which filters each resource is made from.
    behind: dict[str, frozenset[str]] = {}
    open_: dict[Hashable, EdgeAwareFilterPass] = {}
    joined: dict[str, RenderPass | None] = {}
    for item in order:
        before = frozenset().union(*(behind[name] for name in item.reads))
        is_filter = isinstance(item, EdgeAwareFilterPass)
        behind.update(dict.fromkeys(item.writes, before | {item.name} if is_filter else before))
        if not isinstance(item, EdgeAwareFilterPass):
            continue
        if item.signals[0].is_visibility or item.signals[0].is_of_gloss:
            continue
        key = (
            item.settings,
            item.parts_edges,
            item.levels,
            item.factor,
            specs[item.signals[0].source].scale,
        )
        first = open_.pop(key, None)
        if first is None or first.name in before:
            open_[key] = item
        else:
            signals = first.signals + item.signals
            joined[first.name] = None
            joined[item.name] = item.like(FILTER, *signals)
    found = (joined.get(item.name, item) for item in passes)
    return tuple(item for item in found if item is not None)

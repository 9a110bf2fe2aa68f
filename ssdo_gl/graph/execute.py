"""Runs a compiled graph: owns its textures, reuses what cannot have changed, times."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Hashable
from typing import TYPE_CHECKING, NamedTuple

from ssdo_gl.gpu.clear import clear
from ssdo_gl.gpu.timer import Timer
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.graph import Plan
from ssdo_gl.graph.pass_results import Identities, KeptResult, PassResults, SharedResults
from ssdo_gl.graph.plan_steps import SCENE_DOMAINS, PlanSteps, Step
from ssdo_gl.graph.render_pass import (
    PassContext,
    ProgressCallback,
    RenderPass,
    TextureWithFacts,
)

if TYPE_CHECKING:
    import moderngl

    from ssdo_gl.gpu.context import Device
    from ssdo_gl.gpu.geometry import Geometry
    from ssdo_gl.gpu.shader import ShaderLibrary


_SCENE = tuple(sorted(SCENE_DOMAINS))


class PassTiming(NamedTuple):
    """What one pass did in one frame.

    Attributes
    ----------
    ran : bool
        False if its result of an earlier frame still held, or nothing read it.
    gpu_ms : float or None
        Milliseconds by the executor's timer; None when timing was off or it was reused.
    cpu_ms : float
        Milliseconds until the pass had issued its commands.
    was_made : bool
        Whether it has ever run for what this frame shows.
    """

    name: str
    ran: bool
    gpu_ms: float | None
    cpu_ms: float
    was_made: bool = True


class Executor:
    """Runs plans on one device and keeps the textures between frames.

    Everything a pass is made from - its settings, the size, the domains it depends
    on and, recursively, what it reads - has an identity. A pass runs only if somebody
    needs its result and there is none of this identity. Transient textures are lent to
    later passes of the same frame once their last reader has run. Two passes of the
    same name in different plans replace each other.

    Attributes
    ----------
    is_settled : bool
        Whether the last frame left no work to gradual passes, and stands for itself.
    before_pass : callable or None
        Called before each pass that runs. It may raise to give the frame up, and so may a
        pass: what had been finished stands.
    """

    def __init__(
        self, device: Device, shaders: ShaderLibrary, shared: SharedResults | None = None
    ) -> None:
        self._device = device
        self._shaders = shaders
        self._shared = shared or SharedResults()
        self._results = PassResults(device.gl, self._shared)
        self._identities = Identities()
        self._texel: moderngl.Texture | None = None
        self.is_settled = True
        self._steps: PlanSteps | None = None
        self._kinds: list[int] = []
        self._scene: list[Hashable] = []
        self.timer = Timer(device)
        self.before_pass: Callable[[], None] | None = None

    @property
    def texture_count(self) -> int:
        """Number of textures that exist because of this executor, those of passes excluded."""
        return self._results.pool.texture_count

    def run(
        self,
        plan: Plan,
        frame: Frame,
        geometry: Geometry,
        *,
        time_passes: bool = False,
        progress: ProgressCallback | None = None,
    ) -> list[PassTiming]:
        """Run `plan` for `frame` and return one timing per pass, in order.

        Parameters
        ----------
        time_passes : bool
            Bracket every pass by the timer. On a software renderer this waits for
            each pass to finish, so passes no longer overlap.
        progress : ProgressCallback or None
            Handed to the passes.
        """
        steps = self._steps_of(plan, frame)
        sources, identities = self._identify(steps, frame)
        self._results.take_over(steps, sources)
        stale = self._stale(steps, identities)
        textures: dict[str, moderngl.Texture] = defaultdict(self._any_texture)
        facts: dict[str, object] = {}
        timings, present = [], self._results.present
        # What was averaged with other frames is not what this one is at rest.
        self.is_settled = frame.moves == 0
        is_complete = True
        shaders = self._shaders.choosing(frame.view.choices)
        for step in steps.order:
            item = step.item
            if item.name in stale:
                if self.before_pass is not None:
                    self.before_pass()
                result = self._results.prepared(step, sources[item.name])
                last = result.returned() if item.gets_last(frame) else {}
                context = PassContext(
                    *(self._device.gl, shaders, geometry, frame),
                    {name: textures[name] for name in item.reads},
                    result.target,
                    progress,
                    {n: facts[n] for n in item.reads if n in facts} if facts else {},
                    last,
                    is_complete,
                )
                # Given up in between, it would be neither what it was nor what it should become.
                result.identity = -1
                timer = self.timer if time_passes else None
                timings.append(self._execute(item, result, context, timer))
                # What was interrupted must not pass for the finished result.
                if not item.statistics.get("partial"):
                    result.identity = identities[item.name]
                if not item.is_settled:
                    self._identities_of(step).add_part(sources[item.name])
                    self.is_settled, is_complete = False, is_complete and not item.lags
            else:
                was_made = self._results.has_made(item.name, identities[item.name])
                timings.append(PassTiming(item.name, False, None, 0.0, was_made))
            if (made := present.get(item.name)) is not None:
                textures.update(made.textures)
                if made.facts:
                    facts.update(made.facts)
            if timings[-1].ran:
                self._results.lend_on(step)
        return timings

    def texture(self, resource: str) -> moderngl.Texture:
        """Return the texture that the last run left in `resource`, an output of its plan."""
        for step in self._steps.order if self._steps is not None else ():
            result = self._results.present.get(step.item.name)
            if result is not None and resource in result.textures:
                return result.textures[resource]
        raise KeyError(resource)

    def forget(self) -> None:
        """Make all passes run again in the next frame."""
        self._results.forget()

    def release(self) -> None:
        """Free every texture and framebuffer; what is shared, with the last who holds it."""
        self._steps = None
        if self._texel is not None:
            self._results.pool.give_back(self._texel)
            self._texel = None
        self._results.release()

    def _steps_of(self, plan: Plan, frame: Frame) -> PlanSteps:
        """Return the steps of a plan; free what it has no use for where it is another."""
        before, size = self._steps, frame.view.size
        scene = [frame.versions.get(domain) for domain in _SCENE]
        is_same_scene, self._scene = scene == self._scene, scene
        steps = before
        if steps is None or steps.plan is not plan or steps.size != size:
            steps = self._steps = PlanSteps(plan, size)
            self._kinds = [self._identities_of(step).of(step.kind) for step in steps.order]
        is_same_shape = before is not None and before.shape == steps.shape
        present = self._results.present
        # What moves has another scene in every frame.
        if is_same_shape and (is_same_scene or present.keys() <= steps.formats.keys()):
            return steps
        self._results.fit(steps.formats, keeps_shared=frame.is_live and is_same_scene)
        return steps

    def _identities_of(self, step: Step) -> Identities:
        return self._shared.identities if step.is_of_scene else self._identities

    def _identify(self, steps: PlanSteps, frame: Frame) -> tuple[dict[str, int], dict[str, int]]:
        """Return two numbers per pass, of what it is made from and of how it is at present.

        Each is equal exactly when that is equal. Only the second counts the parts that are
        there of what is made gradually.
        """
        for table in (self._identities, self._shared.identities):
            table.tidy()
        versions = {
            domain: self._shared.identities.of((domain, frame.versions.get(domain)))
            if domain in SCENE_DOMAINS
            else self._identities.of((domain, frame.versions.get(domain)))
            for domain in steps.domains
        }
        sources: dict[str, int] = {}
        of_pass: dict[str, int] = {}
        of_resource: dict[str, int] = {}
        source_of: dict[str, int] = {}
        for kind, step in zip(self._kinds, steps.order, strict=True):
            item, table = step.item, self._identities_of(step)
            own = kind, step.versions_of(versions), frame.is_live if item.is_gradual else None
            number = source = table.of((own, step.inputs_of(of_resource)))
            if step.is_of_scene:
                source = table.of((own, step.inputs_of(source_of), "source"))
                source_of.update(dict.fromkeys(item.writes, source))
            if item.is_gradual and (part := table.parts.get(source)):
                number = table.of((number, part))
            of_pass[item.name], sources[item.name] = number, source
            for resource in item.writes:
                of_resource[resource] = number
        return sources, of_pass

    def _stale(self, steps: PlanSteps, identities: dict[str, int]) -> set[str]:
        """Return the passes that must run: walk back from the outputs to what still holds."""
        wanted = set(steps.plan.outputs)
        stale: set[str] = set()
        for step in reversed(steps.order):
            item = step.item
            if wanted.isdisjoint(item.writes):
                continue
            result = self._results.present.get(item.name)
            is_made = result is not None and result.identity == identities[item.name]
            if result is None or not is_made or not item.writes.keys() <= result.textures.keys():
                stale.add(item.name)
                wanted.update(item.reads)
        return stale

    def _any_texture(self) -> moderngl.Texture:
        """Return what stands for a texture that was never made, and does not matter."""
        if self._texel is None:
            self._texel = self._results.pool.borrow((1, 1), 4, "f4")
        return self._texel

    @staticmethod
    def _execute(
        item: RenderPass, result: KeptResult, context: PassContext, timer: Timer | None
    ) -> PassTiming:
        if context.target is not None:
            context.target.use()
            if not item.overwrites:
                clear(context.gl, context.shaders, context.target)
        start = time.perf_counter()
        gpu_ms = None
        if timer is not None:
            with timer:
                own = item.execute(context)
            gpu_ms = timer.elapsed_ms
        else:
            own = item.execute(context)
        cpu_ms = (time.perf_counter() - start) * 1e3
        result.facts.clear()
        for name, made in own.items() if own else ():
            if isinstance(made, TextureWithFacts):
                result.textures[name], result.facts[name] = made
            else:
                result.textures[name] = made
        if not item.writes.keys() <= result.textures.keys():
            missing = [name for name in item.writes if name not in result.textures]
            raise RuntimeError(f"pass {item.name!r} did not return {', '.join(missing)}")
        return PassTiming(item.name, True, gpu_ms, cpu_ms)

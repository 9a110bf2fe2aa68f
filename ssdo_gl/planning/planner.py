"""Plans each frame from what is known of scene and view; remembers what has not changed."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ssdo_gl.effects.request import Decided, Request
from ssdo_gl.facts.bodies import Bodies, bodies_of
from ssdo_gl.facts.content import SceneContent, analyse
from ssdo_gl.facts.view import ViewFacts, view_facts
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.graph.graph import Plan, compile_graph
from ssdo_gl.last_made import LastMade, MadeOfEach, are_same
from ssdo_gl.math3d import Region
from ssdo_gl.planning.pipeline import Pipeline
from ssdo_gl.planning.walk import build, decide
from ssdo_gl.scene.lights import BLACK, Light
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings
from ssdo_gl.settings.methods import METHODS

# Plans kept for when a decision goes back and forth; each may hold textures of its own.
MOST_PLANS = 8
# Lights whose stand-ins are kept: more than a scene that can be drawn at once has.
MOST_LIGHTS = 4096


@dataclass(frozen=True)
class FramePlan:
    """What one frame runs, and the scene as its passes are to see it.

    Attributes
    ----------
    scene : Scene
        Without lights that cannot matter. Indices of lights are those of the whole scene.
    gloss_region, emission_region : Region or None
        As in `Frame`.
    """

    pipeline: Pipeline
    graph: Plan
    scene: Scene
    decided: Decided
    gloss_region: Region | None
    emission_region: Region | None


class _Outcome(NamedTuple):
    """What was decided, and the passes for it."""

    decided: Decided
    pipeline: Pipeline
    graph: Plan


class Planner:
    """Decides what a frame runs. Asked again about the same frame, it answers at once."""

    def __init__(self) -> None:
        self._last: tuple[tuple[object, ...], object, FramePlan] | None = None
        self._leaned: LastMade[Scene] = LastMade()
        self._content: LastMade[SceneContent] = LastMade()
        self._bodies: LastMade[Bodies] = LastMade()
        # By images, liveness, and all of the view that is decided by.
        self._plans: dict[tuple[object, ...], _Outcome] = {}
        self._plans_for: tuple[object, ...] = ()
        self._unlit = MadeOfEach(_unlit, MOST_LIGHTS)
        self._mapped = MadeOfEach(_mapped, MOST_LIGHTS)
        self._shadowed = MadeOfEach(self._with_maps, MOST_PLANS)

    def plan(
        self,
        scene: Scene,
        moved: Scene,
        settings: Settings,
        wanted: tuple[str, ...],
        view: FrameView | None = None,
        *,
        is_live: bool = False,
    ) -> FramePlan:
        """Return what a frame has to run.

        Parameters
        ----------
        scene : Scene
            At rest.
        moved : Scene
            As it stands in this frame.
        settings : Settings
            With the radius filled in.
        wanted : tuple of str
            AOV names or ``display``.
        view : FrameView or None
            Without it, nothing is ruled out by what the camera sees.
        is_live : bool
            Of a window's frames, one after the other.
        """
        same = (scene, moved, settings)
        view_key = (wanted, None if view is None else view.key(), is_live)
        last = self._last
        if last is not None and are_same(last[0], same) and last[1] == view_key:
            return last[2]
        # Rays ask no light how it is shadowed.
        by_maps = not settings.is_reference and settings.chosen_shadows != "none"
        if METHODS[settings.method].is_all_light and by_maps:
            scene, moved = self._shadowed.of(scene), self._shadowed.of(moved)
        facts = None
        if view is not None and settings.effects == "auto" and not settings.is_reference:
            facts = self._facts(moved, view)
        decided, pipeline, graph = self._decide(scene, settings, wanted, facts, is_live)
        gloss = None if facts is None else facts.gloss_region
        emission = None if facts is None else facts.emission_region
        lean = self._leaned.get((moved, decided), lambda: self._lean(moved, decided))
        planned = FramePlan(pipeline, graph, lean, decided, gloss, emission)
        self._last = (same, view_key, planned)
        return planned

    def content(self, scene: Scene) -> SceneContent:
        """Return what `scene` contains, looked up once for each scene."""
        return self._content.get((scene,), lambda: analyse(scene))

    def _with_maps(self, scene: Scene) -> Scene:
        """Return `scene` with shadow maps for lights that SSDO blocks within R alone."""
        if all(light.shadow != "ssdo" for light in scene.lights):
            return scene
        lights = tuple(self._mapped.of(light) for light in scene.lights)
        return dataclasses.replace(scene, lights=lights)

    def _facts(self, scene: Scene, view: FrameView) -> ViewFacts:
        parts = (scene.objects, scene.meshes, scene.materials)
        return view_facts(self._bodies.get(parts, lambda: bodies_of(scene)), view)

    def _decide(
        self,
        scene: Scene,
        settings: Settings,
        wanted: tuple[str, ...],
        facts: ViewFacts | None,
        is_live: bool,
    ) -> _Outcome:
        if not are_same(self._plans_for, (scene, settings)):
            self._plans.clear()
            self._plans_for = scene, settings
        asked = wanted, is_live
        key = (*asked, None if facts is None else facts.kinds)
        if key not in self._plans:
            request = Request(scene, self.content(scene), settings, wanted, facts, is_live=is_live)
            decided = decide(request)
            # Another view may be decided alike: passes keep what they have made.
            same = (k for k, o in self._plans.items() if k[:2] == asked and o.decided == decided)
            if (known := next(same, None)) is not None:
                outcome = self._plans[known]
            else:
                pipeline = build(request)
                graph = compile_graph(pipeline.passes, pipeline.resources)
                outcome = _Outcome(decided, pipeline, graph)
            while len(self._plans) >= MOST_PLANS:
                self._plans.pop(next(iter(self._plans)))
            self._plans[key] = outcome
        return self._plans[key]

    def _lean(self, scene: Scene, decided: Decided) -> Scene:
        """Return `scene` as passes are to see it; the very same if nothing is spared."""
        lights: Sequence[Light] = scene.lights
        if decided.lights is not None:
            choices = zip(lights, decided.lights, strict=True)
            lights = [light if is_on else self._unlit.of(light) for light, is_on in choices]
        return (
            scene
            if are_same(lights, scene.lights)
            else dataclasses.replace(scene, lights=tuple(lights))
        )


def _unlit(light: Light) -> Light:
    return light.without_shadow().with_emitted(BLACK)


def _mapped(light: Light) -> Light:
    return dataclasses.replace(light, shadow="map") if light.shadow == "ssdo" else light

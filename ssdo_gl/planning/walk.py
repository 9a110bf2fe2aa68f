"""One walk over the registry: what a frame runs, how its passes are wired, and why."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

from ssdo_gl.effects import registry
from ssdo_gl.effects.effect import Effect, ImageSource, ReasonedPass, Term
from ssdo_gl.effects.request import Decided, Decision, Request
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.composite import CompositePass, OcclusionMode
from ssdo_gl.passes.gbuffer import GBUFFER_IMAGES, GBufferPass
from ssdo_gl.passes.radiance_aov import RadianceAovPass
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms
from ssdo_gl.passes.tone_map import ToneMapPass, ToneMapSettings
from ssdo_gl.planning.averages import averaged
from ssdo_gl.planning.merged_passes import (
    with_joined_filters,
    with_last_stage,
    with_shown_sum,
    with_summed_senders,
    without_unread_targets,
)
from ssdo_gl.planning.pipeline import Pipeline
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.settings.backgrounds import ENVIRONMENT, color_code


def decide(request: Request) -> Decided:
    """Ask every effect whether it is needed, those that others rest on first."""
    effects = registry.effects()
    request.pass_settings = registry.pass_settings()
    request.asked = _asked(request, effects)
    running: list[Effect] = []
    for effect in effects:
        if effect.is_asked(request):
            decision = effect.need(request)
            request.record(decision)
            if decision.run:
                running.append(effect)
                request.running.append(effect.name)
                request.marches.append(effect.marches)
                request.traces |= effect.traces
                request.looks_around |= effect.looks_around
                request.reads_surface_cache |= effect.reads_surface_cache
                request.anything_is_sent = any(other.sends(request) for other in running)
    for effect in running:
        for shortcut in effect.shortcuts:
            request.takes(shortcut)
    if request.looks_around and not request.settings.is_reference:
        request.record(_averaging(request))
    return request.decided()


def _averaging(request: Request) -> Decision:
    """Return whether frames are averaged with those before them."""
    if request.averages:
        reason = "in a window, noise of what moves is averaged over frames"
    elif request.is_live:
        reason = "it is switched off"
    else:
        reason = "a single picture depends on no other; in a window, what moves is averaged"
    return Decision("averaging over frames", request.averages, reason)


def _asked(request: Request, effects: Iterable[Effect]) -> frozenset[str]:
    """Return the names of the effects that the picture, or an image, is made of."""
    method, wanted = request.settings.method, set(request.wanted)

    def is_shown(effect: Effect) -> bool:
        own = {*(term.name for term in effect.terms), *effect.images}
        return method in effect.methods | effect.shown_by and bool(own & wanted)

    asked = [
        effect
        for effect in effects
        if is_shown(effect) or (request.shows_picture and method in effect.methods)
    ]
    if any(effect.gathers_from_senders for effect in asked):
        asked += [effect for effect in effects if effect.terms and method in effect.methods]
    return frozenset(effect.name for effect in asked)


def build(request: Request) -> Pipeline:
    """Return the passes of a request that was decided."""
    pipeline = _Builder(request).build()
    if request.is_full:
        return _averaged(pipeline, request)
    full = dataclasses.replace(request.settings, effects="full")
    everything = Request(request.scene, request.content, full, request.wanted)
    decide(everything)
    skipped = _reasons_to_skip(pipeline, build(everything))
    pipeline = with_joined_filters(dataclasses.replace(pipeline, skipped=skipped))
    pipeline = _averaged(with_summed_senders(with_shown_sum(pipeline)), request)
    return with_last_stage(pipeline)


def _reasons_to_skip(pipeline: Pipeline, full: Pipeline) -> dict[str, str]:
    """Return why the passes do not run that only the full pipeline has."""
    has = {item.name for item in pipeline.passes}
    rows = [row for row in pipeline.decided.rows if not row.run]
    reasons: dict[str, str] = {}
    for name in (item.name for item in full.order if item.name not in has):
        spared = (row.reason for row in rows if name in row.passes)
        reasons[name] = next(spared, "no effect that runs needs it")
    return reasons


# No visibility multiplies anything.
NO_OCCLUSION: tuple[None, OcclusionMode] = (None, "ambient")


class _Builder:
    """Wires the passes of all running effects, and what adds up their terms."""

    def __init__(self, request: Request) -> None:
        self.request = request
        self.passes: list[RenderPass] = []
        self.reasons: dict[str, str] = {}
        self.running = [e for e in registry.effects() if request.runs(e.name)]
        pictures = (effect.picture for effect in self.running)
        self.picture = next((name for name in pictures if name is not None), "beauty")

    def build(self) -> Pipeline:
        by_chance = self.request.content.has_translucency
        self.add(GBufferPass(by_chance=by_chance), "everything starts from what the camera sees")
        for effect in self.running:
            for reasoned in effect.passes(self.request):
                self.add(*reasoned)
        if any(effect.gathers_from_senders for effect in self.running):
            self.add(*self._senders())
        self._add_picture()
        outputs = {name: self._output(name) for name in self.request.wanted}
        decided = self.request.decided()
        pipeline = Pipeline(tuple(self.passes), outputs, decided, self.reasons)
        return (
            pipeline
            if self.request.is_full
            else without_unread_targets(pipeline, self.request.is_glossy)
        )

    def add(self, item: RenderPass, reason: str) -> None:
        self.passes.append(item)
        self.reasons[item.name] = reason

    def _senders(self) -> ReasonedPass:
        senders = [effect for effect in self.running if effect.sends(self.request)]
        sent = (term for effect in senders for term in effect.sent_terms(self.request))
        terms = [term for term in sent if not term.glossy]
        irradiances, radiances = _by_kind(terms)
        everything = (effect.sent_irradiance for effect in self.running)
        if found := next((name for name in everything if name is not None), None):
            irradiances = [found]
        sent_terms = SenderTerms(tuple(irradiances), tuple(radiances))
        item = SenderRadiancePass(sent_terms, glossy=self.request.is_glossy)
        return item, "what each surface sends on"

    def _backdrop(self) -> str:
        """Return what is shown where no surface is, if nobody chooses."""
        backdrop = self.request.scene.backdrop
        if backdrop is None:
            return ENVIRONMENT
        return color_code(backdrop, self.request.settings.exposure or 0.0)

    def _add_picture(self) -> None:
        """Add the sum of all terms, and the picture as a display shows it."""
        request = self.request
        shown = [e for e in self.running if request.settings.method in e.methods]
        occlusions = (effect.occlusion(request) for effect in shown)
        visibility, combine = next((found for found in occlusions if found), NO_OCCLUSION)
        terms = [term for effect in shown for term in effect.terms_of(request)]
        irradiances, radiances = _by_kind(term for term in terms if not term.glossy)
        composite = CompositePass(
            kind_of(request.scene.environment),
            irradiances=irradiances,
            radiances=radiances,
            gloss=[term.resource for term in terms if term.glossy],
            visibility=visibility,
            combine=combine,
            glossy=request.is_glossy,
        )
        self.add(composite, "adds up the terms")
        exposure = request.settings.exposure or 0.0
        background = request.settings.background or self._backdrop()
        tone = request.settings_of(
            "tone_map", ToneMapSettings, exposure=exposure, background=background
        )
        display = ToneMapPass(tone, self.picture)
        self.add(display, "from radiance to the display")

    def _output(self, name: str) -> ImageSource:
        """Return where image `name` is read from, adding a pass if it needs one."""
        if name == "display":
            return ImageSource("display", 4)
        if name == "beauty":
            return ImageSource(self.picture, 4)
        if name in GBUFFER_IMAGES:
            return ImageSource(*GBUFFER_IMAGES[name])
        for effect in self.running:
            if name in effect.images and (found := effect.image(self.request, name)):
                return found
        terms = [term for e in self.running for term in e.terms_of(self.request)]
        return self._output_of_terms(name, [term for term in terms if term.name == name])

    def _output_of_terms(self, name: str, terms: list[Term]) -> ImageSource:
        if not terms:
            return ImageSource(None, 3)
        if len(terms) == 1 and terms[0].kind == "radiance":
            return ImageSource(terms[0].resource, 3)
        resource = f"{name}_radiance"
        aov = RadianceAovPass(resource, *_by_kind(terms), glossy=self.request.is_glossy)
        self.add(aov, f"the image {name} was asked for")
        return ImageSource(resource, 3)


def _by_kind(terms: Iterable[Term]) -> tuple[list[str], list[str]]:
    """Return the resources that are irradiances, and those that are radiances."""
    terms = list(terms)
    return (
        [term.resource for term in terms if term.kind == "irradiance"],
        [term.resource for term in terms if term.kind == "radiance"],
    )


def _averaged(pipeline: Pipeline, request: Request) -> Pipeline:
    """Return `pipeline` with averages over frames, where those are decided."""
    if not request.averages:
        return pipeline
    passes, reasons = averaged(pipeline.passes, request)
    return dataclasses.replace(pipeline, passes=passes, reasons=pipeline.reasons | reasons)

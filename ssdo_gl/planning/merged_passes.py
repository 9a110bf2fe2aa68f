"""Passes whose work another one does on the way: filters in pairs, sums within what reads them."""

from __future__ import annotations

import dataclasses

from ssdo_gl.effects.bounce import BouncePass
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.composite import CompositePass, Display
from ssdo_gl.passes.edge_aware_filter import (
    FILTER,
    EdgeAwareFilterPass,
    joined_filters,
    without_last_stage,
)
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.tone_map import ToneMapPass
from ssdo_gl.planning.averages import SUMMED_LIGHT
from ssdo_gl.planning.pipeline import Pipeline


def without_unread_targets(pipeline: Pipeline, is_glossy: bool) -> Pipeline:
    """Return `pipeline` with a G-buffer of what the passes that will run read of it."""
    read = {resource for item in pipeline.order for resource in item.reads}
    read |= set(pipeline.resources)
    # Without it the albedo would be that of metals, too.
    read |= {"gloss"} if is_glossy and "albedo" in read else set()
    readers = [item for item in pipeline.order if "emission" in item.reads]
    are_sums = all(isinstance(item, CompositePass) for item in readers)
    clears = "emission" in pipeline.resources or not are_sums
    return pipeline.changed(
        {
            item: GBufferPass(
                read & item.TARGETS.keys(), by_chance=item.by_chance, clears_emission=clears
            )
            for item in pipeline.passes
            if isinstance(item, GBufferPass)
        }
    )


def with_joined_filters(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with one filter for two images, where that is possible."""
    passes = joined_filters(pipeline.passes, pipeline.order)
    reasons = {**pipeline.reasons, FILTER: "removes the sampling noise along surfaces"}
    return _with_summed_light(dataclasses.replace(pipeline, passes=passes, reasons=reasons))


def _with_summed_light(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with two images added up before the filter, if only the picture reads.

    The filter is linear and weighs both alike.
    """
    joined = next((item for item in pipeline.passes if item.name == FILTER), None)
    if not isinstance(joined, EdgeAwareFilterPass):
        return pipeline
    order = pipeline.order
    parts = joined.writes.keys()
    readers = [item for item in order if not parts.isdisjoint(item.reads)]
    if not parts.isdisjoint(pipeline.resources) or len(readers) != 1:
        return pipeline
    (composite,) = readers
    bounce = next(item for item in order if isinstance(item, BouncePass))
    bounced = [signal for signal in joined.signals if signal.source in bounce.writes]
    if not isinstance(composite, CompositePass) or not bounced:
        return pipeline
    (signal,) = bounced
    (added,) = (s.source for s in joined.signals if s is not signal)
    light = dataclasses.replace(signal, result=SUMMED_LIGHT)
    others = [name for name in composite.irradiances if name not in parts]
    return pipeline.changed(
        {
            bounce: bounce.changed(adds=added),
            joined: joined.like(FILTER, light),
            composite: composite.changed(irradiances=[*others, SUMMED_LIGHT]),
        }
    )


def with_shown_sum(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with the terms added up to what a display shows, if only that is read.

    A frame of `fast` takes .97 of the time, one of `balanced` .99.
    """
    readers = [item for item in pipeline.order if "beauty" in item.reads]
    tone = next((item for item in readers if isinstance(item, ToneMapPass)), None)
    if tone is None or len(readers) > 1 or "beauty" in pipeline.resources:
        return pipeline
    display = Display(tone.writes, tone.defines, tone.uniforms)
    others: dict[RenderPass, RenderPass | None] = {
        item: item.changed(display=display)
        for item in pipeline.passes
        if isinstance(item, CompositePass)
    }
    return pipeline.changed(
        {**others, tone: None}, "the sum of the terms is written as a display shows it"
    )


def with_last_stage(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with a filter that ends where the terms are added up, if only that reads.

    Frames of `fast`, of `balanced` and of the defaults of `bounce` take .97 of the time.
    """
    order = pipeline.order
    composite = next((item for item in order if isinstance(item, CompositePass)), None)
    if composite is None or not composite.irradiances:
        return pipeline
    last = composite.irradiances[-1]
    readers = [item for item in order if last in item.reads]
    whole = next((item for item in order if last in item.writes), None)
    if readers != [composite] or last in pipeline.resources:
        return pipeline
    if not isinstance(whole, EdgeAwareFilterPass) or len(whole.signals) > 1:
        return pipeline
    if whole.levels or whole.factor:
        return pipeline
    specs = {name: spec for item in order for name, spec in item.writes.items()}
    rest, end = without_last_stage(whole, specs[whole.signals[0].source].scale)
    summed = composite.changed(irradiances=composite.irradiances[:-1], last_stage=end)
    return pipeline.changed(
        {whole: rest, composite: summed},
        "its only stage is run where the terms are added up",
    )


def with_summed_senders(pipeline: Pipeline) -> Pipeline:
    """Return `pipeline` with the bounce adding up what senders send, where it asks few of them.

    A frame of `fast` takes .96 of the time.
    """
    order = pipeline.order
    senders = next((item for item in order if isinstance(item, SenderRadiancePass)), None)
    readers = [item for item in order if "sender_radiance" in item.reads]
    if senders is None or senders.glossy or len(readers) > 1:
        return pipeline
    (bounce,) = readers
    if not isinstance(bounce, BouncePass) or bounce.looks_up_much:
        return pipeline
    return pipeline.changed(
        {bounce: bounce.changed(terms=senders.terms), senders: None},
        "the bounce asks few surfaces, and adds up itself what they send",
    )

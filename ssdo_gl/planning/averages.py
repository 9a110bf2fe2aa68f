"""Which images of a window are averaged over frames, and what of them before the filter."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ssdo_gl.effects.bounce import BouncePass
from ssdo_gl.effects.directional import DirectionalPass
from ssdo_gl.effects.request import Request
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass
from ssdo_gl.passes.own_lookup import GATHERED
from ssdo_gl.passes.temporal import TEMPORAL, TemporalPass, TemporalSettings
from ssdo_gl.settings.methods import METHODS

# What the filter writes where nobody asks for one of two images.
SUMMED_LIGHT = "filtered_irradiance"
# Diffuse light belongs to the place where it is seen. What gloss reflects moves over it.
_AVERAGED = frozenset({"directional_irradiance", "bounce_irradiance", SUMMED_LIGHT, "visibility"})
# Direct light by a few shadow rays: noisy, but its shadows must not lag behind what moves.
_AVERAGED_IN_WALKS = frozenset({"emitters_irradiance"})
# Settings of passes whose images are not, or that a window changes while it moves.
_NOT_AVERAGED = ("direct.", "shadow_map.", "tone_map.")


# In so many directions light is looked for whose noise averages take out without a filter.
_DIRECTIONS_WITHOUT_FILTER = 8


def _unfiltered(
    item: RenderPass, passes: Iterable[RenderPass], request: Request, share: float
) -> tuple[str, str, float] | None:
    """Return which image of a filter is averaged in part as it was before; see `TemporalPass`.

    Bounced light alone is dark but for creases and has more noise than filters blur. With `gi`,
    whose far field is smooth, errors are .98 to 1.00, temporal errors 1.00 to 1.04.
    """
    if not isinstance(item, EdgeAwareFilterPass) or item.settings.filter != "edge":
        return None
    if METHODS[request.settings.method].is_all_light or share == 0.0:
        return None
    makers = {name: maker for maker in passes for name in maker.writes}
    for signal in item.signals:
        maker = makers[signal.source]
        is_chosen = signal.result in ("directional_irradiance", SUMMED_LIGHT)
        if is_chosen and isinstance(maker, DirectionalPass | BouncePass):
            settings = maker.settings
            if settings.receiver_stride == 1:
                noise = min(1.0, settings.direction_count / _DIRECTIONS_WITHOUT_FILTER)
                return f"{signal.result}_now", signal.source, share * noise
    return None


def averaged(
    passes: Sequence[RenderPass], request: Request
) -> tuple[tuple[RenderPass, ...], dict[str, str]]:
    """Return `passes` with filtered images averaged over frames, and why each average is made."""
    settings = request.settings_of(TEMPORAL, TemporalSettings)
    chosen = request.settings
    # Lamps that an animation moves light directly, by direct light that is not averaged; the rest
    # of `gi` is smooth.
    lit_by = "light_sources" if METHODS[chosen.method].is_all_light else "lights"
    made_from = (
        *(chosen.method, chosen.chosen_estimator, chosen.chosen_shadows, chosen.combine),
        *(request.radius, chosen.filter),
        tuple(item for item in chosen.overrides.items() if not item[0].startswith(_NOT_AVERAGED)),
    )
    found: list[RenderPass] = []
    reasons: dict[str, str] = {}
    has_rays = any(GATHERED[0] in item.writes for item in passes)
    for item in passes:
        is_of_walks = _AVERAGED_IN_WALKS.issuperset(item.writes)
        is_averaged = is_of_walks or _AVERAGED.issuperset(item.writes)
        if not isinstance(item, EdgeAwareFilterPass) or not is_averaged:
            found.append(item)
            continue
        images = {f"{result}_now": result for result in item.writes}
        name = f"{TEMPORAL}_{item.name.removesuffix('_filter')}"
        found.append(item.renamed({result: now for now, result in images.items()}))
        unfiltered = _unfiltered(item, passes, request, settings.unfiltered)
        average = TemporalPass(
            *(name, settings, images, made_from, unfiltered, lit_by),
            has_own_rays=has_rays if is_of_walks else item.parts_edges,
            camera_alone=is_of_walks,
        )
        found.append(average)
        reasons[name] = "averages what moves over frames"
    return tuple(found), reasons

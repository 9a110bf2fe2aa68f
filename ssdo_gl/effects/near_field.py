"""What the effects have in common that march through the depth buffer."""

from __future__ import annotations

import dataclasses
from typing import TypeVar

from ssdo_gl.effects.effect import ReasonedPass
from ssdo_gl.effects.request import Request, Shortcut, overridden
from ssdo_gl.passes.edge_aware_filter import (
    FILTER,
    EdgeAwareFilterPass,
    EdgeAwareFilterSettings,
    Signal,
)
from ssdo_gl.passes.far_probes import FarFieldSettings
from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings, default_thickness
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.settings import Settings

EstimatorSettings = TypeVar("EstimatorSettings", bound=ScreenSpaceSettings)

# Fields that make two estimators follow the same directions to the same ends.
DIRECTION_FIELDS = tuple(field.name for field in dataclasses.fields(ScreenSpaceSettings))
# Blocked directions are kept four to a texture. More than four textures cost what a second
# march would.
MOST_KEPT_DIRECTIONS = 16
# Where a direction takes fewer depth reads, keeping what they found saves nothing.
FEWEST_STEPS_WORTH_KEEPING = 4


def estimator_of(request: Request, name: str) -> str:
    """Return the estimator of the pass `name`: ssao, directional or bounce."""
    return str(request.override(f"{name}.estimator", request.settings.chosen_estimator))


def estimator_settings(
    request: Request, name: str, settings_class: type[EstimatorSettings]
) -> EstimatorSettings:
    """Return the settings of the estimator pass `name`, thickness filled in."""
    estimator = request.settings.chosen_estimator
    chosen = request.settings_of(name, settings_class, estimator=estimator)
    if chosen.thickness is not None:
        return chosen
    # By what the scene holds, not by whether its backs happen to be drawn.
    has_backs = reads_backs(request.settings) and request.content.has_closed_meshes
    return dataclasses.replace(chosen, thickness=default_thickness(chosen.estimator, has_backs))


def reads_backs(settings: Settings) -> bool:
    """Return whether the estimator in force uses the back-face layer."""
    return ESTIMATORS[settings.chosen_estimator].reads_backs


def far_field_settings(request: Request) -> FarFieldSettings:
    """Return the settings of the far field, with tiles that suit the frame."""
    settings = request.settings_of("far_field", FarFieldSettings)
    return settings.fitting(request.settings.size)


def receiver_stride(request: Request) -> int:
    """Return how many pixels lie from one that light is gathered at to the next."""
    names = ("directional.resolution_scale", "bounce.resolution_scale")
    scales = [request.override(name, request.settings.resolution_scale) for name in names]
    return 1 if 1.0 in scales else 2


def filtered(
    request: Request,
    name: str,
    source: str,
    result: str,
    *,
    is_visibility: bool = False,
    holds_z: bool = True,
    is_of_gloss: bool = False,
) -> ReasonedPass:
    """Return the filter pass `name` from `source` to `result`; see `EdgeAwareFilterPass`."""
    of_all = request.settings_of(FILTER, EdgeAwareFilterSettings)
    is_light = not is_visibility and not is_of_gloss
    item = EdgeAwareFilterPass(
        name,
        overridden(request.settings, name, of_all),
        Signal(source, result, is_visibility, holds_z, is_of_gloss),
        parts_edges=is_light and request.runs("far_field"),
    )
    return item, "removes the sampling noise along surfaces"


def _reason_to_be_open(request: Request) -> str | None:
    """Return why nothing within R can block any visible point, or None if something may."""
    view = request.view
    if view is None:
        return None
    if view.is_empty:
        return "no surface is in view"
    names = (n for n, cls in request.pass_settings.items() if issubclass(cls, ScreenSpaceSettings))
    if view.is_alone and all(ESTIMATORS[estimator_of(request, n)].has_radius for n in names):
        return "what is in view is a box that stands alone"
    return None


# Nothing within R blocks any direction of any visible point. A frame of a lone textured box
# (a model made by others) takes .41 of the time.
OPEN_DIRECTIONS = Shortcut(
    "blocked directions",
    _reason_to_be_open,
    ("ssao", "ssao_filter", "directional", "directional_filter"),
    ("constant_visibility",),
)


def can_share_directions(request: Request, first: str, second: str) -> bool:
    """Return whether the pass `second` can take over what the pass `first` found blocked."""
    if request.is_full or request.settings.is_reference:
        return False
    if any(
        request.override(f"{first}.{name}", None) != request.override(f"{second}.{name}", None)
        for name in DIRECTION_FIELDS
    ):
        return False
    march = ScreenSpaceSettings(
        estimator=estimator_of(request, second),
        samples=request.override(f"{second}.samples", request.settings.samples),
        steps=request.override(f"{second}.steps", request.settings.steps),
    )
    return (
        march.estimator == estimator_of(request, first)
        and ESTIMATORS[march.estimator].names_blockers
        and march.step_count >= FEWEST_STEPS_WORTH_KEEPING
        and march.direction_count <= MOST_KEPT_DIRECTIONS
    )

"""Which ray-traced passes stand in for the screen-space ones, and why."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeVar

from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.bvh_upload import BvhUploadPass
from ssdo_gl.passes.ray_tables import EmitterTablesPass, SurfaceTablesPass
from ssdo_gl.passes.reference_ao import ReferenceAoPass, ReferenceAoSettings
from ssdo_gl.passes.reference_gi import ReferenceGiPass, ReferenceGiSettings
from ssdo_gl.passes.reference_near import ReferenceNearPass, ReferenceNearSettings
from ssdo_gl.passes.traced_shadows import TracedShadowsPass, TracedShadowsSettings
from ssdo_gl.planning.effects import Effects
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

SettingsClass = TypeVar("SettingsClass", bound="DataclassInstance")

TRACED_SETTINGS: dict[str, type[Any]] = {
    "traced_shadows": TracedShadowsSettings,
    "reference_ao": ReferenceAoSettings,
    "reference_near": ReferenceNearSettings,
    "reference_gi": ReferenceGiSettings,
}


def with_overrides(settings: Settings, name: str, base: SettingsClass) -> SettingsClass:
    """Return `base` with the user's PASS.FIELD values for the pass called `name`."""
    prefix = f"{name}."
    changes = {
        key.removeprefix(prefix): value
        for key, value in settings.overrides.items()
        if key.startswith(prefix)
    }
    return dataclasses.replace(base, **changes)


def traced_passes(
    scene: Scene, settings: Settings, effects: Effects, *, paths: bool
) -> Iterator[tuple[RenderPass, str]]:
    """Yield the passes that trace rays, each with its reason.

    Parameters
    ----------
    scene : Scene
    settings : Settings
        With its radius filled in.
    effects : Effects
    paths : bool
        The picture itself is path traced.

    Notes
    -----
    Every reference starts from the same G-buffer as the methods it judges.
    """
    features = RayFeatures.of(scene)
    environment = scene.environment
    spp, max_error = settings.spp, settings.max_error
    radius = settings.radius
    assert radius is not None, "the renderer fills the radius in"
    yield BvhUploadPass(), "the triangles, in a tree that rays descend"
    yield SurfaceTablesPass(), "the materials of what rays hit"
    yield EmitterTablesPass(), "the lights that rays are sent to"
    if effects.traced_shadows:
        shadows = TracedShadowsSettings(settings.shadow_rays, max_error)
        shadows = with_overrides(settings, "traced_shadows", shadows)
        yield TracedShadowsPass(shadows, features), "light of the scene's lights, by shadow rays"
    if not settings.is_reference:
        return
    if effects.visibility:
        ao = with_overrides(settings, "reference_ao", ReferenceAoSettings(radius, spp, max_error))
        yield ReferenceAoPass(ao, features), "how open each point is, by rays"
    if effects.directional or effects.bounce:
        near = ReferenceNearSettings(radius, spp, max_error)
        near = with_overrides(settings, "reference_near", near)
        yield ReferenceNearPass(near, features, environment), "the near field, by rays"
    if paths:
        gi = ReferenceGiSettings(spp, settings.bounces, max_error=max_error)
        gi = with_overrides(settings, "reference_gi", gi)
        yield ReferenceGiPass(gi, features, environment), "all light transport, by paths"

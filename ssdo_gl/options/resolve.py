"""Brings together what a user gave, what a scene asks for, and defaults."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from ssdo_gl.math3d import Vector, vector
from ssdo_gl.options.pass_settings import overrides_from_table
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.camera import PROJECTIONS, Camera
from ssdo_gl.scene.defaults import parallel
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.fields import SettingError, describe, info_of, shown
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.settings.settings import LONGEST, MAX_EXPOSURE_EV, MAX_SPP, SHORTEST, Settings


def for_pictures(settings: Settings, scene: Scene) -> Settings:
    """Return `settings` with as many anti-aliasing frames as pictures have by default."""
    if settings.gives("antialias"):
        return settings
    # What is translucent is drawn by chance: more frames, less noise.
    by_chance = any(material.is_translucent for material in scene.materials)
    return dataclasses.replace(settings, antialias=16 if by_chance else 4)


def camera_from_text(text: str) -> tuple[Vector, Vector, float | None]:
    """Return position, target and, if given, the third of ``"px,py,pz tx,ty,tz [fov]"``."""
    limit = info_of(Settings, "radius").high
    assert limit is not None
    parts = text.split()
    try:
        numbers = [tuple(float(n) for n in part.split(",")) for part in parts]
    except ValueError:
        numbers = []
    lengths = [len(group) for group in numbers]
    # As far as scenes go; false for NaN, too.
    usable = all(abs(n) <= limit for group in numbers for n in group)
    if lengths not in ([3, 3], [3, 3, 1]) or not usable:
        raise SettingError(
            f"--camera {shown(text)}: expected fit, the name of a camera or "
            f'"px,py,pz tx,ty,tz [fov_deg or height]", each number within {-limit:g} to {limit:g}'
        )
    third = numbers[2][0] if len(numbers) == 3 else None
    if third is not None and not third >= SHORTEST:
        raise SettingError(f"--camera {shown(text)}: the third must be at least {SHORTEST:g}")
    if numbers[0] == numbers[1]:
        raise SettingError(f"--camera {shown(text)}: position and target are the same point")
    return vector(numbers[0]), vector(numbers[1]), third


def chosen_camera(
    scene: Scene, text: str | None, projection: str | None, seconds: float = 0.0
) -> Camera | None:
    """Return the camera of ``--camera`` and ``--projection``; None if the scene's own will do.

    One that was chosen to hold all of the scene holds it as it stands at `seconds`.

    Raises
    ------
    SettingError
    """
    camera = scene.camera
    is_parallel = camera.height is not None
    if text is None and scene.is_framed and scene.moves and seconds != 0.0:
        scene = scene_at(scene.without_ground(), seconds)
        camera = scene.framed(None, camera.fov_y, camera.exposure)
        projection = projection or PROJECTIONS[is_parallel]
    if text is None and projection is None:
        return None
    if projection is not None:
        is_parallel = projection != PROJECTIONS[0]
    if text is None:
        if not is_parallel:
            return camera.perspective()
        if scene.is_framed and camera.height is None:
            return parallel(scene.surfaces(), camera, None)
        return camera.orthographic()
    position, target, third = camera_from_text(text)
    camera = dataclasses.replace(camera, position=position, target=target)
    if is_parallel:
        return camera.orthographic(third)
    if third is not None and not 0.0 < third < 180.0:
        raise SettingError(f"--camera {shown(text)}: fov must be between 0 and 180 degrees")
    return dataclasses.replace(camera, fov_y=camera.fov_y if third is None else third, height=None)


def settings_for(scene_settings: Mapping[str, Any], given: Mapping[str, Any]) -> Settings:
    """Return checked Settings: what is given wins over the scene's settings, those over defaults.

    Parameters
    ----------
    scene_settings : mapping
        ``Scene.render``; names of Settings fields.
    given : mapping
        Fields of Settings by name; None where one was not given.

    Raises
    ------
    SettingError
    """
    fields = {name: value for name, value in given.items() if value is not None}
    for name in fields:
        info_of(Settings, name)
    return with_scene_settings(Settings(**fields), scene_settings)


def with_scene_settings(settings: Settings, scene_settings: Mapping[str, Any]) -> Settings:
    """Return `settings` with what a scene asks for wherever nothing else was given.

    Once: fields of the result that are None are not filled in again.

    Raises
    ------
    SettingError
        If a value is not valid.
    """
    if settings.is_resolved:
        return settings.checked()
    for name in scene_settings:
        info_of(Settings, name)
    added = {name: value for name, value in scene_settings.items() if not settings.gives(name)}
    usual_method = scene_settings.get("method", info_of(Settings, "method").default)
    if settings.gives("method") and settings.method != usual_method:
        # A scene's estimator belongs to the method that it asks for.
        added.pop("estimator", None)
    overrides_from_table(settings.overrides)
    return dataclasses.replace(settings, **added, is_resolved=True).checked()


def told(settings: Settings, scene_settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the method, and what else makes `settings` of a scene's; overrides aside."""
    # Without the method among them, the scene's estimator would hold as well.
    usual = settings_for(scene_settings, {"method": settings.method})
    fields = {name: getattr(settings, name) for name in describe(Settings) if name != "overrides"}
    return {
        name: value
        for name, value in fields.items()
        if name == "method" or value not in (None, getattr(usual, name))
    }


def resolved(settings: Settings, scene: Scene) -> Settings:
    """Return all of what a rendering of `scene` goes by, radius and exposure included.

    Parameters
    ----------
    settings : Settings
        As they were given.

    Raises
    ------
    SettingError
    """
    settings = with_scene_settings(settings, scene.render)
    filled: dict[str, Any] = {}
    if settings.radius is None:
        is_all_light = METHODS[settings.method].is_all_light
        radius = scene.default_radius(is_all_light=is_all_light)
        filled["radius"] = min(LONGEST, max(SHORTEST, radius))
    if settings.exposure is None:
        # Of a scene in odd units it may be beyond what an image can be exposed to.
        exposure = scene.camera.exposure
        filled["exposure"] = min(MAX_EXPOSURE_EV, max(-MAX_EXPOSURE_EV, exposure))
    if settings.is_reference and settings.max_error is not None:
        # A reference goes on until the bound holds, or to the limit that was given.
        if not settings.gives("spp"):
            filled["spp"] = MAX_SPP
        if not settings.gives("shadow_rays"):
            filled["shadow_rays"] = MAX_SPP
    return dataclasses.replace(settings, **filled).checked()

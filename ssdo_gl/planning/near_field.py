"""Rules of the screen-space near field: what a view makes needless, what passes can share."""

from __future__ import annotations

import dataclasses
import math

from ssdo_gl.passes.screen_space_settings import ScreenSpaceSettings
from ssdo_gl.planning.content import SceneContent
from ssdo_gl.planning.view import Sight
from ssdo_gl.scene.environment import MapEnvironment
from ssdo_gl.scene.light import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

# Passes whose settings are `ScreenSpaceSettings`.
ESTIMATOR_PASSES = ("ssao", "directional", "bounce")
# Fields that make two estimators follow the same directions to the same ends.
DIRECTION_FIELDS = tuple(field.name for field in dataclasses.fields(ScreenSpaceSettings))
# What `ScreenSpaceSettings.thickness` may stand for where it is left open, at most.
LARGEST_DEFAULT_THICKNESS = 2.0
# A radius just under a pixel in float64 might reach one in the shader's float32.
PIXEL_MARGIN = 1.0 - 1e-5
# Blocked directions are kept as numbers of texels, x + 4096 y, exact in float32, ...
LONGEST_NUMBERED_SIDE = 4096
# ... four to a texture. More textures than four cost what a second march would.
MOST_KEPT_DIRECTIONS = 16
# Where a direction takes fewer depth reads, keeping what they found saves nothing.
FEWEST_STEPS_WORTH_KEEPING = 4


def estimator_of(settings: Settings, name: str) -> str:
    """Return the estimator of the pass `name`: ssao, directional or bounce."""
    chosen = settings.chosen_estimator
    if name == "ssao" and settings.method != "ssao" and chosen not in ("march", "rgs09"):
        chosen = "hemisphere"
    return str(settings.overrides.get(f"{name}.estimator", chosen))


def reason_to_be_open(
    content: SceneContent, settings: Settings, sight: Sight, *, looks_at_lights: bool
) -> str | None:
    """Return why nothing within R can block any visible point, or None if something may.

    Parameters
    ----------
    looks_at_lights : bool
        Directions to ``ssdo`` lights are marched along, too. These have no rule for a
        radius below a pixel.
    """
    assert settings.radius is not None, "the renderer fills the radius in"
    radius = max(settings.overrides.get(f"{p}.radius", settings.radius) for p in ESTIMATOR_PASSES)
    estimators = {estimator_of(settings, name) for name in ESTIMATOR_PASSES}
    if radius < sight.nearest_pixel * PIXEL_MARGIN and not looks_at_lights:
        return "the radius is smaller than a pixel everywhere in view"
    if sight.open_distance == math.inf and "zbuffer" not in estimators:
        return "what is in view is convex and stands alone"
    # What hides a point in space is told by depth alone for the other estimators, however
    # far in front of it that is.
    if estimators <= {"march", "hemisphere"} and _far_apart(content, settings, sight, radius):
        return "what is in view is convex and farther apart than rays of this radius reach"
    return None


def _far_apart(content: SceneContent, settings: Settings, sight: Sight, radius: float) -> bool:
    """Return whether all bodies are out of reach of each other's rays.

    A ray ends at R. The surface that its texel shows may be nearer to the camera, or
    farther, by the stretch that a step stands for, at most R, and by the assumed thickness.
    """
    if content.has_closed_meshes and not sight.only_solids:
        # The back-face layer may take a sheet and a solid behind it for one.
        return False
    given = [settings.overrides.get(f"{name}.thickness") for name in ESTIMATOR_PASSES]
    thickness = max(LARGEST_DEFAULT_THICKNESS if t is None else float(t) for t in given)
    reach = radius * (1.0 + (1.0 + thickness) * sight.slant) + 2.0 * sight.farthest_pixel
    return sight.open_distance > reach


def can_share_directions(settings: Settings, first: str) -> bool:
    """Return whether the bounce can take over what the pass `first` found blocked."""
    overrides = settings.overrides
    if any(
        overrides.get(f"{first}.{name}") != overrides.get(f"bounce.{name}")
        for name in DIRECTION_FIELDS
    ):
        return False
    march = ScreenSpaceSettings(
        estimator=estimator_of(settings, "bounce"),
        samples=overrides.get("bounce.samples", settings.samples),
        steps=overrides.get("bounce.steps", settings.steps),
    )
    return (
        march.estimator == estimator_of(settings, first) == "march"
        and march.step_count >= FEWEST_STEPS_WORTH_KEEPING
        and march.direction_count <= MOST_KEPT_DIRECTIONS
        and max(settings.size) <= LONGEST_NUMBERED_SIDE
    )


def sender_bound(scene: Scene, radius: float) -> float:
    """Return the largest radiance a diffuse sender can plausibly have in `scene`.

    A rectangle or the environment of radiance L lights a surface with at most pi L, so
    it sends at most L. Directional light E sends E / pi. A point light is unbounded near
    itself; nearer than a tenth of R, or of the R that suits the scene if that is less, it
    is part of no receiver's near field worth having. Emission that no light stands for
    counts as it is.
    """
    has_points = any(isinstance(light, (PointLight, SpotLight)) for light in scene.lights)
    nearest = 0.1 * min(radius, scene.default_radius()) if has_points else 0.0
    total = 0.0
    for light in scene.lights:
        if isinstance(light, RectangleLight):
            total += max(light.radiance)
        elif isinstance(light, DirectionalLight):
            total += max(light.irradiance) / math.pi
        elif isinstance(light, (PointLight, SpotLight)) and nearest > 0.0:
            total += max(light.intensity) / (math.pi * nearest * nearest)
    emitted = [max(m.emission) for m in scene.materials]
    return total + max(emitted, default=0.0) + _environment_maximum(scene)


def _environment_maximum(scene: Scene) -> float:
    environment = scene.environment
    if environment is None:
        return 0.0
    if isinstance(environment, MapEnvironment):
        return float(environment.image.max(initial=0.0))
    colors = dataclasses.astuple(environment)
    return float(max(max(color) for color in colors))

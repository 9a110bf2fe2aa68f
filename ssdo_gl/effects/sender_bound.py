"""An upper bound of what surfaces send, so that single bright texels make no fireflies."""

from __future__ import annotations

import dataclasses

from ssdo_gl.scene.environment import MapEnvironment
from ssdo_gl.scene.lights import Form
from ssdo_gl.scene.scene import Scene

# The largest share of light that a bounce is taken to leave.
MOST_KEPT = 0.99


def sender_bound(scene: Scene, radius: float, *, has_all_bounces: bool) -> float:
    """Return the largest radiance a diffuse sender can plausibly have in `scene`.

    A rectangle or the environment of radiance L lights a surface with at most pi L, so
    it sends at most L. Directional light E sends E / pi. A point light is unbounded near
    itself; nearer than a tenth of R, or of the R that suits the scene if that is less, it
    is part of no receiver's near field worth having. Emission that no light stands for
    counts as it is. Where it has been to and fro it is the sum of a geometric series.
    """
    has_points = any(light.form is Form.POINT for light in scene.lights)
    nearest = 0.1 * min(radius, scene.default_radius()) if has_points else 0.0
    total = sum(light.sender_radiance(nearest) for light in scene.lights)
    emitted = [max(m.emission) for m in scene.materials]
    once = total + max(emitted, default=0.0) + _environment_maximum(scene)
    kept = max((max(m.albedo) for m in scene.materials), default=0.0) if has_all_bounces else 0.0
    return once / (1.0 - min(kept, MOST_KEPT))


def _environment_maximum(scene: Scene) -> float:
    environment = scene.environment
    if environment is None:
        return 0.0
    if isinstance(environment, MapEnvironment):
        return float(environment.image.max(initial=0.0))
    colors = dataclasses.astuple(environment)
    return float(max(max(color) for color in colors))

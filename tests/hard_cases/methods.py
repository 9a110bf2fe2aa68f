"""The methods that every hard case is tried with, and how they are rendered."""

from __future__ import annotations

from ssdo_gl.renderer import Renderer
from ssdo_gl.settings import Settings, methods

SIZE = (64, 48)
# Of shadow maps for pictures so small: those of the usual size took most of these tests' time.
FEW_TEXELS = {"shadow_map.resolution": 256}
# (method, estimator); the references at few samples: a case asks whether they stay
# sane, not whether they converge.
ALL_METHODS = tuple(
    (name, estimator)
    for name, method in methods.METHODS.items()
    for estimator in method.estimators or (None,)
)
# What is near in `gi` is that of `bounce`: by one estimator, and in `test_energy.py` by all.
METHODS = tuple(m for m in ALL_METHODS if m[0] != "gi" or m[1] == "march")
SCREEN_SPACE = tuple(m for m in METHODS if not m[0].startswith("reference"))
IMAGES = ("beauty", "direct", "directional", "bounce", "visibility", "normal_ws", "depth")


def label(method):
    """Return the name of a (method, estimator) pair in tables and test ids."""
    return method[0] if method[1] is None else f"{method[0]}:{method[1]}"


def render(device, shaders, scene, method, *, images=IMAGES, maps=FEW_TEXELS, **settings):
    """Return the images of `scene` by a (method, estimator) pair, as arrays.

    Tests of what shadow maps resolve set `maps` to {}: those of the usual size.
    """
    settings["overrides"] = {**maps, **settings.get("overrides", {})}
    values = {"size": SIZE, "samples": 32, "steps": 8, "spp": 8, "shadow_rays": 4}
    values |= {"radius": scene.render.get("radius"), **settings}
    settings = Settings(method=method[0], estimator=method[1], **values)
    with Renderer(scene, settings, device=device, shaders=shaders) as renderer:
        return renderer.render(images).images

"""What is in a scene, as far as it decides which effects can matter."""

from __future__ import annotations

import weakref
from dataclasses import dataclass

import numpy as np

from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    Environment,
    EnvironmentKind,
    GradientEnvironment,
    MapEnvironment,
    kind_of,
)
from ssdo_gl.scene.lights import Shadow
from ssdo_gl.scene.scene import Scene


@dataclass(frozen=True)
class LightContent:
    """One light, as far as it decides about effects.

    Attributes
    ----------
    shadow : str
        How it arrives: map, ssdo or none.
    is_on : bool
        Any component of what it emits is above zero.
    """

    shadow: Shadow
    is_on: bool = True


@dataclass(frozen=True)
class SceneContent:
    """Facts about a scene that decide which passes are needed.

    They hold whatever moves and wherever the camera stands; what depends on those is in
    `planning.view`.

    Attributes
    ----------
    environment : str
        none, constant, gradient or map: the simplest that gives the same light, so a
        black map counts as none and one of a single colour as constant.
    environment_is_simplified : bool
        The scene's own is of another kind than that.
    has_albedo : bool
        Any surface reflects light.
    has_emission : bool
        Any surface emits, the bodies of lights included.
    has_unlit_emission : bool
        Any surface emits light that no light of the scene stands for.
    has_gloss : bool
        Any surface reflects more than diffuse light.
    has_translucency : bool
        Any surface lets some of what lies behind show through.
    has_baked_occlusion : bool
        Any surface has an image of how much of the environment it sees.
    has_closed_meshes : bool
        Any mesh bounds a solid, so that its back faces tell how thick it is.
    triangle_count : int
        Instances included.
    """

    lights: tuple[LightContent, ...]
    environment: EnvironmentKind
    environment_is_simplified: bool
    has_albedo: bool
    has_emission: bool
    has_unlit_emission: bool
    has_gloss: bool
    has_translucency: bool
    has_baked_occlusion: bool
    has_textures: bool
    has_closed_meshes: bool
    has_motion: bool
    triangle_count: int

    @property
    def has_lights(self) -> bool:
        """Whether any light is on."""
        return any(light.is_on for light in self.lights)

    @property
    def has_ssdo_lights(self) -> bool:
        """Whether any of them arrives through SSDO's open directions."""
        return any(light.is_on and light.shadow == "ssdo" for light in self.lights)

    @property
    def has_direct_lights(self) -> bool:
        """Whether any of them does not."""
        return any(light.is_on and light.shadow != "ssdo" for light in self.lights)


def analyse(scene: Scene) -> SceneContent:
    """Return what `scene` contains; looks at objects, not at vertices."""
    used = [scene.materials[i] for i in {item.material for item in scene.objects}]
    meshes = [scene.meshes[i] for i in {item.mesh for item in scene.objects}]
    unlit = [scene.materials[o.material] for o in scene.objects if o.light is None]
    emits_unlit = [material for material in unlit if material.emits or material.is_unlit]
    kind = kind_of(simplest_environment(scene.environment))
    return SceneContent(
        lights=tuple(LightContent(light.shadow, is_on=light.power > 0.0) for light in scene.lights),
        environment=kind,
        environment_is_simplified=kind != kind_of(scene.environment),
        has_albedo=any(max(material.albedo) > 0.0 for material in used),
        has_emission=any(material.emits or material.is_unlit for material in used),
        has_unlit_emission=bool(emits_unlit),
        has_gloss=any(material.is_glossy for material in used),
        has_translucency=any(material.is_translucent for material in used),
        has_baked_occlusion=any(m.occlusion_texture is not None for m in used),
        has_textures=any(material.textures for material in used),
        has_closed_meshes=any(mesh.closed for mesh in meshes),
        has_motion=scene.moves,
        triangle_count=scene.triangle_count,
    )


def simplest_environment(environment: Environment | None) -> Environment | None:
    """Return the cheapest environment that gives exactly the same light from everywhere."""
    if isinstance(environment, MapEnvironment):
        if environment not in _simplest_of_maps:
            _simplest_of_maps[environment] = _simplest_of_map(environment)
        found = _simplest_of_maps[environment]
        return environment if found is None else simplest_environment(found)
    if isinstance(environment, GradientEnvironment):
        colors = {environment.zenith, environment.horizon, environment.ground}
        if len(colors) > 1:
            return environment
        environment = ConstantEnvironment(environment.zenith)
    if environment is not None and max(environment.radiance) <= 0.0:
        return None
    return environment


# A map is looked through once. The value must not hold the key, or neither would ever go,
# so None stands for the map itself.
_simplest_of_maps: weakref.WeakKeyDictionary[MapEnvironment, ConstantEnvironment | None] = (
    weakref.WeakKeyDictionary()
)


def _simplest_of_map(environment: MapEnvironment) -> ConstantEnvironment | None:
    image = environment.image
    # The first row decides for nearly every map, so that few are read to their end.
    if image.size and (np.any(image[0] != image[0, 0]) or np.any(image != image[0, 0])):
        return None
    r, g, b = (float(value) for value in image[0, 0]) if image.size else (0.0, 0.0, 0.0)
    return ConstantEnvironment((r, g, b))

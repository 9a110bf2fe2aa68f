"""What is in a scene, as far as it decides which effects can matter."""

from __future__ import annotations

from dataclasses import dataclass

from ssdo_gl.scene.environment import (
    ConstantEnvironment,
    Environment,
    EnvironmentKind,
    GradientEnvironment,
    kind_of,
)
from ssdo_gl.scene.light_bodies import approximations, stand_ins
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
    is_soft : bool
        Its shadows have penumbrae, and rays to it find them: it does not lie within the
        body that it stands for, where they would end.
    """

    shadow: Shadow
    is_on: bool = True
    is_soft: bool = False


@dataclass(frozen=True)
class SceneContent:
    """Facts about a scene that decide which passes are needed.

    They hold whatever moves and wherever the camera stands; what depends on those is in
    `facts.view`.

    Attributes
    ----------
    environment : str
        none, which black is, too, constant, gradient or map.
    has_albedo : bool
        Any surface reflects light.
    has_emission : bool
        Any surface emits, the bodies of lights included.
    has_unlit_emission : bool
        Any surface emits light, or shows its colour unlit, that no light of the scene stands for.
    has_glow : bool
        Any of these emits light.
    has_stand_ins : bool
        Lights that cast shadows stand for a body of another shape, or one that emits an image.
    has_gloss : bool
        Any surface reflects more than diffuse light.
    has_translucency : bool
        Any surface lets some of what lies behind show through.
    has_baked_occlusion : bool
        Any surface has an image of how much of the environment it sees.
    has_closed_meshes : bool
        Any mesh bounds a solid, so that its back faces tell how thick it is.
    """

    lights: tuple[LightContent, ...]
    environment: EnvironmentKind
    has_albedo: bool
    has_emission: bool
    has_unlit_emission: bool
    has_glow: bool
    has_stand_ins: bool
    has_gloss: bool
    has_translucency: bool
    has_baked_occlusion: bool
    has_closed_meshes: bool

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
    is_soft = [light.is_soft for light in scene.lights]
    within = stand_ins(scene) if any(is_soft) else ()
    emits_unlit = [material for material in unlit if material.emits or material.is_unlit]
    return SceneContent(
        lights=tuple(
            LightContent(light.shadow, light.power > 0.0, is_soft[i] and i not in within)
            for i, light in enumerate(scene.lights)
        ),
        environment=_kind_of(scene.environment),
        has_albedo=any(max(material.albedo) > 0.0 for material in used),
        has_emission=any(material.emits or material.is_unlit for material in used),
        has_unlit_emission=bool(emits_unlit),
        has_stand_ins=any(scene.lights[i].shadow == "map" for i in approximations(scene)),
        has_glow=any(material.emits and not material.is_unlit for material in unlit),
        has_gloss=any(material.is_glossy for material in used),
        has_translucency=any(material.is_translucent for material in used),
        has_baked_occlusion=any(m.occlusion_texture is not None for m in used),
        has_closed_meshes=any(mesh.closed for mesh in meshes),
    )


def _kind_of(environment: Environment | None) -> EnvironmentKind:
    """Return what an environment is called; none where it is given by black alone."""
    if isinstance(environment, ConstantEnvironment):
        colors = [environment.radiance]
    elif isinstance(environment, GradientEnvironment):
        colors = [environment.zenith, environment.horizon, environment.ground]
    else:
        return kind_of(environment)
    return kind_of(environment) if max(map(max, colors)) > 0.0 else "none"

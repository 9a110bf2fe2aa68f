"""What is in a scene, as far as it decides which effects can matter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ssdo_gl.scene.environment import ConstantEnvironment, GradientEnvironment, MapEnvironment
from ssdo_gl.scene.light import DirectionalLight, Light, RectangleLight
from ssdo_gl.scene.scene import Scene

EnvironmentKind = Literal["none", "constant", "gradient", "map"]


@dataclass(frozen=True)
class SceneContent:
    """Facts about a scene that decide which passes are needed.

    Attributes
    ----------
    has_lights : bool
        Any light that is not black.
    has_direct_lights : bool
        Any of them delivers light directly (is not marked ``ssdo``).
    has_shadowed_lights : bool
        Any of those is marked ``shadow = "map"``.
    has_ssdo_lights : bool
    environment : str
        none, constant, gradient or map; a black environment counts as none.
    has_albedo : bool
        Any surface reflects light.
    has_unlit_emission : bool
        Any surface emits light that no light of the scene stands for.
    has_textures, has_vertex_colors, has_cutouts : bool
    has_closed_meshes : bool
        Any mesh bounds a solid, so that its back faces tell how thick it is.
    has_motion : bool
    triangle_count : int
        Instances included.
    """

    has_lights: bool
    has_direct_lights: bool
    has_shadowed_lights: bool
    has_ssdo_lights: bool
    environment: EnvironmentKind
    has_albedo: bool
    has_unlit_emission: bool
    has_textures: bool
    has_vertex_colors: bool
    has_cutouts: bool
    has_closed_meshes: bool
    has_motion: bool
    triangle_count: int

    @property
    def has_distant_light(self) -> bool:
        """Whether light arrives through SSDO's open directions."""
        return self.environment != "none" or self.has_ssdo_lights


def analyse(scene: Scene) -> SceneContent:
    """Return what `scene` contains; looks at objects, not at triangles."""
    lit = [light for light in scene.lights if _power(light) > 0.0]
    direct = [light for light in lit if light.shadow != "ssdo"]
    used = [scene.materials[item.material] for item in scene.objects]
    meshes = [scene.meshes[item.mesh] for item in scene.objects]
    unlit = [scene.materials[o.material].emits for o in scene.objects if o.light is None]
    moving = [*scene.objects, *scene.lights]
    return SceneContent(
        has_lights=bool(lit),
        has_direct_lights=bool(direct),
        has_shadowed_lights=any(light.shadow == "map" for light in direct),
        has_ssdo_lights=any(light.shadow == "ssdo" for light in lit),
        environment=_environment_kind(scene),
        has_albedo=any(max(material.albedo) > 0.0 for material in used),
        has_unlit_emission=any(unlit),
        has_textures=any(m.albedo_texture or m.emission_texture for m in used),
        has_vertex_colors=any(mesh.colors is not None for mesh in meshes),
        has_cutouts=any(material.alpha_cutoff is not None for material in used),
        has_closed_meshes=any(mesh.closed for mesh in meshes),
        has_motion=any(item.motion is not None for item in moving),
        triangle_count=scene.triangle_count,
    )


def _power(light: Light) -> float:
    """Return the largest component of what the light emits, in the unit of its kind."""
    if isinstance(light, RectangleLight):
        return max(light.radiance)
    if isinstance(light, DirectionalLight):
        return max(light.irradiance)
    return max(light.intensity)


def _environment_kind(scene: Scene) -> EnvironmentKind:
    environment = scene.environment
    if isinstance(environment, ConstantEnvironment):
        return "constant" if max(environment.radiance) > 0.0 else "none"
    if isinstance(environment, GradientEnvironment):
        colors = (environment.zenith, environment.horizon, environment.ground)
        return "gradient" if max(map(max, colors)) > 0.0 else "none"
    if isinstance(environment, MapEnvironment):
        return "map" if float(environment.image.max(initial=0.0)) > 0.0 else "none"
    return "none"

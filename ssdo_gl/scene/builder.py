"""Collects the parts of a scene while a file is read, and assembles the Scene."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene import defaults
from ssdo_gl.scene import emissive_meshes as emitters
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults import ground, has_floor, is_room, lighting_for, seen_metal
from ssdo_gl.scene.environment import Daylight, Environment, MapEnvironment, sky
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces, are_mirrored, batched, main_part
from ssdo_gl.scene.lights import DirectionalLight, Light, Shadow
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.scene.scene_data import SceneData, SceneKind
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.settings.loading import USUAL, LoadOptions
from ssdo_gl.settings.settings import LONGEST, SHORTEST
from ssdo_gl.wording import counted

# Each light is drawn into a shadow map of its own: some milliseconds a light.
MAX_LIGHTS = 1024
# Each is looked at to find the lights that stand for them.
MAX_EMISSIVE_TRIANGLES = 1 << 20


@dataclass
class SceneBuilder:
    """The growing parts of one scene.

    Attributes
    ----------
    source : str
        The file, as errors name it.
    options : LoadOptions
        What is added to what the file holds.
    models : dict
        Objects of model files that were read before, so that none is read twice.
    joins : bool
        Whether objects that can be drawn as one become one.
    """

    source: str
    options: LoadOptions = USUAL
    meshes: list[Mesh] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    objects: list[SceneObject] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    models: dict[Hashable, list[SceneObject]] = field(default_factory=dict)
    joins: bool = True
    _mesh_of_key: dict[Hashable, int] = field(default_factory=dict)
    _emitter_shadow: dict[int, Shadow] = field(default_factory=dict)

    def mesh(self, key: Hashable, make: Callable[[], Mesh]) -> int:
        """Return the index of the mesh known as `key`, made on first use."""
        if key not in self._mesh_of_key:
            self._mesh_of_key[key] = len(self.meshes)
            self.meshes.append(make())
        return self._mesh_of_key[key]

    def material(self, material: Material) -> int:
        """Add a material and return its index."""
        self.materials.append(material)
        return len(self.materials) - 1

    def add(self, item: SceneObject, emitter_shadow: Shadow = "map") -> None:
        """Add an object; mirrored instances are rewritten to keep orientation.

        A matrix with negative determinant would turn the winding around and with it
        the front of the surface; such instances use a mirrored mesh instead.

        Parameters
        ----------
        emitter_shadow : str
            How the lights that stand for its emission are shadowed.
        """
        mirrored = are_mirrored(item.world_from_object)
        for flip in (False, True):
            matrices = item.world_from_object[mirrored == flip]
            if not len(matrices):
                continue
            mesh = item.mesh
            if flip:
                mesh = self.mesh(
                    ("mirrored", mesh), lambda: self.meshes[item.mesh].changed(_mirrored)
                )
                matrices = matrices @ np.diag([-1.0, 1.0, 1.0, 1.0])
            self._emitter_shadow[len(self.objects)] = emitter_shadow
            self.objects.append(dataclasses.replace(item, mesh=mesh, world_from_object=matrices))

    def add_light(self, light: Light) -> None:
        """Add a light, and the body that shows it if it has one."""
        self.lights.append(light)
        body = light.body()
        if body is not None:
            mesh, material = self.mesh(body.key, body.make), self.material(body.material)
            self.add(body.placed(light, len(self.lights) - 1, mesh, material))

    def note(self, text: str) -> None:
        """Tell the user something, once."""
        if text not in self.notes:
            self.notes.append(text)

    def build(
        self,
        kind: type[SceneKind],
        camera: Camera | None,
        environment: Environment | None,
        *,
        exposure: float | None = 0.0,
        fov_y: float = 40.0,
        height: float | None = None,
        camera_motion: Trajectory | None = None,
        render: Mapping[str, Any] | None = None,
        title: str = "",
        purpose: str = "",
    ) -> SceneKind:
        """Assemble the scene; what is missing of camera and light is added.

        Parameters
        ----------
        camera : Camera or None
            None: the whole scene is framed, with `fov_y` or by parallel rays, if there is a
            `height`; 0: as high as needed.
        exposure : float or None
            In EV, of the camera that frames the scene. None: to be measured from the
            picture; until then the camera's is an estimate.
        environment : Environment or None
            None together with no light of any kind: a soft sky and a key light.

        `options` may ask for other light, for none that the file lacks, or for the frame.
        """
        if not self.objects:
            raise SceneError(f"{self.source}: nothing to draw: no object with a triangle")
        self._check_size()
        self._check_counts()
        if self.options.replaces_light:
            self._drop_lamps()
        has_lamps, read_note_count = bool(self.lights), len(self.notes)
        self._add_emitters()
        self._join()
        is_framed = camera is None or self.options.frames_all
        if camera is None or self.options.frames_all:
            camera_motion = None
            camera = self._framed(camera, fov_y, height, exposure or 0.0)
        light_count, given_environment = len(self.lights), environment
        camera, environment, slack = self._light(camera, environment, exposure, has_lamps)
        is_studio = isinstance(environment, MapEnvironment) and environment.name == defaults.STUDIO
        has_ground = is_framed and bool(slack) and self._lay_ground(camera, environment)
        asked = {} if self._is_traced() else {"method": defaults.RAYLESS_METHOD}
        return kind(
            meshes=tuple(self.meshes),
            materials=tuple(self.materials),
            objects=tuple(self.objects),
            camera=camera,
            camera_motion=camera_motion,
            lights=tuple(self.lights),
            environment=environment,
            render={**asked, **(render or {})},
            title=title,
            purpose=purpose,
            notes=tuple(self.notes),
            read_note_count=read_note_count,
            loading=self.options,
            reach=self._reach(camera) if exposure is None else SceneData.reach,
            backdrop=defaults.BACKDROP if is_studio or has_ground else None,
            metering_slack=slack,
            is_framed=is_framed,
            added_light_count=len(self.lights) - light_count,
            has_added_sky=environment is not given_environment,
        )

    @property
    def surfaces(self) -> Surfaces:
        """What was added until now."""
        return Surfaces(self.meshes, self.objects, self.materials)

    def _is_traced(self) -> bool:
        """Return whether a hierarchy for rays is soon made, in each frame if bodies move."""
        shown = [(self.meshes[item.mesh], item) for item in self.objects]
        count = sum(len(mesh.triangles) * len(item.world_from_object) for mesh, item in shown)
        moves = any(mesh.pose or item.motion for mesh, item in shown)
        most = defaults.MOST_TRACED_MOVING if moves else defaults.MOST_TRACED
        if count > most:
            self.note(
                f"{count} triangles{' that move' if moves else ''}: the usual method is "
                f"{defaults.RAYLESS_METHOD}, which needs no rays; gi takes longer to prepare"
            )
        return count <= most

    def _light(
        self,
        camera: Camera,
        environment: Environment | None,
        exposure: float | None,
        has_lamps: bool,
    ) -> tuple[Camera, Environment | None, float | None]:
        """Complete the lights; return camera, environment and `Scene.metering_slack`."""
        lights = len(self.lights)
        if self.options.replaces_light:
            environment = self._chosen_light(camera)
        elif exposure is None and environment is None and self.lights:
            camera, environment = self._lit(camera, has_lamps=has_lamps)
        elif environment is None and not self.lights and self.options.adds_light:
            environment = self._default_light(camera, "no light in the file")
        # A lamp in a room is of no known strength where it is seen.
        has_key = any(isinstance(light, DirectionalLight) for light in self.lights[lights:])
        slack = defaults.METERING_SLACK if self.options.replaces_light or has_key else 0.0
        return camera, environment, slack if exposure is None else None

    def _reach(self, camera: Camera) -> float:
        """Return the default radius of a model, relative to its diagonal."""
        inside = is_room(self.surfaces, camera)
        return defaults.ROOM_REACH if inside else defaults.MODEL_REACH

    def _lay_ground(self, camera: Camera, environment: Environment | None) -> bool:
        """Lay a floor under a lone model in the light of a sky and a key light."""
        keys = [light for light in self.lights if isinstance(light, DirectionalLight)]
        shows_ground = isinstance(environment, MapEnvironment) and environment.sun is not None
        if not self.options.lays_ground or environment is None or len(keys) != 1 or shows_ground:
            return False
        if has_floor(self.surfaces) or is_room(self.surfaces, camera):
            return False
        part = main_part(self.surfaces)
        if camera.position[1] < part.low[1]:
            return False  # it would show nothing, and shade what is seen
        mesh, material = ground((part.low, part.high), environment, keys[0])
        self.meshes.append(mesh)
        self.objects.append(
            SceneObject(
                len(self.meshes) - 1, self.material(material), name="ground", is_ground=True
            )
        )
        return True

    def _framed(
        self, given: Camera | None, fov_y: float, height: float | None, exposure: float
    ) -> Camera:
        """Return a camera that holds all; of the kind of the one that is given, if any."""
        if given is not None:
            fov_y, exposure = given.fov_y, given.exposure
            height = None if given.height is None else 0.0
        camera = defaults.frame(self.surfaces, fov_y, exposure)
        if note := main_part(self.surfaces).note:
            self.note(note)
        if height is not None:
            camera = defaults.parallel(self.surfaces, camera, height or None)
        return camera

    def _lit(self, camera: Camera, *, has_lamps: bool) -> tuple[Camera, Environment | None]:
        """Return the camera exposed for the lights of the file, and a sky if they do not do."""
        lighting = lighting_for(
            self.surfaces, self.lights, camera.perspective(), has_lamps=has_lamps
        )
        environment: Environment | None = None
        if self.options.adds_light:
            if lighting.fill == "sky and key":
                why = "the light of the file leaves most of the picture dark"
                environment = self._default_light(camera, why)
            elif lighting.fill == "sky":
                environment = defaults.SKY.scaled(2.0**-lighting.exposure)
                self.note("the light of the file leaves most of the picture dark: added a soft sky")
            elif lighting.fill == "dim sky":
                environment = defaults.NEUTRAL_SKY.scaled(lighting.level)
                self.note("no sky in the file: added a dim one, for the shadows of its lamps")
        return dataclasses.replace(camera, exposure=lighting.exposure), environment

    def _default_light(self, camera: Camera, why: str) -> Environment:
        """Add a key light and return the sky that goes with it: of a studio for metal."""
        room = defaults.room_around(self.surfaces, camera)
        if room is not None:
            self.lights.append(room.lamp(camera))
            self.note(f"{why}: added a soft sky and one light below the ceiling")
            return defaults.SKY
        is_metal = seen_metal(self.surfaces, camera.perspective())
        environment, key = (defaults.studio if is_metal else defaults.soft_light)(camera)
        self.lights.append(key)
        added = "a studio, which metal reflects," if is_metal else "a soft sky"
        self.note(f"{why}: added {added} and one key light")
        return environment

    def _chosen_light(self, camera: Camera) -> Environment:
        """Return the environment that was asked for; studio and sky have a light besides."""
        if self.options.sky_hour is not None:
            daylight = Daylight(self.options.sky_hour)
            if not daylight.is_day:
                raise SettingError(
                    f"light = {self.options.light!r}: the sun is below the horizon then"
                )
            self.lights.append(daylight.sun())
            return sky(daylight)
        path = self.options.map_path
        if path is None:
            environment, key = defaults.studio(camera)
            self.lights.append(key)
            return environment
        of_map, suns, notes = defaults.image_light(path)
        self.lights += suns
        for text in notes:
            self.note(text)
        return of_map

    def _drop_lamps(self) -> None:
        """Leave out the lights of the file, and the bodies that show them."""
        if self.lights:
            left_out = counted(len(self.lights), "light")
            self.note(f"{left_out} of the file left out: others take their place")
        self.lights.clear()
        kept = [index for index, item in enumerate(self.objects) if item.light is None]
        shadows = self._emitter_shadow
        self._emitter_shadow = {new: shadows[old] for new, old in enumerate(kept) if old in shadows}
        self.objects = [self.objects[index] for index in kept]

    def _check_size(self) -> None:
        corners = self.surfaces.boxes().reshape(-1, 3)
        low, high = corners.min(axis=0), corners.max(axis=0)
        extent, reach = float((high - low).max()), float(np.abs([low, high]).max())
        if not (np.isfinite(reach) and reach <= LONGEST and extent >= SHORTEST):
            raise SceneError(
                f"{self.source}: the scene measures {extent:g} and reaches to {reach:g} scene "
                f"units: expected a size from {SHORTEST:g} to {LONGEST:g}"
            )

    def _check_counts(self) -> None:
        if len(self.lights) > MAX_LIGHTS:
            raise SceneError(f"{self.source}: {len(self.lights)} lights: at most {MAX_LIGHTS}")
        for item in self.objects:
            if item.light is None and self.materials[item.material].emits:
                count = len(self.meshes[item.mesh].triangles) * len(item.world_from_object)
                if count > MAX_EMISSIVE_TRIANGLES:
                    raise SceneError(
                        f"{self.source}: emissive {item.name!r} has {count} triangles, copies "
                        f"included: at most {MAX_EMISSIVE_TRIANGLES}"
                    )

    def _add_emitters(self) -> None:
        found = emitters.emitter_lights(self.surfaces, self._emitter_shadow, len(self.lights))
        self.objects = list(found.objects)
        self.lights += found.lights
        for text in found.notes:
            self.note(text)

    def _join(self) -> None:
        """Join what may be; then blended materials know whether vertices make them translucent."""
        if self.joins:
            self._merge()
            self.meshes, self.materials, self.objects = batched(
                self.meshes, self.materials, self.objects
            )
        for item in self.objects:
            colors, material = self.meshes[item.mesh].colors, self.materials[item.material]
            if material.blends and colors is not None and colors[:, 3].min() < 1.0:
                self.materials[item.material] = dataclasses.replace(
                    material, has_clear_vertices=True
                )

    def _merge(self) -> None:
        """Join still objects of one mesh and material into instances of one object.

        In order of first appearance, so that the same file gives the same scene.
        """
        merged: list[SceneObject] = []
        place: dict[tuple[int, int], int] = {}
        matrices: dict[int, list[FloatArray]] = {}
        for item in self.objects:
            key = (item.mesh, item.material)
            is_still = item.motion is None and item.light is None
            if is_still and key in place:
                matrices[place[key]].append(item.world_from_object)
                continue
            if is_still:
                place[key] = len(merged)
                matrices[len(merged)] = [item.world_from_object]
            merged.append(item)
        for row, parts in matrices.items():
            if len(parts) > 1:
                joined = np.concatenate(parts)
                merged[row] = dataclasses.replace(merged[row], world_from_object=joined)
        self.objects = merged


def _mirrored(mesh: Mesh) -> Mesh:
    """Return the mesh mirrored in x, wound so that its front stays its front."""
    mirror: FloatArray = np.array([-1.0, 1.0, 1.0])
    return dataclasses.replace(
        mesh,
        positions=mesh.positions * mirror,
        normals=None if mesh.normals is None else mesh.normals * mirror,
        tangents=None if mesh.tangents is None else mesh.tangents * [-1.0, 1.0, 1.0, -1.0],
        triangles=mesh.triangles[:, ::-1],
    )

"""Everything that is drawn, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment_kinds import Environment
from ssdo_gl.scene.lights import Light
from ssdo_gl.scene.material import Color, Material
from ssdo_gl.scene.mesh import Mesh, SceneObject, instance_boxes
from ssdo_gl.scene.motion import Trajectory
from ssdo_gl.settings.loading import USUAL, LoadOptions
from ssdo_gl.short_repr import counted, described


class SceneError(ValueError):
    """A scene that cannot be used: one line naming the file, the key and the cure."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A scene at rest. World space is right-handed; lengths are scene units.

    Attributes
    ----------
    render : mapping
        The settings that the scene asks for (``radius``, ``method``, ...); flags win over them.
    notes : tuple of str
        What the loader has to tell the user: added lights, dropped features.
    camera_motion : Trajectory or None
        Of the scene's own camera.
    loading : LoadOptions
        How it was loaded.
    reach : float
        The near-field radius R that is used when neither scene nor flag gives one, relative to
        the diagonal of the bounds.
    backdrop : Color or None
        Radiance that is seen where no surface is, in place of the environment, which lights.
    metering_slack : float or None
        EV by which exposure 0 may miss what the picture asks for, if exposure is to be
        measured from it; None: the camera's holds.
    is_metered : bool
        Whether the camera's exposure is that measurement.
    is_framed : bool
        Whether the file has no camera, so that `camera` was chosen to hold all of it.
    """

    meshes: tuple[Mesh, ...]
    materials: tuple[Material, ...]
    objects: tuple[SceneObject, ...]
    camera: Camera
    lights: tuple[Light, ...] = ()
    environment: Environment | None = None
    render: Mapping[str, Any] = field(default_factory=dict)
    title: str = ""
    purpose: str = ""
    notes: tuple[str, ...] = ()
    camera_motion: Trajectory | None = None
    loading: LoadOptions = USUAL
    reach: float = 0.08
    backdrop: Color | None = None
    metering_slack: float | None = None
    is_metered: bool = False
    is_framed: bool = False

    def __repr__(self) -> str:
        return described(
            self,
            repr(self.title) if self.title else "",
            counted(len(self.objects), "object"),
            counted(self.triangle_count, "triangle"),
            counted(len(self.lights), "light"),
            "" if self.environment is None else type(self.environment).__name__,
        )

    @property
    def has_ground(self) -> bool:
        """Whether a ground was laid under it."""
        return any(item.is_ground for item in self.objects)

    def two_sided(self) -> Scene:
        """Return the scene with both sides of all surfaces drawn."""
        materials = tuple(replace(material, single_sided=False) for material in self.materials)
        return replace(self, materials=materials)

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return world-space corners (min, max) of all instances but a ground, each (3,)."""
        objects = [item for item in self.objects if not item.is_ground]
        corners = instance_boxes(self.meshes, objects).reshape(-1, 3)
        if not len(corners):
            raise SceneError("the scene has no geometry: give it at least one [[object]]")
        return corners.min(axis=0), corners.max(axis=0)

    def default_radius(self) -> float:
        """Return the near-field radius R used when neither scene nor flag gives one.

        Of scene files 0.08 of the diagonal of the bounds: 0.28 in a room of edge 2, near the
        0.3 of the room that the method's first report was measured on. RGS09 section 3
        leaves r_max to the user and suggests the distance between local height maxima.
        """
        low, high = self.bounds()
        return float(self.reach * np.linalg.norm(high - low))

    @property
    def moves(self) -> bool:
        """Whether anything in it ever changes."""
        carriers: list[SceneObject | Light] = [*self.objects, *self.lights]
        return (
            self.camera_motion is not None
            or any(item.motion is not None for item in carriers)
            or any(self.meshes[item.mesh].pose is not None for item in self.objects)
        )

    @property
    def triangle_count(self) -> int:
        """Number of triangles drawn, instances included, a ground not."""
        return sum(
            len(self.meshes[item.mesh].triangles) * len(item.world_from_object)
            for item in self.objects
            if not item.is_ground
        )

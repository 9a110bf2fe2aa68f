"""Fills the surface cache of a scene, without any picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from passes.pass_harness import make_frame

from ssdo_gl.effects.tables.environment import EnvironmentPass
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.graph.execute import Executor
from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.graph.render_pass import RenderPass
from ssdo_gl.passes.rays import GlowTreePass
from ssdo_gl.passes.rays.bvh_upload import BvhUploadPass
from ssdo_gl.passes.rays.ray_tables import EmitterTablesPass, MaterialTablePass, SurfaceTablesPass
from ssdo_gl.passes.surfels.surfel_bounces import SurfaceCachePass
from ssdo_gl.passes.surfels.surfel_light import SurfelDirectPass, SurfelSkyPass
from ssdo_gl.passes.surfels.surfel_rays import SurfelRaysPass, SurfelsPass
from ssdo_gl.passes.surfels.surfel_textures import SURFELS_PER_ROW, SurfaceCacheSettings
from ssdo_gl.raytracing.surface_tables import RayFeatures
from ssdo_gl.raytracing.triangles import normalised_frame
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Filled:
    """A filled cache of S surfels, float64.

    Attributes
    ----------
    points : ndarray, shape (S, 16, 3)
        From which their rays start, scene units.
    irradiance, direct : ndarray, shape (S, 3)
        All light that each receives, and what comes straight from its sources.
    """

    points: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    direct: NDArray[np.float64]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Middles of the surfels, (S, 3)."""
        return np.asarray(self.points.mean(axis=1))


def cache_passes(
    scene: Scene, settings: SurfaceCacheSettings, *, by_tree: bool = False
) -> list[RenderPass]:
    """Return the passes of the cache and of the tables that it reads."""
    features, sky = (
        replace(RayFeatures.of(scene), glow_is_direct=by_tree),
        kind_of(scene.environment),
    )
    tables = [BvhUploadPass(), SurfaceTablesPass(), MaterialTablePass(), EmitterTablesPass()]
    tables += [GlowTreePass(stand_ins=True)] if by_tree else []
    cache = [
        SurfelsPass(settings, features),
        SurfelRaysPass(settings, features),
        SurfelSkyPass(settings, features, sky),
        SurfelDirectPass(settings, features, sky),
        SurfaceCachePass(settings, features),
    ]
    return [*tables, *cache, *([EnvironmentPass()] if sky == "map" else [])]


def fill(
    device: Device,
    shaders: ShaderLibrary,
    scene: Scene,
    settings: SurfaceCacheSettings | None = None,
    *,
    by_tree: bool = False,
) -> Filled:
    """Return the filled cache of `scene`; `by_tree`: light of what glows by the tree of `gi`."""
    device.activate()
    settings = settings or SurfaceCacheSettings()
    names = ("surfel_points", "surface_cache", "surfel_direct")
    plan = compile_graph(cache_passes(scene, settings, by_tree=by_tree), names)
    geometry, executor = Geometry(device.gl, scene), Executor(device, shaders)
    try:
        executor.run(plan, make_frame(scene, (16, 16), geometry=geometry), geometry)
        points, irradiance, direct = (
            np.frombuffer(executor.texture(name).read(), np.float32).reshape(
                -1, executor.texture("surface_cache").height * SURFELS_PER_ROW, 4
            )
            for name in names
        )
    finally:
        executor.release()
        geometry.release()
    # The last row of surfels is filled up with ones that lie nowhere and look nowhere.
    used = points[0].any(axis=-1)
    at = points[:, used, :3].swapaxes(0, 1).astype(np.float64)
    centre, unit = normalised_frame(scene)
    return Filled(
        at * unit + centre,
        irradiance[0, used, :3].astype(np.float64),
        direct[0, used, :3].astype(np.float64),
    )

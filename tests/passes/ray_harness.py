"""Runs ray-tracing passes with all the tables that they read."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from passes.pass_harness import make_frame

from ssdo_gl.effects.tables.environment import EnvironmentPass
from ssdo_gl.effects.tables.gloss_tables import ReflectanceTablePass
from ssdo_gl.gpu.context import Device
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.graph.execute import Executor
from ssdo_gl.graph.frame import Frame
from ssdo_gl.graph.graph import compile_graph
from ssdo_gl.graph.render_pass import ProgressCallback, RenderPass
from ssdo_gl.passes.gbuffer import GBufferPass
from ssdo_gl.passes.rays.bvh_upload import BvhUploadPass
from ssdo_gl.passes.rays.ray_tables import EmitterTablesPass, MaterialTablePass, SurfaceTablesPass
from ssdo_gl.scene.environment import kind_of
from ssdo_gl.scene.scene import Scene

Images = dict[str, NDArray[np.float32]]


class Tracer:
    """One scene and view on a device; tables are made once for all passes and seeds.

    Use as a context manager.
    """

    def __init__(
        self, device: Device, shaders: ShaderLibrary, scene: Scene, size: tuple[int, int]
    ) -> None:
        # An earlier test may have drawn with a context of its own.
        device.activate()
        self.scene = scene
        self.size = size
        self.geometry = Geometry(device.gl, scene)
        self.executor = Executor(device, shaders)
        self.frame = make_frame(scene, size, geometry=self.geometry)

    def __enter__(self) -> Tracer:
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.release()
        self.geometry.release()

    def run(
        self,
        item: RenderPass,
        outputs: Sequence[str] = (),
        *,
        seed: int = 0,
        progress: ProgressCallback | None = None,
        before: Sequence[RenderPass] = (),
    ) -> Images:
        """Run `item` and return what it writes and `outputs`, top row first.

        Passes of `before` make what it reads beyond the tables of rays.
        """
        names = (*item.writes, *outputs)
        tables = [GBufferPass(), BvhUploadPass(), SurfaceTablesPass(), MaterialTablePass()]
        tables += [EmitterTablesPass(), ReflectanceTablePass()]
        if kind_of(self.scene.environment) == "map":
            tables.append(EnvironmentPass())
        plan = compile_graph([*tables, *before, item], names)
        versions = {"seed": seed, "view": self.frame.view.key()}
        frame = Frame(self.frame.view, self.scene, seed, versions)
        self.executor.run(plan, frame, self.geometry, progress=progress)
        return {name: read_texture(self.executor.texture(name)) for name in names}

    def runs(
        self, item: RenderPass, count: int, before: Sequence[RenderPass] = ()
    ) -> dict[str, NDArray[np.float64]]:
        """Return what `item` writes with `count` independent seeds, stacked, float64."""
        images = [self.run(item, seed=seed, before=before) for seed in range(count)]
        return {
            name: np.stack([image[name].astype(np.float64) for image in images])
            for name in item.writes
        }

    def positions_ws(self) -> NDArray[np.float64]:
        """Return where the camera's rays through pixel centres meet the plane y = 0."""
        view = self.frame.view
        width, height = self.size
        x = (2.0 * (np.arange(width) + 0.5) / width - 1.0) * view.tan_half_fov[0]
        y = (1.0 - 2.0 * (np.arange(height) + 0.5) / height) * view.tan_half_fov[1]
        rays_vs = np.stack(np.broadcast_arrays(x[None, :], y[:, None], -1.0), axis=-1)
        rays = rays_vs @ view.view_from_world
        return np.asarray(view.position_ws - rays * (view.position_ws[1] / rays[..., 1:2]))

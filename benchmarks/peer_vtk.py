"""VTK's SSAO, which pyvista and ParaView switch on as theirs."""

from __future__ import annotations

import importlib
import re
import time
from collections.abc import Mapping, Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peer_room import INTENSITY, LAMP, SKY, NoPeerError, PeerTimes, Room

# Points of the half-ball; 0 draws without occlusion.
VARIANTS = {"VTK, no occlusion": 0, "VTK SSAO-16 + blur": 16, "VTK SSAO-64 + blur": 64}
# Without a display: EGL, else OSMesa.
WINDOWS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
# Bias over radius, as VTK's own defaults have it.
BIAS = 0.02


def load_vtk() -> ModuleType:
    """Return vtk; raises NoPeerError where it is not installed."""
    try:
        return importlib.import_module("vtk")
    except ImportError as error:
        raise NoPeerError(f"{error}: pip install --no-deps vtk") from None


class Vtk:
    """The room in an off-screen window of VTK."""

    def __init__(self, room: Room) -> None:
        self._vtk = vtk = load_vtk()
        self._room = room
        self.variants: Mapping[str, str] = {
            name: "occlusion" if count else "" for name, count in VARIANTS.items()
        }
        self.notes: Sequence[str] = (f"VTK {vtk.vtkVersion.GetVTKVersion()}",)
        self._window, self.device = self._open_window()
        self._renderer = vtk.vtkRenderer()
        self._window.AddRenderer(self._renderer)
        self._actor = self._room_actor()
        self._renderer.AddActor(self._actor)
        self._renderer.SetAutomaticLightCreation(False)
        lamp = vtk.vtkLight()
        lamp.SetPositional(True)
        lamp.SetConeAngle(180.0)
        lamp.SetPosition(*LAMP)
        lamp.SetIntensity(INTENSITY)
        lamp.SetAttenuationValues(0.0, 0.0, 1.0)
        self._renderer.AddLight(lamp)
        self._aim()
        self._passes = {name: self._pass(count) for name, count in VARIANTS.items()}

    def _open_window(self) -> tuple[Any, str]:
        """Return a window, and what OpenGL calls what draws in it."""
        for name in WINDOWS:
            if hasattr(self._vtk, name):
                window = getattr(self._vtk, name)()
                window.SetOffScreenRendering(1)
                window.SetMultiSamples(0)
                window.SetSize(*self._room.size)
                # Not `SupportsOpenGL`, which ends EGL for everybody in this process.
                window.Render()
                found = re.search("OpenGL renderer string: *(.*)", window.ReportCapabilities())
                if found is not None:
                    return window, found[1]
        raise NoPeerError("VTK finds no OpenGL without a display")

    def _room_actor(self) -> Any:
        vtk, count = self._vtk, len(self._room.positions)
        support = importlib.import_module("vtkmodules.util.numpy_support")
        points, cells, data = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkPolyData()
        points.SetData(support.numpy_to_vtk(self._room.positions.reshape(-1, 3), deep=1))
        numbers = np.arange(3 * count).reshape(count, 3)
        corners = np.hstack([np.full((count, 1), 3), numbers]).ravel()
        cells.SetCells(count, support.numpy_to_vtkIdTypeArray(corners, deep=1))
        data.SetPoints(points)
        data.SetPolys(cells)
        colors = np.round(255.0 * self._room.albedo).astype(np.uint8)
        data.GetCellData().SetScalars(support.numpy_to_vtk(colors, deep=1))
        mapper, actor = vtk.vtkPolyDataMapper(), vtk.vtkActor()
        mapper.SetInputData(data)
        actor.SetMapper(mapper)
        actor.GetProperty().SetInterpolationToFlat()
        actor.GetProperty().SetAmbient(SKY)
        return actor

    def _aim(self) -> None:
        ours, camera = self._room.scene.camera, self._renderer.GetActiveCamera()
        camera.SetPosition(*ours.position)
        camera.SetFocalPoint(*ours.target)
        camera.SetViewUp(*ours.up)
        camera.SetViewAngle(ours.fov_y)
        camera.SetClippingRange(self._room.near, self._room.far)

    def _pass(self, count: int) -> Any:
        steps = self._vtk.vtkRenderStepsPass()
        if count == 0:
            return steps
        occlusion = self._vtk.vtkSSAOPass()
        occlusion.SetRadius(self._room.radius)
        occlusion.SetBias(BIAS * self._room.radius)
        occlusion.SetKernelSize(count)
        occlusion.SetBlur(True)
        occlusion.SetDelegatePass(steps)
        return occlusion

    def _draw(self, variant: str) -> None:
        self._renderer.SetPass(self._passes[variant])
        self._window.Render()
        self._window.WaitForCompletion()

    def depth(self) -> NDArray[np.float64]:
        """Return distances along the view axis."""
        self._draw(next(iter(VARIANTS)))
        (width, height), values = self._room.size, self._vtk.vtkFloatArray()
        self._window.GetZbufferData(0, 0, width - 1, height - 1, values)
        window = np.array(values, dtype=np.float64).reshape(height, width)[::-1]
        near, far = self._room.near, self._room.far
        depth = near * far / (far - window * (far - near))
        return np.where(window < 1.0, depth, 0.0)

    def visibility(self, variant: str) -> NDArray[np.float64] | None:
        """Return what a white room that shines by itself looks like."""
        if VARIANTS[variant] == 0:
            return None
        surface, mapper = self._actor.GetProperty(), self._actor.GetMapper()
        surface.SetAmbient(1.0)
        surface.SetDiffuse(0.0)
        mapper.SetScalarVisibility(False)
        self._draw(variant)
        reader = self._vtk.vtkWindowToImageFilter()
        reader.SetInput(self._window)
        reader.ReadFrontBufferOff()
        reader.ShouldRerenderOff()
        reader.Update()
        support = importlib.import_module("vtkmodules.util.numpy_support")
        scalars = reader.GetOutput().GetPointData().GetScalars()
        values: NDArray[np.uint8] = support.vtk_to_numpy(scalars)
        image = values.reshape(*self._room.size[::-1], 3)[::-1, :, 0] / 255.0
        surface.SetAmbient(SKY)
        surface.SetDiffuse(1.0)
        mapper.SetScalarVisibility(True)
        self._draw(variant)
        return image

    def timed(self, variant: str, frames: int) -> PeerTimes:
        """Draw `frames` frames; return means."""
        self._draw(variant)
        wall, process = time.perf_counter(), time.process_time()
        for _ in range(frames):
            self._draw(variant)
        scale = 1e3 / frames
        return PeerTimes(
            scale * (time.perf_counter() - wall), scale * (time.process_time() - process)
        )

    def close(self) -> None:
        """Release the window."""
        self._window.Finalize()

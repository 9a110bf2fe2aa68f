"""Ten minutes of flight at 30 frames a second: no leak, no NaN, no OpenGL error."""

from __future__ import annotations

import gc
import math
import os
from pathlib import Path

import pytest

from ssdo_gl.gpu.context import Device
from ssdo_gl.settings import Settings
from ssdo_gl.window.camera import fly_camera
from ssdo_gl.window.camera.controls import Controls

FRAME_S = 1.0 / 30.0
MINUTES = 10.0
# Between the first and the last minute the process may keep this much more: allocators
# do not give everything back. One texture of 160x90 a frame would be 4 GB.
MEMORY_MARGIN_MB = 30.0
SIZES = ((160, 90), (96, 96), (160, 90), (200, 50))


def resident_mb() -> float:
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def controls(frame: int) -> Controls:
    """Curves through the room, with pauses long enough to come to rest."""
    t = frame * FRAME_S
    if t % 20.0 > 17.0:
        return Controls()
    return Controls(
        move=(math.sin(0.7 * t), 0.3 * math.sin(0.31 * t), math.cos(0.43 * t)),
        turn_rate=(0.8 * math.sin(0.19 * t), 0.2 * math.cos(0.57 * t)),
        fast=t % 11.0 > 9.0,
    )


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads Linux's /proc")
@pytest.mark.parametrize("scene", ["cornell_meso", "carousel"])
def test_ten_minutes_of_flight(gl, device: Device, make_viewer, scene: str) -> None:
    viewer = make_viewer(scene, Settings("bounce", samples=16, steps=8, resolution_scale=0.5))
    frames = int(MINUTES * 60.0 / FRAME_S)
    minute = int(60.0 / FRAME_S)
    early = textures = 0.0
    for frame in range(frames):
        size = SIZES[frame // 400 % len(SIZES)]
        if frame % 300 == 299:
            viewer.view = viewer.view.with_number(1 + frame // 300 % 10)
        if frame % 1000 == 999:
            viewer.flight = fly_camera.go_home(viewer.flight)
        viewer.frame(controls(frame), FRAME_S, size)
        assert viewer.monitor.alarm is None, f"non-finite pixels in frame {frame}"
        if frame % 100 == 0:
            assert device.gl.error == "GL_NO_ERROR", f"OpenGL error by frame {frame}"
        if frame == minute:
            early = resident_mb()
            textures = viewer.left.image.renderer._executor.texture_count
    assert resident_mb() - early < MEMORY_MARGIN_MB
    assert viewer.left.image.renderer._executor.texture_count <= textures + 4

"""An executor that runs the passes of a test."""

from __future__ import annotations

import pytest
from graph.painting import triangle_scene

from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.graph.execute import Executor
from ssdo_gl.graph.graph import compile_graph


@pytest.fixture
def world(device, shaders):
    """Return what runs passes, and its executor."""
    executor = Executor(device, shaders)
    geometry = Geometry(device.gl, triangle_scene())
    yield (
        lambda passes, outputs, frame, **more: executor.run(
            compile_graph(passes, outputs), frame, geometry, **more
        ),
        executor,
    )
    executor.release()
    geometry.release()

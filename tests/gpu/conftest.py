"""Shaders of a test in a folder of their own."""

from __future__ import annotations

import pytest

from ssdo_gl.gpu.shader import ShaderLibrary


@pytest.fixture
def library(gl, tmp_path):
    """An empty library in a folder of its own, with the shipped passes/fullscreen.vert."""
    (tmp_path / "lib").mkdir()
    (tmp_path / "passes").mkdir()
    (tmp_path / "passes/fullscreen.vert").write_text(
        "#version 330 core\nvoid main() {\n"
        "  gl_Position = vec4(float((gl_VertexID & 1) << 2) - 1.0,\n"
        "                     float((gl_VertexID & 2) << 1) - 1.0, 0.0, 1.0);\n}\n"
    )
    return ShaderLibrary(gl, tmp_path)

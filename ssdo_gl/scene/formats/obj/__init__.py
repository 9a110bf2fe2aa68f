"""Wavefront .obj files and their .mtl material libraries."""

from __future__ import annotations

from ssdo_gl.scene.formats.scene_format import SceneFormat, lazily

OBJ = SceneFormat(
    "Wavefront OBJ", (".obj",), lazily(f"{__name__}.wavefront", "read_obj"), may_lie=True
)

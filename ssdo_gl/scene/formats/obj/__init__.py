"""Wavefront .obj files and their .mtl material libraries."""

from ssdo_gl.scene.formats.obj.wavefront import read_obj

__all__ = ["read_obj"]

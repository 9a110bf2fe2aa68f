"""Single meshes without scene structure: .ply .stl .off."""

from ssdo_gl.scene.formats.polygons.reader import read_polygons

__all__ = ["read_polygons"]

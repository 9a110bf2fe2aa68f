"""glTF 2.0: .gltf and .glb files."""

from __future__ import annotations

from ssdo_gl.scene.formats.scene_format import SceneFormat, lazily

GLTF = SceneFormat("glTF 2.0", (".glb", ".gltf"), lazily(f"{__name__}.reader", "read_gltf"))

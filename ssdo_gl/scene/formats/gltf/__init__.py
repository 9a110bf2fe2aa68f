"""glTF 2.0: .gltf and .glb files."""

from ssdo_gl.scene.formats.gltf.reader import read_gltf

__all__ = ["read_gltf"]

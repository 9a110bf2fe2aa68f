"""What hierarchies are made from, as a digest."""

from __future__ import annotations

from hashlib import blake2b
from typing import Any

from numpy.typing import NDArray

from ssdo_gl.raytracing.triangles import has_images
from ssdo_gl.scene.geometry import Mesh
from ssdo_gl.scene.scene import Scene


def content_key(scene: Scene) -> bytes:
    """Return a digest of all that the hierarchy and its triangles are made from."""
    digest = blake2b(repr(has_images(scene)).encode(), digest_size=16)
    for item in scene.objects:
        mesh = scene.meshes[item.mesh]
        side = scene.materials[item.material].single_sided
        head = (item.mesh, item.material, side, -1 if item.light is None else item.light)
        digest.update(repr((head, item.world_from_object.shape)).encode())
        digest.update(item.world_from_object.tobytes())
        for array in _arrays(mesh):
            digest.update(b"-" if array is None else repr(array.shape).encode())
            if array is not None:
                digest.update(array.tobytes())
    return digest.digest()


def _arrays(mesh: Mesh) -> tuple[NDArray[Any] | None, ...]:
    return (
        *(mesh.positions, mesh.triangles, mesh.normals, mesh.uvs, mesh.second_uvs),
        *(mesh.tangents, mesh.colors),
    )

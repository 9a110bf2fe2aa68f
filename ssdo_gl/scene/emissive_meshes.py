"""Lights that stand for emissive surfaces.

A surface made of parallelograms (a flat panel, a box) becomes exactly that many
rectangle lights. Any other shape is replaced, as a light, by a few sample
rectangles: its triangles are clustered by place and direction, and each cluster
lights the scene through one rectangle on the surface, of the same power.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import linear_from_srgb
from ssdo_gl.math3d import FloatArray, doubled_area_vectors, frame_from_z, vector
from ssdo_gl.scene.geometry import Mesh, SceneObject, Surfaces
from ssdo_gl.scene.lights import Light, RectangleLight, Shadow
from ssdo_gl.scene.material import Material

# Sample rectangles for a shape that is not made of parallelograms. Eight see a
# sphere from all sides; each one costs a shadow map.
SAMPLE_COUNT = 8
# A body of more parallelograms than this is sampled like any other shape.
MAX_PANELS = 16
# Lights made from all emissive surfaces of a scene together.
MAX_LIGHTS = 32
# Model files print coordinates with four or more decimals: corners of a flat
# parallelogram may be off by that much of its edges.
CORNER_TOLERANCE = 1e-4
# Clustering looks at no more triangles than this, spread evenly over the surface.
MAX_CLUSTERED = 20_000
_ROUNDS = 12


@dataclass(frozen=True)
class EmitterLights:
    """Objects with their `light` filled in, the lights to append, and notes."""

    objects: tuple[SceneObject, ...]
    lights: tuple[Light, ...]
    notes: tuple[str, ...]


def emitter_lights(
    surfaces: Surfaces, shadows: Mapping[int, Shadow], first_light: int
) -> EmitterLights:
    """Make lights for every emissive object that is not yet the body of a light.

    Parameters
    ----------
    shadows : mapping
        Object index -> how its lights are shadowed; "map" where absent.
    first_light : int
        Index that the first new light will have in the scene.
    """
    result = list(surfaces.objects)
    lights: list[Light] = []
    notes: list[str] = []
    for index, item in enumerate(surfaces.objects):
        material = surfaces.material(item)
        if item.light is not None or not material.emits:
            continue
        surface = _Surface.of(surfaces.mesh(item), material, item.world_from_object)
        if not surface.power.sum() > 0.0:
            continue
        made = _panels(surface)
        name = item.name or material.name or "emitter"
        exact = made is not None
        if made is None:
            made = _samples(surface, SAMPLE_COUNT)
        if len(lights) + len(made) > MAX_LIGHTS:
            notes.append(
                f"more than {MAX_LIGHTS} lights from emissive surfaces: the emission of "
                f"{name!r} and later ones is seen, and reaches only what is near it, but for gi, "
                "which asks all of it by rays"
            )
            break
        if not exact:
            notes.append(
                f"emissive shape {name!r} lights the scene through {len(made)} sample "
                f"rectangles of the same total power, but for gi"
            )
        elif material.emission_texture is not None:
            notes.append(
                f"emissive panel {name!r} lights the scene with its mean radiance, but for gi"
            )
        if surfaces.mesh(item).pose is not None:
            notes.append(f"emissive {name!r} changes its shape: its light stays as at time 0")
        result[index] = dataclasses.replace(item, light=first_light + len(lights))
        lights += [
            dataclasses.replace(
                light,
                shadow=shadows.get(index, "map"),
                visible=exact,
                two_sided=material.two_sided_emission,
                name=name,
                motion=item.motion,
            )
            for light in made
        ]
    return EmitterLights(tuple(result), tuple(lights), tuple(notes))


def turned_to_scene(surfaces: Surfaces) -> Iterator[tuple[int, Mesh, str]]:
    """Yield emissive meshes that shine the wrong way: index, turned mesh, note.

    For formats that do not say which side of a surface emits. A solid shines
    outward; a flat panel that faces away from the middle of the scene, and has next
    to nothing in front of it, is turned around.
    """
    for item in surfaces.objects:
        mesh, material = surfaces.mesh(item), surfaces.material(item)
        if not material.emits or material.two_sided_emission:
            continue
        surface = _Surface.of(mesh, material, item.world_from_object)
        if mesh.closed:
            corners = surface.corners - surface.corners.mean(axis=(0, 1))
            volume = np.linalg.det(corners).sum()
            wrong = volume < 0.0
        else:
            wrong = _faces_nothing(surface, surfaces, item)
        if wrong:
            turned = dataclasses.replace(
                mesh,
                triangles=mesh.triangles[:, ::-1],
                normals=None if mesh.normals is None else -mesh.normals,
            )
            name = item.name or material.name
            yield item.mesh, turned, f"emissive {name!r} faced away from the scene: turned around"


def _faces_nothing(surface: _Surface, surfaces: Surfaces, item: SceneObject) -> bool:
    """Return whether a flat panel has the scene behind it and almost none before it."""
    total = (surface.area[:, None] * surface.normal).sum(axis=0)
    if np.linalg.norm(total) < 0.999 * surface.area.sum():
        return False  # not flat
    normal = total / np.linalg.norm(total)
    center = np.average(surface.corners.mean(axis=1), axis=0, weights=surface.area)
    others = [o for o in surfaces.objects if o is not item]
    if not others:
        return False
    height = np.concatenate(
        [
            (mesh.positions @ matrix[:3, :3].T + matrix[:3, 3] - center) @ normal
            for o in others
            for mesh, matrix in ((surfaces.mesh(o), m) for m in o.world_from_object)
        ]
    )
    front, back = max(float(height.max()), 0.0), max(float(-height.min()), 0.0)
    # A lamp is set a little below its ceiling: what lies before it then reaches less
    # than a twentieth as far as what lies behind.
    return front < 0.05 * back


@dataclass(frozen=True)
class _Surface:
    """World-space triangles of an emissive object.

    corners (T, 3, 3); normal (T, 3), unit; area (T,); radiance (T, 3); power (T,) is
    area times mean radiance.
    """

    corners: FloatArray
    normal: FloatArray
    area: FloatArray
    radiance: FloatArray

    @property
    def power(self) -> FloatArray:
        return np.asarray(self.area * self.radiance.mean(axis=1))

    @classmethod
    def of(cls, mesh: Mesh, material: Material, world_from_object: FloatArray) -> _Surface:
        local = mesh.positions[mesh.triangles]
        corners = np.concatenate(
            [local @ matrix[:3, :3].T + matrix[:3, 3] for matrix in world_from_object]
        )
        cross = doubled_area_vectors(corners)
        length = np.linalg.norm(cross, axis=1)
        radiance = np.tile(_radiance(mesh, material), (len(world_from_object), 1))
        seen = length > 0.0
        normal = cross[seen] / length[seen, None]
        return cls(corners[seen], normal, 0.5 * length[seen], radiance[seen])


def _radiance(mesh: Mesh, material: Material) -> FloatArray:
    """Return the mean radiance of each triangle, (T, 3)."""
    factor = np.tile(np.asarray(material.emission, dtype=np.float64), (len(mesh.triangles), 1))
    texture = material.emission_texture
    if texture is None or mesh.uvs is None:
        return factor
    # Few triangles are looked up at many points, many at their centre: about 4096
    # lookups decide the mean either way.
    per_side = int(np.clip(np.sqrt(4096 / len(mesh.triangles)), 1, 64))
    step = (np.arange(per_side) + 0.5) / per_side
    a, b = (grid.reshape(-1) for grid in np.meshgrid(step, step))
    # sqrt warps the square onto the triangle with constant density.
    root = np.sqrt(a)
    weights = np.stack([1.0 - root, root * (1.0 - b), root * b], axis=1)
    every = np.repeat(np.arange(len(mesh.triangles)), len(weights))
    radiance = emitted_radiance(mesh, material, every, np.tile(weights, (len(mesh.triangles), 1)))
    return np.asarray(radiance.reshape(len(mesh.triangles), -1, 3).mean(axis=1))


def emitted_radiance(
    mesh: Mesh, material: Material, triangles: NDArray[np.int64], weights: FloatArray
) -> FloatArray:
    """Return emission (N, 3) at barycentric coordinates (N, 3) of `triangles` (N,)."""
    factor = np.tile(np.asarray(material.emission, dtype=np.float64), (len(triangles), 1))
    texture = material.emission_texture
    if texture is None or mesh.uvs is None:
        return factor
    uvs = mesh.uvs
    if mesh.second_uvs is not None and "emission" in material.second_uvs:
        uvs = mesh.second_uvs
    uv = np.einsum("nk,nkc->nc", weights, uvs[mesh.triangles[triangles]])
    return np.asarray(factor * linear_texels(texture.pixels, uv))


def linear_texels(pixels: NDArray[np.uint8] | NDArray[np.float32], uv: FloatArray) -> FloatArray:
    """Return scene-linear colours (..., 3) of the nearest texels at repeated `uv`."""
    height, width = pixels.shape[:2]
    column = np.floor(uv[..., 0] * width).astype(np.int64) % width
    row = np.floor(uv[..., 1] * height).astype(np.int64) % height
    texel = pixels[row, column, :3]
    if pixels.dtype != np.uint8:
        return np.asarray(texel, dtype=np.float64)
    return linear_from_srgb(np.asarray(texel, dtype=np.float64) / 255.0)


def _panels(surface: _Surface) -> list[RectangleLight] | None:
    """Return one rectangle for each pair of triangles, or None if they do not pair up."""
    count = len(surface.corners)
    if count % 2 or count > 2 * MAX_PANELS:
        return None
    free = list(range(count))
    lights = []
    while free:
        first = free.pop(0)
        for second in free:
            shape = _parallelogram(surface.corners[first], surface.corners[second])
            if shape is not None:
                free.remove(second)
                break
        else:
            return None
        corner, edge_u, edge_v = shape
        pair = [first, second]
        mean = np.average(surface.radiance[pair], axis=0, weights=surface.area[pair])
        lights.append(RectangleLight(vector(corner), vector(edge_u), vector(edge_v), vector(mean)))
    return lights


def _parallelogram(
    one: FloatArray, other: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return corner and edges if two triangles (3, 3) halve a parallelogram.

    The front of the parallelogram is that of the triangles, which must agree.
    """
    size = float(np.max(np.ptp(one, axis=0)))
    tolerance = CORNER_TOLERANCE * size
    for turn in range(3):
        corner, p, q = np.roll(one, -turn, axis=0)
        opposite = p + q - corner
        for turn_other in range(3):
            wanted = np.stack([opposite, q, p])
            if np.max(np.abs(np.roll(other, -turn_other, axis=0) - wanted)) <= tolerance:
                return corner, p - corner, q - corner
    return None


def _samples(surface: _Surface, count: int) -> list[RectangleLight]:
    """Return at most `count` rectangles on the surface that share out its power."""
    surface = _thinned(surface)
    middle = surface.corners.mean(axis=1)
    label = _clusters(surface, middle, count)
    lights = []
    for cluster in range(count):
        members = np.flatnonzero(label == cluster)
        power = surface.power[members]
        if not power.sum() > 0.0:
            continue
        area = surface.area[members]
        center = np.average(middle[members], axis=0, weights=power)
        # The rectangle must lie on the surface: inside, the body would shadow it.
        nearest = members[np.argmin(((middle[members] - center) ** 2).sum(axis=1))]
        total = np.average(surface.radiance[members], axis=0, weights=area) * area.sum()
        # Seen from afar a curved cluster shows its projected area; a crumpled one,
        # whose normals cancel, keeps at least a quarter.
        projected = np.linalg.norm((area[:, None] * surface.normal[members]).sum(axis=0))
        size = max(float(projected), 0.25 * float(area.sum()))
        frame = frame_from_z(surface.normal[nearest])
        edge_u, edge_v = frame[:, 0] * np.sqrt(size), frame[:, 1] * np.sqrt(size)
        corner = middle[nearest] - 0.5 * (edge_u + edge_v)
        lights.append(
            RectangleLight(vector(corner), vector(edge_u), vector(edge_v), vector(total / size))
        )
    return lights


def _thinned(surface: _Surface) -> _Surface:
    """Keep at most MAX_CLUSTERED triangles, chosen evenly by power, of the same power."""
    count = len(surface.area)
    if count <= MAX_CLUSTERED:
        return surface
    cumulative = np.cumsum(surface.power)
    level = (np.arange(MAX_CLUSTERED) + 0.5) / MAX_CLUSTERED * cumulative[-1]
    kept, times = np.unique(np.searchsorted(cumulative, level), return_counts=True)
    area = times * cumulative[-1] / MAX_CLUSTERED / surface.radiance[kept].mean(axis=1)
    return _Surface(surface.corners[kept], surface.normal[kept], area, surface.radiance[kept])


def _clusters(surface: _Surface, middle: FloatArray, count: int) -> NDArray[np.int64]:
    """Label triangles by cluster: power-weighted k-means in place and direction.

    Deterministic: it starts from the farthest-point sequence of the brightest triangle.
    """
    spread = float(np.max(np.ptp(surface.corners.reshape(-1, 3), axis=0))) or 1.0
    # Two points at the full spread apart count like opposite directions.
    feature = np.concatenate([2.0 * middle / spread, surface.normal], axis=1)
    power = surface.power
    chosen = [int(np.argmax(power))]
    distance = ((feature - feature[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(count, len(feature)):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, ((feature - feature[chosen[-1]]) ** 2).sum(axis=1))
    centers = feature[chosen]
    label = np.zeros(len(feature), dtype=np.int64)
    for _ in range(_ROUNDS):
        gaps = ((feature[:, None, :] - centers[None]) ** 2).sum(axis=2)
        label = np.argmin(gaps, axis=1)
        for cluster in range(len(centers)):
            weight = np.where(label == cluster, power, 0.0)
            if weight.sum() > 0.0:
                centers[cluster] = np.average(feature, axis=0, weights=weight)
    return label

"""An exposure that suits the light a model file brings, and whether that light will do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray, doubled_area_vectors, lengths_of_rows
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.defaults.framing import is_room
from ssdo_gl.scene.emissive_meshes import emitted_radiance
from ssdo_gl.scene.geometry import Surfaces, placed, spans
from ssdo_gl.scene.lights import Light
from ssdo_gl.settings.settings import MAX_EXPOSURE_EV

# Radiance that a light grey surface gets from direct light alone at the brighter end
# of the scene; indirect light adds about half as much again in a room.
_TARGET_RADIANCE, _GREY, _PERCENTILE = 0.3, 0.8, 75.0
_SAMPLES = 2000
# Of one object's copies, beyond which not all of them are looked at.
_MAX_TRIANGLES = 1 << 22
# A brighter part of the picture than this, after exposure, loses its shapes.
_BRIGHTEST_RADIANCE, _BRIGHT_PERCENTILE = 1.5, 90.0
# Light that would have to be raised by more than this was not meant to light a scene.
# Glowing parts of a model (emission up to 1) are raised less than lamps of real units.
_MAX_LAMP_EV, _MAX_GLOW_EV = 8.0, 3.0
# Parts darker than this share of the picture's bright ones are black beside them; a
# picture that mostly is needs light from elsewhere.
_DARK_SHARE, _NEEDED_COVERAGE = 1.0 / 32.0, 0.5
# Where lamps leave most of the picture dark, exposing for a default sky may lower it by
# this much for their sake.
_MIN_FILLED_EV = -4.0

# A surface that shows less than this is black, whatever else there is to see; light that
# reaches next to nothing was not meant to light it.
_BLACK_RADIANCE = _TARGET_RADIANCE / 16.0
# Share of what the camera sees that must be of metal for its light to be a studio.
_METAL_SHARE = 0.15

Fill = Literal["none", "dim sky", "sky", "sky and key"]


@dataclass(frozen=True)
class Lighting:
    """What a picture of a scene of unknown light needs.

    Attributes
    ----------
    exposure : float
        EV.
    fill : "none", "dim sky", "sky" or "sky and key"
        The default light to add. The sky alone is to be multiplied by 2^-exposure, so that
        it shows beside lamps of any strength; with the key light it is at exposure 0. The
        dim sky belongs to lamps that light the picture, and is relative to `level`.
    level : float
        Radiance of the brighter of the surfaces that are lit, before exposure.
    """

    exposure: float
    fill: Fill
    level: float = 0.0


def lighting_for(
    surfaces: Surfaces, lights: Sequence[Light], camera: Camera, *, has_lamps: bool
) -> Lighting:
    """Return exposure and fill light for what the camera sees.

    Parameters
    ----------
    has_lamps : bool
        Whether the file has lights besides its emissive surfaces, which often are there to
        glow rather than to light.
    """
    exposure = exposure_for(surfaces, lights)
    received, glow, weight, owner = _seen(surfaces, lights, camera)
    radiance = received + glow
    most = _MAX_LAMP_EV if has_lamps else _MAX_GLOW_EV
    if not weight.sum() > 0.0:  # nothing, or all of it edge-on
        return Lighting(min(exposure, most), "none")
    bright = _percentile(radiance, weight, _BRIGHT_PERCENTILE)
    highest = float(np.log2(_BRIGHTEST_RADIANCE / bright)) if bright > 0.0 else np.inf
    lit = radiance > 0.0
    level = _percentile(radiance[lit], weight[lit], _PERCENTILE) if lit.any() else 0.0
    final = min(exposure, most, highest)
    least = max(_DARK_SHARE * level, _BLACK_RADIANCE * 2.0**-final)
    # What glows by less than light on it would bring looks dull, and flat.
    materials = [surfaces.material(item) for item in surfaces.objects]
    albedo = np.array([m.mean_albedo if m.emits else 0.0 for m in materials])
    shines = glow * 2.0**final >= _TARGET_RADIANCE / _GREY * albedo[owner]
    is_lit = (radiance >= least) & (shines | (received >= least))
    coverage = float(weight[is_lit].sum() / weight.sum())
    # A glow next to nothing, where it is all there is, shows nothing.
    is_black = level * 2.0 ** min(exposure, most) < _TARGET_RADIANCE * 2.0**-_MAX_LAMP_EV
    if coverage >= _NEEDED_COVERAGE and exposure <= most and not is_black:
        is_open = has_lamps and not is_room(surfaces, camera)
        return Lighting(_rounded(final), "dim sky" if is_open else "none", level)
    if not has_lamps or is_black or exposure > most:
        return Lighting(_rounded(float(np.clip(highest, _MIN_FILLED_EV, 0.0))), "sky and key")
    return Lighting(_rounded(min(exposure, highest)), "sky")


def seen_metal(surfaces: Surfaces, camera: Camera) -> bool:
    """Return whether enough of what the camera sees is of metal to show what it reflects."""
    metal = np.array([surfaces.material(item).mean_metallic for item in surfaces.objects])
    if not metal.any():
        return False
    samples = _samples_in_view(surfaces, camera)
    total = samples.weight.sum()
    return bool(total > 0.0 and metal[samples.owner] @ samples.weight >= _METAL_SHARE * total)


@dataclass(frozen=True)
class _Samples:
    """Points on surfaces, spread evenly by area.

    Attributes
    ----------
    points, normals : ndarray, shape (N, 3)
    owner, triangle : ndarray, shape (N,)
        Index of the object, and of the triangle in its mesh.
    corner_weights : ndarray, shape (N, 3)
        Barycentric coordinates.
    weight : ndarray, shape (N,)
        Solid angle that each stands for, relative to the others.
    """

    points: FloatArray
    normals: FloatArray
    owner: NDArray[np.int64]
    triangle: NDArray[np.int64]
    corner_weights: FloatArray
    weight: FloatArray

    def of(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> _Samples:
        """Return some of the samples."""
        return _Samples(*(getattr(self, field.name)[chosen] for field in fields(self)))


def _samples_in_view(surfaces: Surfaces, camera: Camera) -> _Samples:
    """Return points that the camera may see, with normals that face it.

    What hides what is not looked into; backs of closed bodies are left out.
    """
    samples = _surface_samples(surfaces)
    offset = np.asarray(camera.position) - samples.points
    distance_2 = np.maximum((offset**2).sum(axis=1), np.finfo(np.float64).tiny)
    cosine = (offset * samples.normals).sum(axis=1) / np.sqrt(distance_2)
    closed = np.array([surfaces.mesh(o).closed for o in surfaces.objects], dtype=bool)
    local = -offset @ camera.view_from_world_rotation().T
    x, y = camera.tan_half_fov(16.0 / 9.0)
    seen = (local[:, 2] < 0.0) & (np.abs(local[:, 0]) <= -x * local[:, 2])
    seen &= np.abs(local[:, 1]) <= -y * local[:, 2]
    seen &= ~(closed[samples.owner] & (cosine < 0.0))
    toward = samples.normals * np.where(cosine < 0.0, -1.0, 1.0)[:, None]
    weight = np.abs(cosine) / distance_2
    return replace(samples, normals=toward, weight=weight).of(seen)


def _seen(
    surfaces: Surfaces, lights: Sequence[Light], camera: Camera
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """Return what points reflect and emit that the camera may see, solid angles and objects."""
    samples = _samples_in_view(surfaces, camera)
    total = np.zeros(len(samples.points))
    for light in lights if len(total) else ():
        total += np.maximum(light.irradiance_at(samples.points, samples.normals), 0.0)
    glow = np.zeros(len(total))
    for index, item in enumerate(surfaces.objects):
        chosen = np.flatnonzero(samples.owner == index)
        if surfaces.material(item).emits and len(chosen):
            part = samples.of(chosen)
            glow[chosen] = emitted_radiance(
                surfaces.mesh(item), surfaces.material(item), part.triangle, part.corner_weights
            ).mean(axis=1)
    glow = np.minimum(glow, _BRIGHTEST_RADIANCE)
    return total * (_GREY / np.pi), glow, samples.weight, samples.owner


def _percentile(values: FloatArray, weight: FloatArray, percent: float) -> float:
    order = np.argsort(values)
    share = np.cumsum(weight[order])
    return float(values[order][np.searchsorted(share, share[-1] * percent / 100.0)])


def _rounded(exposure: float) -> float:
    return float(np.round(np.clip(exposure, -MAX_EXPOSURE_EV, MAX_EXPOSURE_EV), 1))


def exposure_for(surfaces: Surfaces, lights: Sequence[Light]) -> float:
    """Return the exposure in EV at which a scene of unknown light shows well.

    From the unshadowed irradiance at points spread evenly over the surfaces; 0 if no
    light reaches any, or if all of them are lamps.
    """
    samples = _surface_samples(
        surfaces._replace(objects=[o for o in surfaces.objects if o.light is None])
    )
    total = np.zeros(len(samples.points))
    for light in lights if len(total) else ():
        total += np.abs(light.irradiance_at(samples.points, samples.normals))
    reached = total[total > 0.0]
    if not len(reached):
        return 0.0
    level = float(np.percentile(reached, _PERCENTILE)) * _GREY / np.pi
    return float(np.round(np.log2(_TARGET_RADIANCE / level), 1))


def _surface_samples(surfaces: Surfaces) -> _Samples:
    # Twice the areas of the triangles of all copies, object after object.
    areas, copies = [np.zeros(0)], []
    for item in surfaces.objects:
        mesh = surfaces.mesh(item)
        # Of very many copies a share says enough, and fits into memory.
        count = len(item.world_from_object) * len(mesh.triangles)
        copies.append(item.world_from_object[:: 1 + count // _MAX_TRIANGLES])
        doubled = np.empty((len(copies[-1]), len(mesh.triangles)))
        for span in spans(len(mesh.triangles)):
            corners = placed(mesh.corners(span), copies[-1]).reshape(-1, 3, 3)
            areas_of_span = lengths_of_rows(doubled_area_vectors(corners))
            doubled[:, span] = areas_of_span.reshape(len(doubled), -1)
        areas.append(doubled.reshape(-1))
    cumulative = np.cumsum(np.concatenate(areas))
    is_empty = not len(cumulative) or cumulative[-1] <= 0.0
    count = 0 if is_empty else _SAMPLES
    total = 0.0 if is_empty else cumulative[-1]
    chosen = np.searchsorted(cumulative, (np.arange(count) + 0.5) / _SAMPLES * total)
    starts = np.cumsum([len(part) for part in areas])
    owner = np.searchsorted(starts, chosen, side="right") - 1
    triangle = np.zeros(count, dtype=np.int64)
    corners = np.zeros((count, 3, 3))
    for index in np.unique(owner):
        mine, mesh = owner == index, surfaces.mesh(surfaces.objects[index])
        copy, triangle[mine] = np.divmod(chosen[mine] - starts[index], len(mesh.triangles))
        local = mesh.positions[mesh.triangles[triangle[mine]]]
        matrices = copies[index][copy]
        corners[mine] = local @ matrices[:, :3, :3].transpose(0, 2, 1) + matrices[:, None, :3, 3]
    # The golden ratio and its square spread the points over each triangle.
    a, b = (np.arange(count) * step % 1.0 for step in (0.618033988749895, 0.754877666246693))
    root = np.sqrt(a)
    weights = np.stack([1.0 - root, root * (1.0 - b), root * b], axis=1)
    points = np.einsum("pk,pkc->pc", weights, corners)
    cross = doubled_area_vectors(corners)
    normals = cross / lengths_of_rows(cross)[:, None]
    return _Samples(points, normals, owner, triangle, weights, np.ones(count))

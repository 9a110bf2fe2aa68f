"""The sun in an image of the sky, as a light of its own, which throws sharp shadows."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment.daylight import SUN, SkyEnvironment
from ssdo_gl.scene.environment.environment_kinds import Environment, MapEnvironment, texels
from ssdo_gl.scene.lights import DirectionalLight

# Degrees about the brightest texel in which its light counts as the sun's: its disk of .53 degrees,
# and what the camera's lens adds. In small images it is a few texels wide. Around it the sky is
# asked up to twice as far away.
REACH, TEXELS, MOST_REACH = 2.5, 1.5, 5.0
# What is wider is not cut: as long as more than so much of this light comes from around, it is
# sought farther about its middle, in steps up to so many degrees.
MOST_CUT, REACH_GROWTH, LARGEST_REACH = 0.1, 1.25, 10.0
# What is brighter than so many times that sky is the sun,
BRIGHTER = 2.0
# if it brings this share of what a surface that faces it receives. A lamp of a studio is larger,
# light of an overcast sky has no such place.
LEAST_SHARE = 0.15
# Rows, and columns, of what tells how much light arrives.
_LEAST_ASKED = 256


def sun_apart(
    image: NDArray[np.float32], rotation_y: float = 0.0, name: str = ""
) -> MapEnvironment:
    """Return an environment whose sun is not in its image, but its `sun`, if it has one.

    Parameters
    ----------
    image, rotation_y, name
        As `MapEnvironment` has them. Where the sun was, the image shows the sky around it.
    """
    whole = MapEnvironment(image, rotation_y, name)
    height, width = image.shape[:2]
    level = image.mean(axis=2)
    row, column = np.unravel_index(level.argmax(), level.shape)
    middle = texels(height, width, row[None], column[None])[0][0, 0]
    found = _bright_within(image, level, middle, _reach(height))
    larger = found
    while larger is not None and larger.is_cut and larger.reach * REACH_GROWTH <= LARGEST_REACH:
        larger = _bright_within(image, level, larger.middle, larger.reach * REACH_GROWTH)
    if larger is not None and not larger.is_cut:
        found = larger
    if found is None:
        return whole
    irradiance = found.light.sum(axis=0).clip(min=0.0)
    rest = image.copy()
    rest[found.rows][found.chosen] = found.sky
    facing = irradiance.mean() + _irradiance(rest, found.middle)
    weight, size = found.light.mean(axis=1), found.size
    # The solid angle of an even disk that is as bright as the sun's light is in the mean.
    solid_angle = weight.sum() ** 2 / max(np.sum(weight**2 / size), 1e-300)
    disk = 2.0 * math.degrees(math.acos(max(1.0 - solid_angle / (2.0 * math.pi), -1.0)))
    if not (irradiance.mean() > LEAST_SHARE * facing and disk <= 2.0 * found.reach):
        return whole
    x, y, z = (-found.middle).tolist()
    red, green, blue = irradiance.tolist()
    sun = DirectionalLight((x, y, z), (red, green, blue), disk, name=SUN)
    return replace(whole, image=rest, sun=sun)


@dataclass(frozen=True, eq=False)
class _Bright:
    """What shines within some degrees of a place in an image.

    Attributes
    ----------
    reach : float
        Those degrees.
    rows : slice
        Of the image, of which `chosen` (R, W) says which texels shine.
    sky : ndarray, shape (3,)
        Around.
    light, size : ndarray, shape (N, 3) and (N,)
        Irradiance that they bring beyond that of such a sky, and their solid angles.
    middle : ndarray, shape (3,)
        Unit, towards the middle of that light.
    is_cut : bool
        Whether what shines goes on beyond.
    """

    reach: float
    rows: slice
    chosen: NDArray[np.bool_]
    sky: FloatArray
    light: FloatArray
    size: FloatArray
    middle: FloatArray
    is_cut: bool


def _reach(height: int) -> float:
    return min(max(REACH, TEXELS * 180.0 / height), MOST_REACH)


def _bright_within(
    image: NDArray[np.float32], level: NDArray[np.float32], middle: FloatArray, reach: float
) -> _Bright | None:
    """Return what shines within `reach` degrees of a direction; None if no sky is around."""
    height, width = level.shape
    row = math.acos(max(min(float(middle[1]), 1.0), -1.0)) / math.pi * height
    margin = math.ceil(2.0 * reach / 180.0 * height)
    rows = slice(max(int(row) - margin, 0), int(row) + margin + 1)
    near, shown = image[rows].astype(np.float64), level[rows]
    directions, size = texels(height, width, np.arange(height)[rows], np.arange(width))
    apart = np.degrees(np.arccos(np.clip(directions @ middle, -1.0, 1.0)))
    around = (apart > reach) & (apart <= 2.0 * reach)
    if not around.any():
        return None
    sky = np.median(near[around], axis=0)
    shines = shown > BRIGHTER * sky.mean()
    chosen = (apart <= reach) & shines
    light = (near[chosen] - sky) * size[chosen][:, None]
    weight = light.mean(axis=1)
    beyond = np.sum((shown - sky.mean())[around & shines] * size[around & shines])
    to_light = weight @ directions[chosen]
    to_light = to_light / max(np.linalg.norm(to_light), 1e-300)
    is_cut = bool(beyond > MOST_CUT * weight.sum())
    return _Bright(reach, rows, chosen, sky, light, size[chosen], to_light, is_cut)


def turned_sun(environment: MapEnvironment) -> DirectionalLight | None:
    """Return the sun of `environment` as it shines on a scene; None if it has none."""
    if environment.sun is None:
        return None
    x, y, z = environment.sun.direction
    turn = math.radians(environment.rotation_y)
    cosine, sine = math.cos(turn), math.sin(turn)
    return replace(environment.sun, direction=(x * cosine + z * sine, y, z * cosine - x * sine))


def sun_of(environment: Environment | None) -> DirectionalLight | None:
    """Return the sun that goes with an environment, as a light; None if it has none."""
    if isinstance(environment, SkyEnvironment):
        return environment.daylight.sun()
    return turned_sun(environment) if isinstance(environment, MapEnvironment) else None


def sun_note(environment: MapEnvironment) -> str:
    """Return the line that says what became of the image's sun; empty if it has none."""
    apart = f"the sun of {environment.name} shines as a light of its own, which throws shadows"
    return "" if environment.sun is None else apart


def _irradiance(image: NDArray[np.float32], normal: FloatArray) -> float:
    """Return what arrives at a surface, all colours together, by some texels of an image."""
    height, width = image.shape[:2]
    rows, columns = (np.arange(0, n, max(n // _LEAST_ASKED, 1)) for n in (height, width))
    directions, size = texels(height, width, rows, columns)
    level = image[np.ix_(rows, columns)].mean(axis=2, dtype=np.float64)
    share = (height * width) / level.size
    return float(share * np.sum(level * size * np.maximum(directions @ normal, 0.0)))

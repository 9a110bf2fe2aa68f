"""Sun and clear sky by the time of day.

Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999, which
fits Perez's distribution of luminance and chromaticity over the sky by its turbidity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ssdo_gl.color import RGB_FROM_XYZ
from ssdo_gl.math3d import FloatArray
from ssdo_gl.scene.environment.environment_kinds import MapEnvironment, texels
from ssdo_gl.scene.lights import DirectionalLight, Light

SUN = "sun"
# Full angle of the sun's disk, degrees.
SUN_ANGLE = 0.53
# Of light in klx, or kcd/m^2: a white floor under sun and sky of 100 klx, a bright summer's
# day, has a radiance of 1, as whatever is white has in other light at exposure 0.
UNITS_PER_KLX = math.pi / 100.0
# Of the sunlight above the atmosphere.
SUN_KLX, SUN_KELVIN = 128.0, 5772.0
# What lies below the horizon: a wide field of this albedo.
GROUND_ALBEDO = 0.2
# Lower, the fit has no data: Perez's term 1 / cos(theta) has a pole at the horizon.
_LOWEST_COSINE = 0.01
# A third of a degree a texel: texels are patches, and the sky is in view.
_ROWS, _COLUMNS = 512, 1024
# Perez's A to E of luminance Y and chromaticities x and y (Preetham et al., A.2): in each
# row five factors of the turbidity and five constants.
_PEREZ = np.array(
    [
        [0.1787, -0.3554, -0.0227, 0.1206, -0.0670, -1.4630, 0.4275, 5.3251, -2.5771, 0.3703],
        [-0.0193, -0.0665, -0.0004, -0.0641, -0.0033, -0.2592, 0.0008, 0.2125, -0.8989, 0.0452],
        [-0.0167, -0.0950, -0.0079, -0.0441, -0.0109, -0.2608, 0.0092, 0.2102, -1.6537, 0.0529],
    ]
).reshape(3, 2, 5)
# Of the zenith's x and y: rows for turbidity^2, turbidity and 1, columns for theta^3 to 1.
_ZENITH_X = np.array(
    [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ]
)
_ZENITH_Y = np.array(
    [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ]
)
# Wavelengths, micrometres, that stand for red, green and blue, and the ozone's absorption
# there, 1/cm, of which 0.35 cm lie above.
_MICROMETRES = np.array([0.610, 0.550, 0.465])
_OZONE, _OZONE_CM = np.array([0.122, 0.085, 0.009]), 0.35


@dataclass(frozen=True)
class Daylight:
    """A clear day.

    Attributes
    ----------
    hour : float
        Solar time, 0 to 24: the sun is highest at 12.
    latitude : float
        Degrees, north positive.
    day : float
        Of the year, 1 to 366; the default is the longest.
    turbidity : float
        Haze, 2 (very clear) to 10.
    north : float
        Degrees by which north is turned from -z about +y, counter-clockwise from above.
    """

    hour: float = 15.0
    latitude: float = 45.0
    day: float = 172.0
    turbidity: float = 3.0
    north: float = 0.0

    @cached_property
    def to_sun(self) -> FloatArray:
        """The unit direction to the sun, (3,); may be below the horizon."""
        # Cooper 1969: the tilt of the earth's axis, 284 days after the equinox of spring.
        declination = math.radians(23.45) * math.sin(2.0 * math.pi * (284.0 + self.day) / 365.0)
        latitude, turn = math.radians(self.latitude), math.radians(15.0 * (self.hour - 12.0))
        up = math.sin(latitude) * math.sin(declination)
        up += math.cos(latitude) * math.cos(declination) * math.cos(turn)
        west = math.cos(declination) * math.sin(turn)
        south = math.sin(latitude) * math.cos(declination) * math.cos(turn)
        south -= math.cos(latitude) * math.sin(declination)
        x, z = -west, south
        cosine, sine = math.cos(math.radians(self.north)), math.sin(math.radians(self.north))
        return np.array([cosine * x + sine * z, up, cosine * z - sine * x])

    @property
    def is_day(self) -> bool:
        """Whether the sun is above the horizon."""
        return bool(self.to_sun[1] > 0.0)

    def sun(self) -> DirectionalLight:
        """Return the sun's light after its way through the air; by day only.

        Rayleigh's scattering, Angstrom's of haze, and ozone, by the relative optical mass of
        the air (Preetham et al., A.1).
        """
        theta = math.acos(self.to_sun[1])
        mass = 1.0 / (math.cos(theta) + 0.15 * (93.885 - math.degrees(theta)) ** -1.253)
        haze = 0.04608 * self.turbidity - 0.04586
        depth = 0.008735 * _MICROMETRES**-4.08 + haze * _MICROMETRES**-1.3 + _OZONE * _OZONE_CM
        color = _rgb(1.0, *_black_body(SUN_KELVIN)) * np.exp(-mass * depth)
        r, g, b = (float(part) for part in SUN_KLX * UNITS_PER_KLX * color)
        x, y, z = (float(-part) for part in self.to_sun)
        return DirectionalLight((x, y, z), (r, g, b), SUN_ANGLE, name=SUN)

    def radiance(self, directions: FloatArray) -> FloatArray:
        """Return the sky's radiance (..., 3) from unit `directions` (..., 3) above the horizon."""
        cosine = np.maximum(directions[..., 1], _LOWEST_COSINE)
        to_sun = np.clip(directions @ self.to_sun, -1.0, 1.0)
        theta = math.acos(self.to_sun[1])
        shape = _perez(self.turbidity, cosine, np.arccos(to_sun))
        shape /= _perez(self.turbidity, np.ones(()), np.asarray(theta))
        luminance, x, y = np.moveaxis(shape * self._zenith(theta), -1, 0)
        return np.maximum(UNITS_PER_KLX * _rgb(luminance, x, y), 0.0)

    def _zenith(self, theta: float) -> FloatArray:
        """Return the zenith's luminance, kcd/m^2, and chromaticities x and y."""
        haze = self.turbidity
        chi = (4.0 / 9.0 - haze / 120.0) * (math.pi - 2.0 * theta)
        luminance = (4.0453 * haze - 4.9710) * math.tan(chi) - 0.2155 * haze + 2.4192
        powers, hazes = theta ** np.arange(3, -1, -1), haze ** np.arange(2, -1, -1)
        return np.array([luminance, hazes @ _ZENITH_X @ powers, hazes @ _ZENITH_Y @ powers])


@dataclass(frozen=True, eq=False)
class SkyEnvironment(MapEnvironment):
    """The sky of a day, and the ground that sun and sky light below it."""

    daylight: Daylight = field(default_factory=Daylight)


def sky(daylight: Daylight) -> SkyEnvironment:
    """Return the sky of a day; the sun is `Daylight.sun`."""
    directions, size = texels(_ROWS, _COLUMNS, np.arange(_ROWS // 2))
    above = daylight.radiance(directions)
    sunlight = np.multiply(daylight.sun().irradiance, daylight.to_sun[1])
    on_ground = np.einsum("rc,rck->k", size * directions[..., 1], above) + sunlight
    image = np.concatenate([above, np.broadcast_to(GROUND_ALBEDO / np.pi * on_ground, above.shape)])
    return SkyEnvironment(image.astype(np.float32), name="sky", daylight=daylight)


def with_sun(lights: tuple[Light, ...], sun: DirectionalLight) -> tuple[Light, ...]:
    """Return `lights` with the sun, if it is among them, as `sun` shines."""
    return tuple(
        replace(light, direction=sun.direction, irradiance=sun.irradiance, angle=sun.angle)
        if isinstance(light, DirectionalLight) and light.name == SUN
        else light
        for light in lights
    )


def _perez(turbidity: float, cosine: FloatArray, gamma: FloatArray) -> FloatArray:
    """Return Perez's function (..., 3) of Y, x and y.

    Parameters
    ----------
    cosine : ndarray
        Of the angle from the zenith.
    gamma : ndarray
        Angle from the sun, radians.
    """
    a, b, c, d, e = np.einsum("t,ctp->pc", [turbidity, 1.0], _PEREZ)
    cosine, gamma = cosine[..., None], gamma[..., None]
    near_horizon = 1.0 + a * np.exp(b / cosine)
    return np.asarray(near_horizon * (1.0 + c * np.exp(d * gamma) + e * np.cos(gamma) ** 2))


def _rgb(luminance: FloatArray | float, x: FloatArray | float, y: FloatArray | float) -> FloatArray:
    """Return linear sRGB (..., 3) of a luminance and chromaticities."""
    share = np.divide(luminance, y)
    xyz = np.stack(np.broadcast_arrays(x * share, luminance, (1.0 - x - y) * share), axis=-1)
    return np.asarray(xyz @ RGB_FROM_XYZ.T)


def _black_body(kelvin: float) -> tuple[float, float]:
    """Return CIE x and y of a black body of 4000 to 25 000 K (Kim et al. 2002)."""
    k = 1e3 / kelvin
    x = -3.0258469 * k**3 + 2.1070379 * k**2 + 0.2226347 * k + 0.240390
    return x, 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483

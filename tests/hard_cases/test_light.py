"""Light at its limits: none, faint, blinding, touching surfaces, on the horizon."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from hard_cases.hard_scene import CAMERA, room
from hard_cases.invariants import sane
from hard_cases.methods import METHODS, SCREEN_SPACE, label, render

from ssdo_gl.scene.environment.environment_kinds import ConstantEnvironment, MapEnvironment
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.scene.material import Material

RADIANCES = ("beauty", "direct", "directional", "bounce")


def dimmed(factor):
    """Return the room with all light multiplied by `factor`."""

    def scale(color):
        return tuple(factor * c for c in color)

    lights = []
    for light in room().lights:
        field = next(f for f in ("radiance", "irradiance", "intensity") if hasattr(light, f))
        lights.append(dataclasses.replace(light, **{field: scale(getattr(light, field))}))
    sky = ConstantEnvironment(scale(room().environment.radiance))
    return room(lights=tuple(lights), environment=sky)


def only(*lights, **changes):
    return room(lights=lights, environment=None, **changes)


def sun_disc():
    """Return a dark sky with one texel of 1e5."""
    image = np.full((16, 32, 3), 0.05, np.float32)
    image[4, 20] = 1e5
    return MapEnvironment(image)


def colored(albedo):
    return room(materials=tuple(Material(albedo=(albedo,) * 3) for _ in range(4)))


DARK = (0.0, 0.0, 0.0)
CASES = {
    "light of intensity 1e-8": lambda: dimmed(1e-8),
    "light of intensity 1e8": lambda: dimmed(1e8),
    "point light on the floor": lambda: only(PointLight((0.2, 0.0, 0.5), (1, 1, 1))),
    "point light inside a box": lambda: only(PointLight((-0.3, 0.3, -0.4), (1, 1, 1))),
    "point light at the camera": lambda: only(PointLight(CAMERA.position, (1, 1, 1))),
    "point light on a vertex": lambda: only(PointLight((-1.0, 0.0, -1.0), (1, 1, 1))),
    "rectangle in the plane of the floor": lambda: only(
        RectangleLight((0, 0, 0.5), (0.3, 0, 0), (0, 0, -0.3), (5, 5, 5), visible=False)
    ),
    "rectangle across the horizon": lambda: only(
        RectangleLight((-0.5, -0.5, 0.9), (1, 0, 0), (0, 1, 0), (5, 5, 5), visible=False)
    ),
    "rectangle edge-on": lambda: only(
        RectangleLight((0, 0.5, 0), (0.5, 0, 0), (0, 0, 1e-7), (5, 5, 5), visible=False)
    ),
    "rectangle of zero area": lambda: only(
        RectangleLight((0, 0.5, 0), (0.5, 0, 0), (0.25, 0, 0), (5, 5, 5), visible=False)
    ),
    "rectangle larger than the world": lambda: only(
        RectangleLight((-1e6, 3, -1e6), (2e6, 0, 0), (0, 0, 2e6), (1, 1, 1), visible=False)
    ),
    "HDR sun disc": lambda: room(environment=sun_disc(), lights=()),
    "black albedo": lambda: colored(0.0),
    "white albedo": lambda: colored(1.0),
    "albedo 0.999": lambda: colored(0.999),
}


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("case", CASES)
def test_images_stay_sane(device, shaders, record, method, case):
    images = render(device, shaders, CASES[case](), method)
    record(case, label(method), sane(images), 0, "insane values")


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_no_light_is_exactly_black(device, shaders, record, method):
    for scene in (room(lights=(), environment=None), dimmed(0.0)):
        images = render(device, shaders, scene, method)
        brightest = max(float(images[name][..., :3].max()) for name in RADIANCES)
        record("no light", label(method), brightest, 0.0, "radiance")


# A power of two changes no mantissa: images must scale bit by bit. Sums and products
# stay far from the limits of float32 at 2^+-20.
LINEARITY = 1e-6


@pytest.fixture(scope="module")
def base(device, shaders):
    """Return a function that renders the room once for each method."""
    return cache(lambda method: render(device, shaders, room(), method))


@pytest.mark.parametrize("method", METHODS, ids=label)
@pytest.mark.parametrize("exponent", [-20, 20])
def test_images_are_linear_in_the_light(device, shaders, base, record, method, exponent):
    other = render(device, shaders, dimmed(2.0**exponent), method)
    for name in RADIANCES:
        a, b = base(method)[name][..., :3].astype(float), other[name][..., :3] / 2.0**exponent
        gap = float(np.abs(a - b).max() / max(a.mean(), 1e-30))
        record(f"light x 2^{exponent}", label(method), gap, LINEARITY, "relative")


# Float32 sums in another order; the control variate mixes by a visibility that all lights
# share, so that it stays linear. Lights share an atlas of shadow maps: each alone has finer
# ones, and a texel's width of penumbra moves.
SUM_BOUND = {"none": 1e-5, "map": 5e-3}
# The surface cache shares out the shadow rays of a surfel among the lights, and pixels' own rays
# follow the light: each alone has other noise, which many rays keep below this.
CACHE_SUM_BOUND = 5e-3
MANY_RAYS = {
    "surface_cache.light_samples": 64,
    "far_field.pixel_rays": 512,
    "far_field.edge_rays": 512,
}


@pytest.mark.parametrize("shadows", SUM_BOUND)
@pytest.mark.parametrize("method", SCREEN_SPACE, ids=label)
def test_lights_add_up(device, shaders, record, method, shadows):
    """The image of all lights is the sum of the images of each."""
    options = {"images": RADIANCES, "shadows": shadows}
    options |= {"overrides": MANY_RAYS} if method[0] == "gi" else {}
    whole = render(device, shaders, room(), method, **options)
    total = {name: np.zeros_like(whole[name], float) for name in RADIANCES}
    parts = [room(lights=(light,), environment=None) for light in room().lights]
    parts.append(room(lights=()))
    for part in parts:
        # Without an environment, visibility would multiply direct light by default.
        combine = {"combine": "ambient"} if method[0] == "ssao" else {}
        images = render(device, shaders, part, method, **options, **combine)
        for name in RADIANCES:
            total[name] += images[name]
    for name in RADIANCES:
        a, b = whole[name][..., :3].astype(float), total[name][..., :3]
        gap = float(np.abs(a - b).mean() / max(a.mean(), 1e-30))
        case = f"lights add up, shadows {shadows}: {name}"
        is_cached = method[0] == "gi" and name != "direct"
        bound = CACHE_SUM_BOUND if is_cached else SUM_BOUND[shadows]
        record(case, label(method), gap, bound, "rel. mean")


@pytest.mark.parametrize("method", (("bounce", "march"), ("bounce", "rgs09")), ids=label)
def test_one_bounce_never_exceeds_what_senders_have(device, shaders, record, method):
    """Irradiance by solid angle is at most pi times the brightest sender."""
    images = render(device, shaders, room(), method, filter="none")
    senders = (images["direct"] + images["directional"] + images.get("emission", 0.0)).max()
    albedo = 0.8
    ratio = float(images["bounce"].max() / (albedo * senders))
    # The paper's form factor is unbounded but for its clamp: d >= a tenth of R allows
    # A_s / (pi d^2) = 1 / (N 0.01) per sample.
    bound = 1.0 + 1e-5 if method[1] == "march" else 100.0
    record(f"bounce over albedo x sender ({method[1]})", label(method), ratio, bound, "ratio")


@pytest.mark.parametrize("radius", [4.0, 100.0, 1e9, float("inf")])
def test_a_wide_near_field_keeps_the_bounce_of_a_point_light(device, shaders, record, radius):
    """The room is 3 across: a larger R finds the same senders, and none may be dimmed.

    What senders may have is bounded by the scene's lights; a point light's is infinite
    near itself, so that the bound takes a length, which must not grow with R.
    """
    scene = only(PointLight((0.5, 1.0, 0.6), (1, 1, 1)))
    bounces = [
        render(device, shaders, scene, ("bounce", "march"), images=("bounce",), radius=r)["bounce"]
        for r in (3.0, radius)
    ]
    gap = abs(float(bounces[1].mean()) / float(bounces[0].mean()) - 1.0)
    # Longer strides meet what is thin more rarely, or take it for thicker.
    record("bounce within a wide near field", f"R = {radius:g}", gap, 0.05, "rel. mean")

"""Frames in a row: nothing pops, crawls, grows or depends on what was drawn before."""

from __future__ import annotations

import dataclasses
import itertools
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hard_cases.hard_scene import CAMERA, RADIUS, quad, room, sphere
from hard_cases.methods import FEW_TEXELS, METHODS, SCREEN_SPACE, label

from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight
from ssdo_gl.settings import Settings
from ssdo_gl.settings.fields import SettingError

NAMES = ("beauty", "direct", "directional", "bounce", "visibility")
BOUNCE = Settings(
    method="bounce", size=(64, 48), samples=32, steps=8, spp=4, shadow_rays=4, radius=RADIUS,
    overrides=FEW_TEXELS,
)  # fmt: skip
STATM = Path("/proc/self/statm")


def settings_of(method, **changes):
    return dataclasses.replace(BOUNCE, method=method[0], estimator=method[1], **changes)


def shifted(pixels, height):
    """Return the camera, moved sideways by a part of a pixel at its target."""
    position, target = np.array(CAMERA.position), np.array(CAMERA.target)
    distance = np.linalg.norm(target - position)
    footprint = 2.0 * np.tan(np.radians(CAMERA.fov_y) / 2.0) * distance / height
    across = np.cross(target - position, CAMERA.up)
    step = pixels * footprint * across / np.linalg.norm(across)
    return dataclasses.replace(CAMERA, position=tuple(position + step), target=tuple(target + step))


def changes(frames):
    """Yield (name, mean, changes from frame to frame over the mean) of images not all black."""
    for name in NAMES:
        mean = np.mean([frame[name][..., :3].mean() for frame in frames])
        if mean != 0.0:
            pairs = itertools.pairwise(frames)
            yield name, mean, [change(a[name], b[name]) / mean for a, b in pairs]


def change(before, after):
    return float(np.abs(after - before)[..., :3].mean())


# Half of what an eighth of the edges' pixels can change by, each by the image's mean: 2 %.
# References draw their 4 rays anew on as many pixels. The bounce is dark but for the
# creases, some 5 % of the directions: its mean is small beside the steps at their edges,
# and beside a row of senders that comes into view. At worst 9 % (march) and 13 % (rgs09)
# of it change here. The mean step is 6 % and 11 %, unfiltered 9 % and 16 %, with 256
# samples 4.5 % and 8 %, and a third of it at four times the size: the grid of pixels it
# is, and no decision that pops. See test_finer_pixels_and_more_samples_change_less.
MOVE_BOUND = {"screen": 0.03, "reference": 0.03, "bounce": 0.2}


@pytest.mark.parametrize("method", METHODS, ids=label)
def test_sub_pixel_moves_change_little_and_evenly(device, shaders, record, method):
    """Eight moves of an eighth of a pixel.

    An edge passes a pixel's centre once per pixel of movement: of the 10 to 15 % of the
    pixels that lie on edges, an eighth flips at a time. Filtered noise stays with the
    pixel and not with the surface, so that moving under it changes nothing by itself;
    the references' noise is drawn anew where a ray meets another triangle. A method that
    pops would change in one of the steps much more than in the others.
    """
    with Renderer(room(), settings_of(method), device=device, shaders=shaders) as renderer:
        frames = [
            renderer.render(NAMES, camera=shifted(i / 8.0, BOUNCE.size[1])).images for i in range(9)
        ]
    is_screen = method in SCREEN_SPACE
    for name, _, steps in changes(frames):
        kind = "screen" if is_screen else "reference"
        bound = MOVE_BOUND["bounce" if name == "bounce" else kind]
        record(f"1/8 pixel: {name} ({kind})", label(method), max(steps), bound, "rel. change")
        # Edges come in rows of pixels, so that steps are uneven, but not by this much.
        ratio = max(steps) / np.mean(steps)
        record(f"1/8 pixel, popping: {name} ({kind})", label(method), ratio, 3.0, "x mean step")


# What the exact bounce changes by at each of these steps is 3.3 % of its mean (2 x 2048 rays), 1.8
# of it where a pixel shows another surface: 1.1 % of them. Single frames of `bounce` change by
# 5.5 %, averages by 3.1; of `gi`, whose senders have all bounces, 4.9 and 3.5.
WINDOW_BOUND = {"bounce": 0.036, "gi": 0.042}
WINDOW_LEAD = 12


@pytest.mark.parametrize("method", WINDOW_BOUND)
def test_averages_over_frames_change_little(device, shaders, record, method):
    """Eight moves of an eighth of a pixel, once averages over frames are as long as they get."""
    settings = dataclasses.replace(BOUNCE, method=method, samples=64)
    frames = []
    with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
        for i in range(WINDOW_LEAD + 9):
            drawn = renderer.draw(["display", "bounce"], camera=shifted(i / 8.0, BOUNCE.size[1]))
            frames.append(drawn.planes["bounce"].read()[..., :3])
    judged = frames[WINDOW_LEAD:]
    steps = [change(a, b) for a, b in itertools.pairwise(judged)]
    share = float(np.mean(steps) / np.mean(judged))
    record("1/8 pixel, in a window: bounce", method, share, WINDOW_BOUND[method], "rel. change")


# Shares of the change at 48 lines and 32 samples. Four times as many lines leave a quarter
# of what edges change and, filtered over a fixed number of pixels, half of what noise does.
FINER_BOUND = 0.45
# What is no noise stays with more samples: pixels that show another surface, and senders
# that come into view.
MORE_SAMPLES_BOUND = 0.9


@pytest.mark.parametrize("method", [m for m in METHODS if m[0] == "bounce"], ids=label)
def test_finer_pixels_and_more_samples_change_less(device, shaders, record, method):
    """What the bounce changes by when the camera moves belongs to pixels and to noise."""

    def mean_step(height, samples):
        size = (height * 4 // 3, height)
        settings = settings_of(method, size=size, samples=samples)
        with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
            frames = [
                renderer.render(("bounce",), camera=shifted(i / 8.0, height)).images["bounce"]
                for i in range(4)
            ]
        steps = [change(a, b) for a, b in itertools.pairwise(frames)]
        return float(np.mean(steps) / frames[0][..., :3].mean())

    coarse = mean_step(48, 32)
    for case, share, bound in (
        ("4 x the size", mean_step(192, 32) / coarse, FINER_BOUND),
        ("8 x the samples", mean_step(48, 256) / coarse, MORE_SAMPLES_BOUND),
    ):
        record(f"1/8 pixel: bounce at {case}", label(method), share, bound, "of the change")


# What the bounce adds up comes from a twentieth of the directions, 800 in all; those of
# rgs09 have weights of up to 100 times their mean.
TURN_BOUND = {"march": 0.15, "bitmask": 0.15, "rgs09": 0.5}


@pytest.mark.parametrize("method", SCREEN_SPACE, ids=label)
def test_rolling_the_camera_once_around_keeps_the_brightness(device, shaders, record, method):
    """The middle of the picture turns under a fixed pattern of pixels and directions.

    2 000 pixels of 8 directions: the standard error of the means is below a third of the
    bound. The near field reaches from the disc to the frame's border.
    """
    if method[1] == "zbuffer":
        pytest.skip("the seed report's variant prefers the axes of the image")
    size, radius = 72, 0.2
    y, x = np.mgrid[:size, :size] - (size - 1) / 2.0
    disc = np.hypot(x, y) < 0.35 * size
    settings = settings_of(method, size=(size, size), radius=radius, samples=64)
    forward = np.subtract(CAMERA.target, CAMERA.position)
    right = np.cross(forward, CAMERA.up)
    right /= np.linalg.norm(right)
    up = np.cross(right, forward / np.linalg.norm(forward))
    means = {name: [] for name in NAMES}
    with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
        for angle in np.linspace(0.0, 2.0 * np.pi, 13):
            turned = tuple(np.cos(angle) * up + np.sin(angle) * right)
            images = renderer.render(NAMES, camera=dataclasses.replace(CAMERA, up=turned)).images
            for name in NAMES:
                means[name].append(images[name][disc][:, :3].mean())
    for name, values in means.items():
        if np.mean(values) == 0.0:
            continue
        gap = np.ptp(values) / np.mean(values)
        bound, case = 0.02, f"full turn: {name}"
        if name == "bounce":
            bound, case = TURN_BOUND[method[1]], f"{case} ({method[1]})"
        record(case, label(method), float(gap), bound, "rel. range of means")


ORBIT_STEPS = 24
# A sphere of 72 meridians under lights on its axis, on a floor that fills the view: turned
# by 15 degrees about the axis it is the same scene, and each step shows instability alone.
# Rounding decides anew whether a sample hits, for 1e-5 of them, each worth 1/4 of a pixel
# before filtering (see test_scale_and_place); silhouette pixels flip as a whole.
ORBIT_BOUND = 0.005
# What surfaces of the floor hold that send light is kept in squares, which do not turn along: the
# bounce changes by .0064 where those around the sphere are as wide as it, by .0043 where they are
# cut finer. With 6 rays for each pixel, as by default, their noise in each view is .009 and .012.
MANY_RAYS = {"far_field.pixel_rays": 24, "far_field.edge_rays": 64}


def orbit_scene():
    meshes = (quad((-20, 0, 20), (40, 0, 0), (0, 0, -40)), sphere((0, 0.5, 0), 0.5, rings=36))
    lights = (
        PointLight((0.0, 2.0, 0.0), (1.0, 1.0, 1.0)),
        DirectionalLight((0.0, -1.0, 0.0), (0.5, 0.5, 0.5)),
    )
    return room(meshes=meshes, objects=(SceneObject(0, 0), SceneObject(1, 3)), lights=lights)


@pytest.mark.parametrize("method", SCREEN_SPACE, ids=label)
def test_a_full_turn_around_a_round_scene_changes_nothing(device, shaders, record, method):
    """The camera goes once around; no AOV pops on the way, nor has drifted at its end."""
    frames = []
    changed = {"overrides": BOUNCE.overrides | MANY_RAYS} if method[0] == "gi" else {}
    settings = settings_of(method, **changed)
    with Renderer(orbit_scene(), settings, device=device, shaders=shaders) as renderer:
        for angle in np.linspace(0.0, 2.0 * np.pi, ORBIT_STEPS + 1):
            eye = (2.5 * np.sin(angle), 1.6, 2.5 * np.cos(angle))
            camera = Camera(eye, (0.0, 0.3, 0.0), fov_y=40.0)
            frames.append(renderer.render(NAMES, camera=camera).images)
    for name, mean, steps in changes(frames):
        record(f"around a sphere: {name}", label(method), max(steps), ORBIT_BOUND, "rel. change")
        drift = change(frames[0][name], frames[-1][name]) / mean
        record(f"around a sphere, back: {name}", label(method), drift, ORBIT_BOUND, "rel. change")


def resident_bytes():
    return int(STATM.read_text().split()[1]) * 4096


class Usage:
    """What a renderer holds: textures, programs, memory of Python and of the process."""

    def __init__(self, renderer, shaders):
        self.textures = renderer._executor.texture_count
        self.programs = len(shaders._by_name)
        self.python = tracemalloc.get_traced_memory()[0]
        self.resident = resident_bytes() if STATM.exists() else 0


# One full-size texture of four floats kept by each frame would add up to 36 MB in 300
# frames. Below this lie the executor's table of identities (4096 entries of under 1 kB
# before it starts anew) and what allocators keep for themselves.
PYTHON_GROWTH = 6e6
RESIDENT_GROWTH = 1.6e7
# The camera goes to and fro within as many frames: what it sees then, and with it which
# variants of the shaders there are, it has seen before the count begins.
PERIOD = 30
# References have their own textures and sums each frame; rays cost more than frames do.
LONG_RUNS = {
    ("ssao", "hemisphere"): 2000,
    ("ssdo", "march"): 2000,
    ("bounce", "march"): 2000,
    ("reference-near", None): 200,
    ("reference-gi", None): 200,
}


def frames_leave_no_trace(device, record, method, count):
    shaders = ShaderLibrary(device.gl)
    settings = settings_of(method, size=(96, 80), samples=8)
    tracemalloc.start()
    try:
        with Renderer(room(), settings, device=device, shaders=shaders) as renderer:
            before = None
            for i in range(count + PERIOD):
                if i == PERIOD:
                    before = Usage(renderer, shaders)
                camera = shifted(abs(i % PERIOD - PERIOD // 2) / 16.0, 80)
                renderer.render(("beauty",), camera=camera, seconds=i / 60.0)
            after = Usage(renderer, shaders)
    finally:
        tracemalloc.stop()
    case, name = f"{count} frames", label(method)
    record(f"{case}: textures", name, after.textures - before.textures, 0, "more")
    record(f"{case}: programs", name, after.programs - before.programs, 0, "more")
    record(f"{case}: Python memory", name, after.python - before.python, PYTHON_GROWTH, "bytes")
    grown = after.resident - before.resident
    record(f"{case}: process memory", name, grown, RESIDENT_GROWTH, "bytes")


def test_frames_leave_memory_textures_and_programs_flat(device, record):
    frames_leave_no_trace(device, record, ("bounce", "march"), 300)


@pytest.mark.slow
@pytest.mark.parametrize("method", LONG_RUNS, ids=label)
def test_long_runs_leave_memory_textures_and_programs_flat(device, record, method):
    frames_leave_no_trace(device, record, method, LONG_RUNS[method])


def test_the_past_does_not_show(device, shaders, record):
    """A frame after others, other sizes and other settings is the frame on its own."""
    with Renderer(room(), BOUNCE, device=device, shaders=shaders) as renderer:
        first = renderer.render(NAMES).images
        for i in range(6):
            renderer.render(NAMES, camera=shifted(3.0 * i, 48))
        renderer.use(dataclasses.replace(BOUNCE, size=(33, 51), method="ssao", estimator=None))
        renderer.render(("beauty",))
        renderer.use(BOUNCE)
        again = renderer.render(NAMES).images
    for name in NAMES:
        gap = float(np.abs(again[name] - first[name]).max())
        record("the same frame after others", name, gap, 0.0)


def test_resizing_again_and_again(device, shaders, record):
    """As a window does while its border is dragged; textures of old sizes are freed."""
    # A minimised window has no size at all: the window skips such frames, and settings
    # refuse them.
    for size in ((0, 0), (0, 48), (64, 0)):
        with pytest.raises(SettingError):
            dataclasses.replace(BOUNCE, size=size).checked()
    sizes = [(40 + 7 * i % 53, 30 + 11 * i % 41) for i in range(16)]
    with Renderer(room(), BOUNCE, device=device, shaders=shaders) as renderer:
        renderer.render(("beauty",))
        count = renderer._executor.texture_count
        for size in [*sizes, (1, 1), (200, 1), (1, 200), BOUNCE.size]:
            renderer.use(dataclasses.replace(BOUNCE, size=size))
            image = renderer.render(("beauty",)).images["beauty"]
            assert image.shape == (size[1], size[0], 4) and np.all(np.isfinite(image))
        more = renderer._executor.texture_count - count
    record("20 sizes: textures", "bounce", more, 0, "more")


def test_a_lost_device_is_replaced(device, record):
    """Releasing the device and starting over gives the same bytes; other devices stay."""
    images = []
    for _ in range(3):
        with Renderer(room(), BOUNCE, backend=device.backend) as renderer:
            images.append(renderer.render(("beauty",)).images["beauty"])
    assert np.all(np.isfinite(images[0]))
    gap = max(float(np.abs(image - images[0]).max()) for image in images[1:])
    record("device made anew", "bounce", gap, 0.0)
    device.activate()
    with Renderer(room(), BOUNCE, device=device) as renderer:
        beauty = renderer.render(("beauty",)).images["beauty"]
    record("device beside others", "bounce", float(np.abs(beauty - images[0]).max()), 0.0)

"""Sums of many frames: one fault in one of them stays where it is, and passes.

A history outlives its frames. What enters it once without being a number would stay in
every picture that is made of it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from gpu.image_texture import texture_from_image
from hard_cases.hard_scene import CAMERA
from hard_cases.poison import FAULT, SIZE, noise
from passes.estimator_cases import picture_frame
from program_of_text import fullscreen_source

from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.graph.render_pass import PassContext
from ssdo_gl.images.average import ImageAverage
from ssdo_gl.images.display import ColorMapping
from ssdo_gl.passes.rays.accumulate import (
    MIN_SAMPLES_TO_STOP,
    Schedule,
    SumOutput,
    Sums,
    accumulate,
)
from ssdo_gl.passes.rays.ray_libraries import stream_of
from ssdo_gl.render_result import Drawing, Plane
from ssdo_gl.settings import Settings
from ssdo_gl.window.live.live_image import FrameRequest, LiveImage

POISONS = {"NaN": np.nan, "Inf": np.inf, "-Inf": -np.inf, "1e30": 1e30}
# Sixteen additions in float32 and a quotient, of values up to 1: a rounding each.
SUM_ROUNDING = 1e-6
FRAMES = 16
MANY = 100_000
# While a sum of n equal terms lies between two powers of two, each addition rounds the
# same way, by at most half an ULP of the sum so far, 6e-8 of it, and the sum so far is
# half of the whole on average: up to 3e-8 n in all. For 1e5 that is 3e-3, the noise that
# so many samples leave of what one of them varies by.
ROUNDING_PER_FRAME = 3e-8


class Film:
    """Stands in for the renderer: frames that are known."""

    def __init__(self, gl, frames):
        self._textures = [texture_from_image(gl, frame) for frame in frames]
        self._next = 0

    def use(self, settings):
        """Every setting shows the same film."""

    def draw(self, names, **options):
        texture = self._textures[self._next % len(self._textures)]
        self._next += 1
        planes = dict.fromkeys(names, Plane(texture))
        return Drawing(planes, None, tuple, (), 1e3, {})

    def release(self):
        for texture in self._textures:
            texture.release()


def run_film(device, shaders, frames, count=None, settings=None):
    """Yield the window's average after each frame."""
    image = LiveImage(Film(device.gl, frames), device, shaders)
    request = FrameRequest("bounce", ColorMapping.RADIANCE, CAMERA, settings or Settings(size=SIZE))
    for i in range(count or len(frames)):
        assert image.update(request)
        if count is None or i == count - 1:
            yield read_texture(image.plane.texture).astype(np.float64) * image.weight
    image.release()


@pytest.mark.parametrize("poison", POISONS)
@pytest.mark.parametrize("when", [0, 1, 7], ids="frame {}".format)
def test_one_faulty_frame_passes(device, shaders, record, poison, when):
    """The window's average: only the texel is at fault, and only until the next frame."""
    frames = [noise(4, seed=i) for i in range(FRAMES)]
    sound = list(run_film(device, shaders, frames))
    faulty = [frame.copy() for frame in frames]
    faulty[when][FAULT] = POISONS[poison]
    found = list(run_film(device, shaders, faulty))
    changed = 0
    for a, b in zip(sound, found, strict=True):
        differs = np.any(a != b, axis=-1)
        differs[FAULT] = False
        changed += int(differs.sum())
    record("faulty frame: other texels", f"{poison} in the window", changed, 0, "texels changed")
    # The frame that holds it shows it, if there is nothing else to show.
    for i in range(1 if when == 0 else 0, FRAMES):
        # What replaces the fault: the mean before it, or else the frame after it.
        weights = np.ones(i + 1)
        if when == 0:
            weights[1] = 2.0
        elif when <= i:
            weights[:when] += 1.0 / when
        weights[when : when + 1] = 0.0
        expected = weights @ [frame[FAULT] for frame in frames[: i + 1]] / (i + 1)
        gap = float(np.abs(found[i][FAULT] - expected).max())
        gap = gap if np.isfinite(gap) else np.inf
        record("faulty frame: its texel", f"{poison} in the window", gap, SUM_ROUNDING, "off")


def history_keeps_fault(device, shaders):
    """Values that are none in the window's average, three sound frames after one of them."""
    frames = [noise(4, seed=i) for i in range(4)]
    frames[0][FAULT] = np.nan
    *_, last = run_film(device, shaders, frames)
    return float((~np.isfinite(last)).sum()), 0.0


def test_a_texel_that_never_is_a_number_still_shows(device, shaders):
    """What is always at fault must not look sound."""
    frames = [noise(4, seed=i) for i in range(4)]
    for frame in frames:
        frame[FAULT] = np.nan
    *_, last = run_film(device, shaders, frames)
    assert np.all(np.isnan(last[FAULT]))
    assert np.isfinite(last).sum() == last.size - 4


# Samples that are known, with a fault in one draw of one half.
KNOWN_SAMPLES = """#version 330 core
#include "lib/random.glsl"
uniform sampler2D t_value;
uniform sampler2D t_fault;
uniform uint u_faulty_stream;
uniform float u_noise;
layout(location = 0) out vec4 o_sum;
void main()
{
    ivec2 texel = ivec2(gl_FragCoord.xy);
    float u = random_2d(u_first_sample, u_stream, 0u, true).x;
    vec4 value = texelFetch(t_value, texel, 0) * (1.0 + u_noise * (u - 0.5));
    vec4 fault = texelFetch(t_fault, texel, 0);
    bool is_faulty = u_first_sample == 2u && u_stream == u_faulty_stream && fault.a != 0.0;
    o_sum = float(u_sample_count) * (is_faulty ? fault : value);
}
"""


def run_sums(device, shaders, value, schedule, fault=None, spread=1.0):
    """Return the mean that `accumulate` makes of known samples, and its statistics."""
    size = value.shape[1], value.shape[0]
    fault = np.zeros_like(value) if fault is None else fault
    gl = device.gl
    depth = np.ones((*value.shape[:2], 1))
    images = {"value": value, "fault": fault, "z_vs": depth}
    textures = {name: texture_from_image(gl, image) for name, image in images.items()}
    result = make_texture(gl, size, 4, "f4")
    target = make_framebuffer(gl, [result])
    frame = picture_frame(size, 0.4)
    context = PassContext(gl, shaders, None, frame, {"z_vs": textures["z_vs"]}, target)
    program = fullscreen_source(shaders, KNOWN_SAMPLES)
    statistics = accumulate(
        context,
        program,
        {"u_noise": spread, "u_faulty_stream": stream_of(frame.seed, 0)},
        {"t_value": textures["value"], "t_fault": textures["fault"]},
        Sums(gl, size, 1),
        [SumOutput("mean", 4)],
        schedule,
        "sums",
    )
    mean = read_texture(result).astype(np.float64)
    for item in (target, result, *textures.values()):
        item.release()
    return mean, statistics


@pytest.mark.parametrize("poison", POISONS)
def test_one_faulty_sample_stays_in_its_pixel(device, shaders, record, poison):
    """The references' sums; nor may it keep the other pixels from being measured."""
    value = noise(4)
    fault = np.zeros_like(value)
    fault[FAULT] = POISONS[poison]
    schedule = Schedule(spp=64, rays_per_sample=400, most_per_draw=1, max_error=0.1)
    (mean, statistics), (found, measured) = (
        run_sums(device, shaders, value, schedule, image) for image in (None, fault)
    )
    assert np.all(np.isfinite(mean))
    differs = np.any(found != mean, axis=-1)
    if poison == "1e30":
        # As bright as that, it is the image's mean, and its noise is all there is.
        assert measured["stopped_by"] == "spp"
        mean = run_sums(device, shaders, value, dataclasses.replace(schedule, max_error=None))[0]
        differs = np.any(found != mean, axis=-1)
    else:
        assert statistics["stopped_by"] == measured["stopped_by"] == "max_error"
        assert measured["spp"] == statistics["spp"] >= 2 * MIN_SAMPLES_TO_STOP
        for key in ("standard_error", "relative_standard_error"):
            # One pixel of 384 less.
            assert measured[key]["mean"] == pytest.approx(statistics[key]["mean"], rel=0.05)
    differs[FAULT] = False
    record("faulty sample: other pixels", f"{poison} in the sums", int(differs.sum()), 0, "changed")


def test_no_pixel_with_a_number_has_no_error(device, shaders):
    value = np.full_like(noise(4), np.nan)
    schedule = Schedule(spp=4, rays_per_sample=400, most_per_draw=1)
    _, statistics = run_sums(device, shaders, value, schedule)
    assert statistics["standard_error"] == {"mean": None}


@pytest.mark.parametrize("poison", POISONS)
def test_one_faulty_frame_of_an_average_stays_in_its_pixel(record, poison):
    """The average of `antialias` frames."""
    frames = [noise(4, seed=i).astype(np.float32) for i in range(4)]
    averages = []
    for fault in (None, POISONS[poison]):
        average = ImageAverage()
        for i, frame in enumerate(frames):
            image = frame.copy()
            if i == 2 and fault is not None:
                image[FAULT] = fault
            average.add({"bounce": image})
        averages.append(average.images()["bounce"])
    differs = np.any(averages[0] != averages[1], axis=-1)
    differs[FAULT] = False
    record("faulty frame: other texels", f"{poison}, antialias", int(differs.sum()), 0,
           "texels changed")  # fmt: skip


# Values whose last bits are set, as those of most images are, from dark to blinding.
LEVELS = np.array([0.1, 1.0 / 3.0, 1e-8, 0.7e8])


def many_frames(device, shaders, record, count):
    """The window at rest on a reference, one sample per frame."""
    settings = Settings(method="reference-near", size=(4, 4), spp=count)
    rng = np.random.default_rng(2)
    for kind, spread in (("equal frames", 0.0), ("noise", 1.0)):
        factors = 1.0 + spread * (rng.uniform(0.0, 1.0, (64, 4, 4, 1)) - 0.5)
        frames = np.float32(factors * LEVELS)
        *_, mean = run_film(device, shaders, frames, count, settings)
        exact = np.mean([frames[i % 64] for i in range(count)], axis=0, dtype=np.float64)
        error = np.abs(mean / exact - 1.0).max()
        error = error if np.isfinite(error) else np.inf
        record(
            f"{count} frames: {kind}",
            "window",
            float(error),
            ROUNDING_PER_FRAME * count,
            "relative",
        )


def many_samples(device, shaders, record, count):
    """The references' sums, in as many draws as there are samples."""
    schedule = Schedule(spp=count, rays_per_sample=400, most_per_draw=1)
    value = np.tile(LEVELS, (4, 4, 1))
    mean, statistics = run_sums(device, shaders, value, schedule, spread=0.0)
    assert statistics["spp"] == count
    error = np.abs(mean / np.float32(value) - 1.0).max()
    error = error if np.isfinite(error) else np.inf
    # Half of them in each sum.
    bound = ROUNDING_PER_FRAME * count / 2.0
    record(f"{count} draws: equal samples", "sums", float(error), bound, "relative")


def test_thousands_of_frames_keep_their_mean(device, shaders, record):
    many_frames(device, shaders, record, 2000)
    many_samples(device, shaders, record, 2000)


@pytest.mark.slow
def test_a_hundred_thousand_frames_keep_their_mean(device, shaders, record):
    many_frames(device, shaders, record, MANY)
    many_samples(device, shaders, record, MANY)

"""One faulty texel among sound ones: what must stay of an image when it is poisoned."""

from __future__ import annotations

import numpy as np
from passes.estimator_cases import inputs_of, picture_frame, tilted_plane
from passes.pass_harness import run_pass

from ssdo_gl.effects.bounce import BouncePass, BounceSettings
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass, EdgeAwareFilterSettings, Signal

SIZE = (24, 16)
TAN_HALF = (0.6, 0.4)
# Row and column of the faulty texel: even, so that an estimator of half size has it, too.
FAULT = (8, 10)
POISONS = {"NaN": np.nan, "Inf": np.inf, "-Inf": -np.inf, "1e30": 1e30, "-1": -1.0}


def sheet():
    """Return a picture of a plane at 45 degrees."""
    return tilted_plane(45.0, SIZE, TAN_HALF)


def noise(channels, scale=1, seed=1):
    """Return values between 0 and 1, row 0 at the top."""
    shape = (SIZE[1] // scale, SIZE[0] // scale, channels)
    return np.random.default_rng(seed).uniform(0.0, 1.0, shape)


def filtered(gl, shaders, value, *, kind, picture, is_visibility, holds_z, **settings):
    """Return what the filter makes of `value`; depths are filled in where it holds them."""
    scale = SIZE[0] // value.shape[1]
    if holds_z:
        # Pixel p of a half-size image sits on texel 2 p, counted from the bottom.
        z = picture.z[::scale, ::scale][::-1][..., None]
        value = np.concatenate([value[..., : 1 if is_visibility else 3], z], -1)
    item = EdgeAwareFilterPass(
        "filter",
        EdgeAwareFilterSettings(filter=kind, **settings),
        Signal("raw", "smooth", is_visibility, holds_z),
    )
    images = inputs_of(picture)
    inputs = {"raw": value, "z_vs": images["z_vs"], "normals_vs": images["normals_vs"]}
    return run_pass(gl, shaders, item, picture_frame(SIZE, TAN_HALF[1]), inputs)["smooth"]


def bounced(gl, shaders, senders, picture, *, bound=np.inf, **settings):
    """Return the bounce from `senders` (radiance), unfiltered."""
    settings = BounceSettings(**{"radius": 2.0, "samples": 64, "steps": 8, **settings})
    images = inputs_of(picture)
    inputs = {"sender_radiance": senders, **{k: images[k] for k in ("z_vs", "normals_vs")}}
    item = BouncePass(settings, sender_bound=bound)
    return run_pass(gl, shaders, item, picture_frame(SIZE, TAN_HALF[1]), inputs)["bounce_raw"]


def filter_takes_poison(device, shaders):
    """Values outside of what sound texels hold, after filtering with one that is not."""
    value = noise(4)
    value[FAULT] = np.nan
    smooth = filtered(
        device.gl, shaders, value, kind="edge", picture=sheet(),
        is_visibility=False, holds_z=False,
    )  # fmt: skip
    return float((~((smooth >= 0.0) & (smooth <= 1.0 + 1e-6))).sum()), 0.0


def filter_mixes_depths(device, shaders):
    """What crosses a silhouette between a near white and a far black sheet: nothing.

    At a depth ratio of 4 and 3 / 4 of the width away the tangent planes lie some 20
    footprints apart: weights of 1 / (1 + 40^2)^2 are below 1e-6.
    """
    picture = sheet()
    half = SIZE[0] // 2
    picture.z[:, :half] *= 0.25
    value = np.zeros((*picture.z.shape, 4))
    value[:, :half] = 1.0
    smooth = filtered(
        device.gl, shaders, value, kind="edge", picture=picture,
        is_visibility=False, holds_z=False,
    )  # fmt: skip
    return float(np.abs(smooth - value).max()), 1e-3

"""Runs the bounce on pictures made by hand, such as a lit corner."""

from __future__ import annotations

import math

import numpy as np
from passes.estimator_cases import (
    corner,
    picture_frame,
    run_on,
)

from ssdo_gl.effects.bounce import BouncePass

ESTIMATORS = ("march", "rgs09", "bitmask")
CORNER_SIZE = (160, 96)
CORNER_TAN = 0.25
CORNER_RADIUS = 0.4


def run(gl, shaders, picture, settings, sent, *, has_back=False, bound=math.inf, seed=0):
    size = picture.z.shape[1], picture.z.shape[0]
    frame = picture_frame(size, picture.tan_half_fov[1], near=picture.near, seed=seed)
    render_pass = BouncePass(settings, sender_bound=bound, has_back_layer=has_back)
    radiance = np.concatenate([sent, np.ones((*sent.shape[:2], 1))], -1)
    return run_on(gl, shaders, render_pass, frame, picture, {"sender_radiance": radiance})


def the_corner():
    frame = picture_frame(CORNER_SIZE, CORNER_TAN)
    return corner(CORNER_SIZE, frame.view.tan_half_fov)


def ones(picture, color=(1.0, 1.0, 1.0)):
    return np.ones((*picture.z.shape, 1)) * np.asarray(color)


def colors(picture, seed=11):
    return np.random.default_rng(seed).random((*picture.z.shape, 3))

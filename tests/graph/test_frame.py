"""The view of a frame: camera-relative in float64, jitter that moves the sample only."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.graph.frame import FrameView


def view(position=(0.0, 0.0, 0.0), rotation=None, **changes):
    values = {
        "size": (64, 36),
        "position_ws": np.array(position),
        "view_from_world": np.eye(3) if rotation is None else rotation,
        "tan_half_fov": (0.8, 0.45),
        "near": 0.1,
        "far": 100.0,
    }
    return FrameView(**{**values, **changes})


def pixel_of(frame, point_vs):
    clip = frame.clip_from_view @ np.append(point_vs, 1.0)
    ndc = clip[:2] / clip[3]
    return (ndc * 0.5 + 0.5) * frame.size


def test_a_jittered_ray_lands_on_the_pixel_centre():
    """A point seen through (pixel centre + jitter) is rasterised at the pixel centre."""
    jitter_px = (0.25, -0.375)
    frame = view(jitter_px=jitter_px)
    pixel = np.array([40.5, 10.5])
    ndc = 2.0 * (pixel + jitter_px) / frame.size - 1.0
    z = 7.0
    point_vs = np.array([ndc[0] * 0.8 * z, ndc[1] * 0.45 * z, -z])
    assert pixel_of(frame, point_vs) == pytest.approx(pixel, abs=1e-12)


def test_the_key_changes_with_every_part():
    base = view()
    others = [
        view(position=(1e-9, 0, 0)),
        view(size=(65, 36)),
        view(jitter_px=(0.1, 0.0)),
        view(near=0.2),
        view(rotation=np.diag([1.0, -1.0, -1.0])),
    ]
    assert view().key() == base.key()
    assert all(other.key() != base.key() for other in others)

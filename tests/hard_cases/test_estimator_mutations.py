"""Every estimator, broken on purpose: its float64 twin notices."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hard_cases.test_mutations import Mutation, mutated
from oracle import slices
from passes.estimator_cases import (
    covered_texels,
    expected_visibility,
    picture_frame,
    random_picture,
    run_on,
    run_visibility,
    twin_of,
)

from ssdo_gl.effects.bounce import BouncePass, BounceSettings
from ssdo_gl.effects.ssao import SsaoSettings
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.settings.estimators import ESTIMATORS

SIZE, TAN_Y = (48, 36), 0.5
# As in tests/effects/test_ssao.py and test_bounce.py.
BOUND = 4e-6
BOUNCE_BOUND = math.pi * 4e-6


def noise():
    """Return a picture each texel of which is a surface of its own, with backs, and its frame."""
    frame = picture_frame(SIZE, TAN_Y, seed=7)
    return random_picture(3, SIZE, frame.view.tan_half_fov, True), frame


def visibility_differs(device, shaders, estimator):
    """Largest difference of visibility from the twin, where float32 decides as float64."""
    picture, frame = noise()
    settings = SsaoSettings(estimator=estimator, radius=0.8, samples=24, steps=4)
    found = run_visibility(device.gl, shaders, picture, settings, frame)
    texel = covered_texels(picture)
    expected, unsure = expected_visibility(picture, texel, texel, twin_of(settings, frame, True))
    return float(np.abs(found[texel[:, 1], texel[:, 0]] - expected)[~unsure].max()), BOUND


def light_differs(device, shaders, estimator):
    """Largest difference of a bitmask's bounce from the twin's, of senders of all colours."""
    picture, frame = noise()
    settings = BounceSettings(
        estimator=estimator, radius=0.8, samples=24, steps=4, hidden_senders=0.25
    )
    sent = np.random.default_rng(11).random((*picture.z.shape, 3))
    item = BouncePass(settings, sender_bound=math.inf, has_back_layer=True)
    radiance = np.concatenate([sent, np.ones((*sent.shape[:2], 1))], -1)
    image = run_on(device.gl, shaders, item, frame, picture, {"sender_radiance": radiance})
    texel = covered_texels(picture)
    r, sectors = slices.find_sectors(picture, texel, texel, twin_of(settings, frame, True))
    expected = slices.bounce_sectors(picture, r, sectors, sent, 0.25)
    sure = ~sectors.unsure.any(1)
    gap = np.abs(image[texel[:, 1], texel[:, 0], :3] - expected)
    return float(gap[sure].max()), BOUNCE_BOUND


# What an estimator's own file says -> what a fault would make of it.
FAULTS = {
    "march": (
        ("cosine_hemisphere(u)", "uniform_hemisphere(u)"),
        ("d.w_vs, u_radius,", "d.w_vs, 0.9 * u_radius,"),
        ("d.jitter, steps", "0.5, steps"),
    ),
    "rgs09": (
        ("uniform_hemisphere(u)", "cosine_hemisphere(u)"),
        ("local.z * 2.0", "1.0"),
        ("* d.jitter, false", "* sqrt(d.jitter), false"),
        ("false)", "true)"),
    ),
    "hemisphere": (
        ("cosine_hemisphere(u)", "uniform_hemisphere(u)"),
        ("sqrt(d.jitter)", "d.jitter"),
        ("true)", "false)"),
    ),
    "zbuffer": (
        ("z < r.z_vs * (1.0 - ZBUFFER_BIAS)", "z < r.z_vs"),
        ("texel == inside && ", ""),
        ("z > 0.0 && ", ""),
        ("* 2.0 - 1.0) * u_box_px", "- 0.5) * u_box_px"),
        ("floor(offset + 0.5)", "floor(offset)"),
    ),
    "gtao": (
        ("blocked += slice.normal_length", "blocked += 1.0"),
        ("-slice.normal_angle", "slice.normal_angle"),
        ("along, view, r.normal_vs", "along, view, r.geometric_vs"),
        ("min(horizon, end)", "horizon"),
        ("-along, -", "along, -"),
        ("PI * slice_turn", "2.0 * PI * slice_turn"),
        ("u.z)", "u.y)"),
    ),
    "hbao": (
        ("2.0 * PI * slice_turn", "PI * slice_turn"),
        ("= -sin(", "= sin("),
        ("jitter, tangent) - tangent", "jitter, NO_ELEVATION) - NO_ELEVATION"),
        ("sample_point(r, i).y", "sample_point(r, i).x"),
    ),
    "sao": (
        (" && is_above(t, vec2(inside) + 0.5, z)", ""),
        ("window * window", "window"),
        ("left * left", "left"),
        ("d2 + peak * peak", "d2"),
        ("share * share * radius_px", "share * radius_px"),
        ("float(i) * GOLDEN_TURN", "float(i) * 0.5"),
    ),
    "bitmask": (
        ("sector_weight(s) * float(bit", "float(bit"),
        ("u_front_slack * stride", "0.0 * stride"),
        ("? farther : own", "? own : own"),
        ("min(solid_end(t, solid) - l.z, within.y)", "within.y"),
        ("max(solid.x - l.z, within.x)", "(solid.x - l.z)"),
        ("hidden |= found", "hidden = found"),
        ("fract(jitter + 0.5)", "jitter"),
    ),
}  # fmt: skip
# Faults of what estimators share: file, text, what a fault makes of it, and who shares it.
POINTS, SLICES = ("rgs09", "hemisphere"), ("gtao", "hbao", "bitmask")
SHARED = (
    ("screen_space/occlusion.glsl", "plane_height(t.rate, px, z) > t.lowest", "true",
     ("march", *POINTS, *SLICES, "sao")),
    ("screen_space/occlusion.glsl", "? solid.y :", "? solid.x + t.thickness :",
     ("march", "hemisphere", "bitmask")),
    ("screen_space/point_samples.glsl", "&& z_s > solid.x", "", POINTS),
    ("screen_space/march.glsl", "i < count - 1 ?", "i < count ?", ("march",)),
    ("screen_space/march.glsl", "vec2(u_front_slack, u_back_slack)", "vec2(0.0)", ("march",)),
    ("screen_space/slices.glsl", "distance <= u_radius && ", "", ("gtao", "hbao")),
    ("screen_space/slices.glsl", "set << 28", "set << 27", SLICES),
    ("screen_space/slices.glsl", "mix(k.first, 1.0,", "mix(0.0, 1.0,", SLICES),
)  # fmt: skip
LIGHT_FAULTS = (
    ("bit_count(found & ~hidden)", "bit_count(found)"),
    ("share_sent(t.position_vs, texel) * ", ""),
    ("sum += sector_weight(s) * sent", "sum += sent"),
    ("return PI * estimator_sector_share", "return estimator_sector_share"),
)


def notices(device, shaders, record, folder, estimator, edit, check):
    """Hold sound and broken shaders to the twin; `edit` is (file, old text, new)."""
    file, old, new = edit
    error, bound = check(device, shaders, estimator)
    broken = ShaderLibrary(device.gl, mutated(Mutation({file: ((old, new),)}, check), folder))
    wrong, _ = check(device, broken, estimator)
    record(f"fault noticed: {estimator}", check.__name__, error, bound)
    assert not wrong <= 100.0 * bound, f"{old!r} as {new!r} goes unnoticed: {wrong:.3g}"


def test_every_estimator_is_broken():
    assert set(FAULTS) == set(ESTIMATORS)


CASES = [
    *((name, (f"estimators/{name}.glsl", *edit)) for name in FAULTS for edit in FAULTS[name]),
    *((name, edit) for *edit, names in SHARED for name in names),
]


@pytest.mark.parametrize(
    "estimator, edit", CASES, ids=[f"{name}-{number}" for number, (name, _) in enumerate(CASES)]
)
def test_a_fault_of_an_estimator_is_noticed(device, shaders, record, tmp_path, estimator, edit):
    notices(device, shaders, record, tmp_path, estimator, edit, visibility_differs)


@pytest.mark.parametrize("number", range(len(LIGHT_FAULTS)))
def test_a_fault_of_a_bitmask_s_light_is_noticed(device, shaders, record, tmp_path, number):
    edit = ("estimators/bitmask.glsl", *LIGHT_FAULTS[number])
    notices(device, shaders, record, tmp_path, "bitmask", edit, light_differs)

"""One faulty texel stays one faulty texel; silhouettes and sky stay out of averages.

Without care, one NaN in an estimator's image becomes a black square of (2 r + 1)^2
pixels: the complaint that users of such effects file most often.
"""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.poison import FAULT, POISONS, SIZE, bounced, filtered, noise, sheet
from passes.estimator_cases import corner, inputs_of, picture_frame, tilted_plane
from passes.pass_harness import run_pass

from ssdo_gl.passes.composite import CompositePass
from ssdo_gl.passes.edge_aware_filter import EdgeAwareFilterPass, EdgeAwareFilterSettings, Signal
from ssdo_gl.passes.sender_radiance import SenderRadiancePass
from ssdo_gl.passes.terms import SenderTerms
from ssdo_gl.passes.tone_map import CURVES, ToneMapPass, ToneMapSettings

KINDS = ("edge", "naive", "none")
SCALES = {"full size": 1, "half size": 2}
# What an estimator's image holds: (is_visibility, holds_z).
FORMS = {
    "visibility": (True, False),
    "visibility and z": (True, True),
    "irradiance and visibility": (False, False),
    "irradiance and z": (False, True),
}
# A weighted mean of equal numbers: a dozen roundings of 6e-8.
MEAN_ROUNDING = 1e-6
LEVEL = 0.5


def channels_of(form):
    """Return the channels of an image of this form that hold a value."""
    is_visibility, holds_z = FORMS[form]
    return range(1 if is_visibility else 3 if holds_z else 4)


def smooth_of(gl, shaders, value, form, kind, picture):
    """Return what the filter gives, the channels that mean something."""
    is_visibility, holds_z = FORMS[form]
    smooth = filtered(
        gl, shaders, value, kind=kind, picture=picture,
        is_visibility=is_visibility, holds_z=holds_z,
    )  # fmt: skip
    return smooth[..., list(channels_of(form))]


def is_at_fault(scale):
    """Return a mask of the frame's pixels that show the faulty texel itself."""
    mask = np.zeros((SIZE[1], SIZE[0]), bool)
    row, column = (scale * (index // scale) for index in FAULT)
    mask[row : row + scale, column : column + scale] = True
    return mask


@pytest.mark.parametrize("poison", POISONS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", SCALES)
def test_a_faulty_texel_is_left_out(gl, shaders, record, poison, kind, size):
    """Among equal values, the filter must give that value: the fault has no weight.

    Unfiltered, the fault has no neighbours to be replaced by, and becomes neutral.
    """
    scale = SCALES[size]
    for form in FORMS:
        for channel in [[c] for c in channels_of(form)] + [list(channels_of(form))]:
            value = np.full_like(noise(4, scale), LEVEL)
            value[FAULT[0] // scale, FAULT[1] // scale, channel] = POISONS[poison]
            smooth = smooth_of(gl, shaders, value, form, kind, sheet())
            gap = np.abs(smooth - LEVEL).max(axis=-1)
            if kind == "none":
                assert np.all(np.isfinite(smooth))
                gap[is_at_fault(scale)] = 0.0
            error = np.where(np.isfinite(gap), gap, np.inf).max()
            record(f"poisoned texel, {form}", f"{kind}, {size}", error, MEAN_ROUNDING, "leaked")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", SCALES)
def test_a_faulty_depth_beside_a_value_is_left_out(gl, shaders, record, kind, size):
    """The depth that an image carries beside its value decides weights, too."""
    if kind == "none":
        pytest.skip("reads no neighbour's depth")
    scale = SCALES[size]
    for poison, fault in POISONS.items():
        picture = sheet()
        # Only the carried depth is at fault: the G-buffer's own is read apart.
        value = np.full((SIZE[1] // scale, SIZE[0] // scale, 4), LEVEL)
        value[..., 3] = picture.z[::scale, ::scale][::-1]
        value[FAULT[0] // scale, FAULT[1] // scale] = [1.0, 1.0, 1.0, fault]
        smooth = run_with_depths(gl, shaders, value, kind, picture)
        gap = np.abs(smooth - LEVEL)
        # The tap's plane lies absurdly far off: its weight is 1 / (1 + x^2)^2.
        record(f"poisoned depth, {poison}", f"{kind}, {size}", gap.max(), MEAN_ROUNDING, "leaked")


def run_with_depths(gl, shaders, value, kind, picture):
    settings = EdgeAwareFilterSettings(filter=kind)
    item = EdgeAwareFilterPass("f", settings, Signal("raw", "r", holds_z=True))
    images = inputs_of(picture)
    inputs = {"raw": value, "z_vs": images["z_vs"], "normals_vs": images["normals_vs"]}
    return run_pass(gl, shaders, item, picture_frame(SIZE, 0.4), inputs)["r"][..., :3]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", SCALES)
@pytest.mark.parametrize("column", [11, 12])
def test_silhouettes_do_not_mix_depths(gl, shaders, record, kind, size, column):
    """A white sheet before a black one at twice the depth, to either side of an edge.

    At half size a pixel's receiver may lie on the other side of the edge; the upsampling
    then takes the neighbours that lie on this one.
    """
    scale = SCALES[size]
    if kind == "none" and scale == 2:
        pytest.skip("copies the nearest value, whatever it belongs to")
    picture = tilted_plane(20.0, SIZE, (0.6, 0.4))
    picture.z[:, :column] *= 0.5
    exact = np.zeros((SIZE[1], SIZE[0], 1))
    exact[:, :column] = LEVEL
    for form in FORMS:
        value = np.repeat(exact[::-1][::scale, ::scale][::-1], 4, axis=-1)
        smooth = smooth_of(gl, shaders, value, form, kind, picture)
        # A tap a few pixels away, half the depth off, stands a dozen footprints from the
        # plane: its weight is (1 + 24^2)^-2 = 3e-6, beside at least 1e-3 at half size.
        gap = np.abs(smooth - exact).max()
        record(f"silhouette, {form}", f"{kind}, {size}", gap, 5e-3 * scale * LEVEL, "leaked")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", SCALES)
def test_sky_is_neutral_and_stays_out_of_averages(gl, shaders, record, kind, size):
    scale = SCALES[size]
    picture = sheet()
    picture.z[:, : SIZE[0] // 2] = 0.0
    is_sky = picture.z[::-1] == 0.0
    for form in FORMS:
        value = np.full_like(noise(4, scale), LEVEL)
        # Whatever an estimator may leave on the sky.
        value[:, : SIZE[0] // 2 // scale] = 0.9
        smooth = smooth_of(gl, shaders, value, form, kind, picture)
        neutral = {"visibility": [1.0], "visibility and z": [1.0]}.get(form)
        if neutral is None:
            neutral = [0.0, 0.0, 0.0, 1.0][: smooth.shape[-1]]
        assert np.all(smooth[is_sky] == neutral), "background must be neutral"
        gap = np.abs(smooth[~is_sky] - LEVEL).max()
        record(f"beside the sky, {form}", f"{kind}, {size}", gap, MEAN_ROUNDING, "leaked")


@pytest.mark.parametrize("poison", POISONS)
@pytest.mark.parametrize("estimator", ["march", "rgs09", "bitmask"])
def test_a_faulty_sender_sends_nothing(gl, shaders, record, poison, estimator):
    """In all channels or one; what is only bright sends what the bound lets through."""
    picture = corner(SIZE, (0.6, 0.4))
    bound = 5.0
    # A whole row, so that many receivers meet it.
    for channel in ([0, 1, 2], [0], [2]):
        senders = np.ones((SIZE[1], SIZE[0], 4))
        senders[FAULT[0], :, channel] = POISONS[poison]
        expected = np.ones_like(senders)
        expected[FAULT[0]] = 0.0
        if poison == "1e30":
            expected[FAULT[0], :, :3] = 5e-30
            expected[FAULT[0], :, channel] = bound
        found, exact = (
            bounced(gl, shaders, image, picture, estimator=estimator, bound=bound)
            for image in (senders, expected)
        )
        gap = np.abs(found - exact)[..., :3].max() / exact[..., :3].max()
        error = gap if np.isfinite(gap) else np.inf
        # 1e30 is scaled to the bound by a quotient of its own: a few roundings.
        record(f"poisoned sender: {poison}", estimator, error, MEAN_ROUNDING, "relative")


TERMS = ("emission", "direct_irradiance", "directional_irradiance")


@pytest.mark.parametrize("poison", POISONS)
@pytest.mark.parametrize("name", TERMS)
def test_texel_by_texel_passes_keep_faults_where_they_are(gl, shaders, record, poison, name):
    images = {"z_vs": sheet().z[::-1][..., None], "normals_vs": noise(4, seed=9)}
    images |= {term: noise(4, seed=i) for i, term in enumerate((*TERMS, "albedo"))}
    frame = picture_frame(SIZE, 0.4)
    passes = {
        "sender_radiance": SenderRadiancePass(SenderTerms(TERMS[1:], TERMS[:1])),
        "beauty": CompositePass("none", TERMS[1:], TERMS[:1]),
    }
    faulty = {key: image.copy() for key, image in images.items()}
    faulty[name][FAULT] = POISONS[poison]
    for result, item in passes.items():
        sound, found = (
            run_pass(gl, shaders, item, frame, {n: source[n] for n in item.reads})[result]
            for source in (images, faulty)
        )
        changed = np.any(found != sound, axis=-1)
        changed[FAULT] = False
        record(f"poisoned term: {name}", result, int(changed.sum()), 0, "texels changed")


@pytest.mark.parametrize("curve", CURVES)
def test_the_display_shows_a_fault_as_one_valid_pixel(gl, shaders, record, curve):
    item = ToneMapPass(ToneMapSettings(curve=curve))
    frame = picture_frame(SIZE, 0.4)
    beauty = noise(4)
    sound = run_pass(gl, shaders, item, frame, {"beauty": beauty})["display"]
    for fault in POISONS.values():
        beauty[FAULT] = fault
        shown = run_pass(gl, shaders, item, frame, {"beauty": beauty})["display"]
        assert np.all(np.isfinite(shown)) and shown.min() >= 0.0 and shown.max() <= 1.0
        changed = np.any(shown != sound, axis=-1)
        changed[FAULT] = False
        record("poisoned radiance on the display", curve, int(changed.sum()), 0, "texels changed")

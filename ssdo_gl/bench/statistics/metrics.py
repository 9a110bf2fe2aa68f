"""How far an image is from its reference, beyond `images.error`: each metric with its formula.

Images are arrays (height, width, channels), row 0 at the top, scene-linear unless a
name says ``srgb``. ``mask`` (height, width) says which pixels count; callers leave the
background out of it, because both images agree there by construction."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.color import srgb_from_linear
from ssdo_gl.images.error import FloatImage, Mask, failures, masked_mean, root, squared_error
from ssdo_gl.user_error import UserError

# HDR-FLIP tone-maps both images at several exposures and keeps the largest error. By
# default the range comes from the reference, so numbers of two scenes do not compare;
# here it is fixed around the camera's exposure, one image per stop.
FLIP_EXPOSURES_EV = (-4.0, 2.0, 7)
# FLIP's own default: 0.7 m from a 0.7 m wide screen of 3840 pixels.
FLIP_PIXELS_PER_DEGREE = 67.0
# The Gaussian window of Wang et al. 2004: sigma 1.5 px, truncated at 3.5 sigma.
SSIM_SIGMA_PX = 1.5


class MissingLibraryError(UserError, RuntimeError):
    """A library of the extra ``bench`` is not installed: one line with the cure."""


def missing(library: str) -> MissingLibraryError:
    """Return the error that tells the user how to get `library`."""
    return MissingLibraryError(f"{library} is needed here: pip install 'ssdo_gl[bench]'")


def srgb_of(linear: FloatImage, exposure_ev: float = 0.0) -> NDArray[np.float32]:
    """Return `linear` (height, width, 3) exposed, clipped at 1 and sRGB-encoded.

    The tone curve of the comparisons is the plain display curve, so that an error
    is judged where it would be seen and no artistic curve hides it. Failures become
    magenta, the colour no comparison overlooks.
    """
    failed = failures(linear)
    unit = np.clip(np.where(failed[:, :, None], 0.0, linear) * 2.0**exposure_ev, 0.0, 1.0)
    encoded = srgb_from_linear(unit)
    encoded[failed] = (1.0, 0.0, 1.0)
    return np.asarray(encoded, dtype=np.float32)


def ssim(image_srgb: FloatImage, reference_srgb: FloatImage, mask: Mask) -> float:
    """Return the mean structural similarity of two display images over `mask`.

    1 is identical. Gaussian window, population covariances, data range 1: the
    settings of the original paper.

    Raises
    ------
    MissingLibraryError
    """
    try:
        from skimage.metrics import structural_similarity
    except ImportError:
        raise missing("scikit-image") from None
    # scikit-image shrinks nothing: the frame must hold the 11-pixel window.
    if min(image_srgb.shape[:2]) < 11:
        return math.nan
    _, similarity = structural_similarity(  # type: ignore[no-untyped-call]
        reference_srgb.astype(np.float64),
        image_srgb.astype(np.float64),
        data_range=1.0,
        channel_axis=2,
        gaussian_weights=True,
        sigma=SSIM_SIGMA_PX,
        use_sample_covariance=False,
        full=True,
    )
    return masked_mean(np.asarray(similarity, dtype=np.float64).mean(axis=2), mask)


@dataclass(frozen=True, eq=False)
class FlipResult:
    """A FLIP error map and its mean.

    Attributes
    ----------
    mean : float
        Over the mask, [0, 1].
    error : ndarray, shape (height, width), float32
        Per pixel, [0, 1]; 1 at failures.
    """

    mean: float
    error: NDArray[np.float32]


def flip_ldr(image_srgb: FloatImage, reference_srgb: FloatImage, mask: Mask) -> FlipResult:
    """Return LDR-FLIP (Andersson et al. 2020) of two display images in [0, 1]."""
    return _flip(image_srgb, reference_srgb, mask, "LDR", {"ppd": FLIP_PIXELS_PER_DEGREE})


def flip_hdr(
    image: FloatImage, reference: FloatImage, mask: Mask, exposure_ev: float = 0.0
) -> FlipResult:
    """Return HDR-FLIP (Andersson et al. 2021) with fixed exposures around `exposure_ev`."""
    start, stop, count = FLIP_EXPOSURES_EV
    parameters = {
        "ppd": FLIP_PIXELS_PER_DEGREE,
        "startExposure": start,
        "stopExposure": stop,
        "numExposures": count,
        "tonemapper": "ACES",
    }
    gain = 2.0**exposure_ev
    return _flip(image * gain, reference * gain, mask, "HDR", parameters)


def _flip(
    image: FloatImage, reference: FloatImage, mask: Mask, kind: str, parameters: dict[str, Any]
) -> FlipResult:
    try:
        import flip_evaluator
    except ImportError:
        raise missing("flip-evaluator") from None
    failed = failures(image)
    safe = np.where(failed[:, :, None], 0.0, np.maximum(image, 0.0))
    error, _, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(np.maximum(reference, 0.0), dtype=np.float32),
        np.ascontiguousarray(safe, dtype=np.float32),
        kind,
        # LDR inputs are sRGB-encoded, HDR inputs linear: what True stands for.
        inputsRGB=True,
        applyMagma=False,
        computeMeanError=False,
        parameters=parameters,
    )
    values = np.array(error, dtype=np.float32).reshape(image.shape[:2])
    values[failed] = 1.0
    return FlipResult(masked_mean(values.astype(np.float64), mask), values)


@dataclass(frozen=True)
class Decomposition:
    """The error of one setting told apart, as root mean squares.

    ``total^2 = noise^2 + bias^2``: noise is the estimator against its own expectation
    (over seeds), bias its expectation against the reference.
    """

    total: float
    noise: float
    bias: float


def decompose(
    images: list[FloatImage],
    reference: FloatImage,
    mask: Mask,
    reference_variance: FloatImage | None = None,
) -> Decomposition:
    """Split the error of one setting, rendered with several seeds, into noise and bias.

    Unbiased: the sample variance over S seeds estimates noise^2; the squared distance
    of the mean image contains noise^2 / S and the reference's variance, both subtracted.

    Parameters
    ----------
    images : list of ndarray, each (height, width, channels)
        One per seed; at least two to tell noise from bias (with one, noise is NaN and
        bias the total).
    """
    stack = np.stack([image.astype(np.float64) for image in images])
    count = len(images)
    squares = [
        masked_mean(squared_error(image, reference, reference_variance), mask) for image in images
    ]
    total = root(float(np.mean(squares)))
    if count < 2:
        return Decomposition(total, math.nan, total)
    variance = masked_mean(stack.var(axis=0, ddof=1).mean(axis=2), mask)
    of_mean = masked_mean(squared_error(stack.mean(axis=0), reference, reference_variance), mask)
    return Decomposition(total, root(variance), root(of_mean - variance / count))

"""How far an image is from its reference: every metric with its formula, in NumPy.

Images are arrays (height, width, channels), row 0 at the top, scene-linear unless a
name says ``srgb``. ``mask`` (height, width) says which pixels count; callers leave the
background out of it, because both images agree there by construction.

A pixel with a NaN or an infinity in any channel is a failure: it is never dropped, it
makes every error infinite, and `failures` says where they are.

References are Monte-Carlo estimates. With a reference T of per-pixel variance v,
E[(X - T)^2] = (X - E[T])^2 + v, so the functions that take ``reference_variance`` subtract
its mean. For a reference averaged from two independent halves A, B this is the same number
as the product (X - A)(X - B), which is unbiased term by term.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.images.color import srgb_from_linear

FloatImage = NDArray[np.floating[Any]]
Mask = NDArray[np.bool_]

# Added to the squared reference in relMSE, in units of display white (radiance 1 at
# exposure 0): the usual value in the denoising literature, where 0.1 is dark grey.
REL_MSE_EPSILON = 0.01
# HDR-FLIP tone-maps both images at several exposures and keeps the largest error. By
# default the range comes from the reference, so numbers of two scenes do not compare;
# here it is fixed around the camera's exposure, one image per stop.
FLIP_EXPOSURES_EV = (-4.0, 2.0, 7)
# FLIP's own default: 0.7 m from a 0.7 m wide screen of 3840 pixels.
FLIP_PIXELS_PER_DEGREE = 67.0
# The Gaussian window of Wang et al. 2004: sigma 1.5 px, truncated at 3.5 sigma.
SSIM_SIGMA_PX = 1.5


class MissingLibraryError(RuntimeError):
    """A library of the extra ``bench`` is not installed: one line with the cure."""


def missing(library: str) -> MissingLibraryError:
    """Return the error that tells the user how to get `library`."""
    return MissingLibraryError(f"{library} is needed here: pip install 'ssdo_gl[bench]'")


def failures(image: FloatImage) -> Mask:
    """Return which pixels hold a NaN or an infinity, shape (height, width)."""
    return np.asarray(~np.isfinite(image).all(axis=2))


def squared_error(
    image: FloatImage, reference: FloatImage, reference_variance: FloatImage | None = None
) -> NDArray[np.float64]:
    """Return the per-pixel squared error, mean over channels, reference's noise subtracted.

    Single pixels may come out negative where the reference is noisy: that is what makes
    the mean unbiased.

    Parameters
    ----------
    image, reference : ndarray, shape (height, width, channels)
    reference_variance : ndarray, shape (height, width, channels), or None
        Variance of the reference's mean; None takes the reference as exact.

    Returns
    -------
    ndarray, shape (height, width), float64
        Infinite at failures.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        error = (image.astype(np.float64) - reference.astype(np.float64)) ** 2
        if reference_variance is not None:
            error = error - reference_variance
        mean = error.mean(axis=2)
    failed = failures(image)
    return np.where(failed, np.inf, mean)


def signed_error(image: FloatImage, reference: FloatImage) -> NDArray[np.float64]:
    """Return the per-pixel signed error, mean over channels; infinite at failures."""
    failed = failures(image)
    safe = np.where(failed[:, :, None], 0.0, image).astype(np.float64)
    return np.where(failed, np.inf, (safe - reference).mean(axis=2))


def root(mean_square: float) -> float:
    """Return the square root; 0 where subtracted noise left a negative mean."""
    return 0.0 if mean_square <= 0.0 else math.sqrt(mean_square)


def masked_mean(values: NDArray[np.float64], mask: Mask) -> float:
    """Return the mean of `values` where `mask`; 0 if nothing counts."""
    chosen = values[mask]
    return float(chosen.mean()) if chosen.size else 0.0


def rmse(
    image: FloatImage,
    reference: FloatImage,
    mask: Mask,
    reference_variance: FloatImage | None = None,
) -> float:
    """Return the root mean square error over `mask` and all channels."""
    return root(masked_mean(squared_error(image, reference, reference_variance), mask))


def bias(image: FloatImage, reference: FloatImage, mask: Mask) -> float:
    """Return the mean signed error over `mask` and all channels; > 0 is too bright."""
    return masked_mean(signed_error(image, reference), mask)


def relative_rmse(
    image: FloatImage,
    reference: FloatImage,
    mask: Mask,
    reference_variance: FloatImage | None = None,
) -> float:
    """Return `rmse` over the mean of the reference: 0.05 is "5 % of the average pixel".

    Infinite where the reference is black and the image is not; 0 where both are.
    """
    error = rmse(image, reference, mask, reference_variance)
    level = masked_mean(reference.astype(np.float64).mean(axis=2), mask)
    if level > 0.0:
        return error / level
    return 0.0 if error == 0.0 else math.inf


def relative_mse(
    image: FloatImage,
    reference: FloatImage,
    mask: Mask,
    reference_variance: FloatImage | None = None,
    epsilon: float = REL_MSE_EPSILON,
) -> float:
    """Return relMSE: the mean of (x - t)^2 / (t^2 + epsilon) over `mask` and channels.

    `image` and `reference` must be exposed, so that 1 is display white and `epsilon` means
    the same in every scene.
    """
    reference64 = reference.astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        error = (image.astype(np.float64) - reference64) ** 2
        if reference_variance is not None:
            error = error - reference_variance
        weighted = (error / (reference64**2 + epsilon)).mean(axis=2)
    failed = failures(image)
    return max(masked_mean(np.where(failed, np.inf, weighted), mask), 0.0)


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

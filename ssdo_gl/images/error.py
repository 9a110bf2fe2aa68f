"""The error of an image against its reference: squared, mean, relative. Nowhere else.

Images are arrays (height, width, channels), row 0 at the top, scene-linear. ``mask``
(height, width) says which pixels count; callers leave the background out of it, because
both images agree there by construction.

A pixel with a NaN or an infinity in any channel is a failure: it is never dropped, it
makes every error infinite, and `failures` says where they are.

References are Monte-Carlo estimates. With a reference T of per-pixel variance v,
E[(X - T)^2] = (X - E[T])^2 + v, so the functions that take ``reference_variance`` subtract
its mean. For a reference averaged from two independent halves A, B this is the same number
as the product (X - A)(X - B), which is unbiased term by term.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatImage = NDArray[np.floating[Any]]
Mask = NDArray[np.bool_]

# Added to the squared reference in relMSE, in units of display white (radiance 1 at
# exposure 0): the usual value in the denoising literature, where 0.1 is dark grey.
REL_MSE_EPSILON = 0.01


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


def mean_level(image: FloatImage, mask: Mask) -> float:
    """Return the mean over `mask` and all channels."""
    return masked_mean(image.astype(np.float64).mean(axis=2), mask)


def relative(error: float, level: float) -> float:
    """Return `error` over the mean `level`; infinite for an error on black, 0 for none."""
    if level > 0.0:
        return error / level
    return 0.0 if error == 0.0 else math.inf


def relative_rmse(
    image: FloatImage,
    reference: FloatImage,
    mask: Mask,
    reference_variance: FloatImage | None = None,
) -> float:
    """Return `rmse` over the mean of the reference: 0.05 is "5 % of the average pixel".

    Infinite where the reference is black and the image is not; 0 where both are.
    """
    return relative(rmse(image, reference, mask, reference_variance), mean_level(reference, mask))


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

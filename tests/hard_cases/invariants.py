"""What must hold of any image, whatever the scene."""

from __future__ import annotations

import numpy as np

# Estimators divide by sample counts in float32: the sum of N terms of 1/N may pass one
# by N/2 ulps of 6e-8, with at most 1024 samples.
VISIBILITY_ROUNDING = 3.1e-5


def sane(images):
    """Return how many values are not finite, negative, or outside their range."""
    faults = 0
    for name, image in images.items():
        faults += int((~np.isfinite(image)).sum())
        finite = np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0)
        if name not in ("normal_ws", "position_ws"):
            faults += int((finite < 0.0).sum())
        if name == "visibility":
            faults += int((finite > 1.0 + VISIBILITY_ROUNDING).sum())
        if name == "normal_ws":
            length = np.linalg.norm(finite, axis=2)
            faults += int(((np.abs(length - 1.0) > 1e-3) & (length > 0.0)).sum())
    return faults


def difference(images, others, name):
    """Return (relative RMSE, share of pixels that differ by more than a hundredth).

    Relative to the mean of the first image; a relative difference below 1e-30 of
    light counts as none.
    """
    a, b = (np.asarray(x[name], np.float64)[:, :, :3] for x in (images, others))
    scale = max(float(np.abs(a).mean()), 1e-30)
    gap = np.abs(a - b).max(axis=2) / scale
    return float(np.sqrt((gap**2).mean())), float((gap > 0.01).mean())

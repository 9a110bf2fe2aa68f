"""Numbers from images and times: metrics, intervals, fronts, fits."""

from __future__ import annotations

from ssdo_gl.bench.statistics.bootstrap import (
    REPLICA_COUNT,
    BlockErrors,
    Interval,
    bias_interval,
    bias_replicas,
    draw,
    median_replicas,
    percentile_interval,
    rmse_interval,
    rmse_of,
    rmse_replicas,
    whole,
)
from ssdo_gl.bench.statistics.fit import fit_power_law
from ssdo_gl.bench.statistics.metrics import (
    FLIP_EXPOSURES_EV,
    FLIP_PIXELS_PER_DEGREE,
    MissingLibraryError,
    decompose,
    flip_hdr,
    flip_ldr,
    missing,
    srgb_of,
    ssim,
)
from ssdo_gl.bench.statistics.pareto import membership, pareto_front

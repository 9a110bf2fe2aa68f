"""What is measured, on what, and against what: points, times, errors."""

from __future__ import annotations

from ssdo_gl.bench.measure.bench_renderer import BenchRenderer, Images
from ssdo_gl.bench.measure.errors import (
    ERROR_FORMAT,
    ErrorStore,
    Judged,
    Scalars,
    color,
    judge,
    judged_pixels,
    render_seeds,
    unit_px,
)
from ssdo_gl.bench.measure.fingerprints import fingerprint, scene_fingerprint, shader_fingerprint
from ssdo_gl.bench.measure.machine import (
    CLOCK_NAMES,
    describe_machine,
    is_busy,
    load_average,
    machine_class,
    trusted_clock,
)
from ssdo_gl.bench.measure.panels import ErrorPanel, all_aovs, error_panels, panel_named
from ssdo_gl.bench.measure.points import PICTURE, Point, read_grid, screen_space_method
from ssdo_gl.bench.measure.reference_cache import (
    Accumulator,
    Goal,
    Reference,
    ReferenceCache,
    obtain,
)
from ssdo_gl.bench.measure.sweep import TimeTable, order, tabulate, time_points

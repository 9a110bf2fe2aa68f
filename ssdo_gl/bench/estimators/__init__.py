"""Every estimator of the screen against time, and what each finds."""

from __future__ import annotations

from ssdo_gl.bench.estimators.estimator_table import run_estimators

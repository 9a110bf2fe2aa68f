"""Settings chosen for the user: by a budget of time, or by a bound on the error."""

from __future__ import annotations

from ssdo_gl.bench.tuning.error_bound import choose_for_error
from ssdo_gl.bench.tuning.tune import choose_for_budget

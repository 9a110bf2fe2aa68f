"""Which clock can be trusted on this machine, now."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ssdo_gl.bench.measure.machine import core_count

# What a time may be measured by; the fields that hold it, of `MedianTimes` and `Visit`.
CLOCKS = {"wall": "frame_ms", "process": "process_ms", "gpu": "gpu_ms"}
# How a person calls them.
CLOCK_NAMES = {
    "wall": "finish() and the wall clock",
    "process": "processor time of all threads",
    "gpu": "OpenGL time queries",
}
# More than this share of the cores wanted by others, and the wall clock misleads.
BUSY_SHARE = 0.5


def is_busy(load: float | None) -> bool:
    """Whether `load_average` says that others want the cores; False where it is unknown."""
    return load is not None and load > BUSY_SHARE * core_count()


def trusted_clock(machine: Mapping[str, Any]) -> str:
    """Return one of `CLOCKS` for a machine as `describe_machine` describes it.

    A GPU is asked itself. On a software rasterizer the wall clock counts, unless other
    programs share the cores: processor time does not count theirs.
    """
    if not machine["software"]:
        return "gpu"
    return "process" if is_busy(machine["load"]) else "wall"

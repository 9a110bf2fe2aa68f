"""What numbers are measured on, and by which of its clocks."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ssdo_gl.gpu.context import Device
from ssdo_gl.version import __version__

_LIBRARIES = ("moderngl", "numpy", "scikit-image", "flip-evaluator", "matplotlib")
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


def cpu_name() -> str:
    """Return the processor's name, or its architecture where the system hides it."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def core_count() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def load_average() -> float | None:
    """Return how many processes wanted a core during the last minute, if known."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def describe_machine(device: Device, timer: str, command: str) -> dict[str, Any]:
    """Return machine, driver, versions and command as plain data.

    Parameters
    ----------
    timer : str
        ``gl_query`` or ``finish_wall``.
    command : str
        What the user typed.
    """
    versions = {}
    for name in _LIBRARIES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = "not installed"
    return {
        "renderer": device.renderer,
        "opengl": device.version,
        "backend": device.backend,
        "software": device.is_software,
        "timer": timer,
        "processor": cpu_name(),
        "cores": core_count(),
        "load": load_average(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "ssdo_gl": __version__,
        "versions": versions,
        "command": command,
        "date": time.strftime("%Y-%m-%d %H:%M:%S %Z"),
    }


def machine_class(device: Device) -> str:
    """Return what a calibration is valid for: renderer, driver, processor, cores."""
    return f"{device.renderer}; {device.version}; {cpu_name()}; {core_count()} cores"


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

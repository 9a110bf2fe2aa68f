"""What the numbers were measured on, so that nobody compares them out of context."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import time
from pathlib import Path
from typing import Any

from ssdo_gl import __version__
from ssdo_gl.gpu.context import Device

_LIBRARIES = ("moderngl", "numpy", "scikit-image", "flip-evaluator", "matplotlib")


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

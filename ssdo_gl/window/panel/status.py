"""What a window is doing, in words: how refined, how fast, what was given up for it. Pure."""

from __future__ import annotations

import sys
from pathlib import Path

from ssdo_gl.settings import Settings
from ssdo_gl.window.live import QualityLevel
from ssdo_gl.window.viewer import Viewer


def state_text(viewer: Viewer, frame_rate: float) -> str:
    """Return one line: what the left side is doing, and at which size.

    Parameters
    ----------
    frame_rate : float
        Frames per second of the last motion; 0 if there was none.
    """
    left = viewer.left
    if left is None or left.image.drawing is None:
        return "the first frame is in the making"
    width, height = left.image.drawing.view.size
    full = viewer.picture_size
    size = f"{width} x {height}" + (f" of {full[0]} x {full[1]}" if (width, height) != full else "")
    done, wanted = left.image.sample_count, left.image.samples_wanted
    if not viewer.is_resting:
        rate = f": {frame_rate:.0f} frames/s" if frame_rate > 0.0 else ""
        return f"{size}   moving{rate}"
    if not left.is_done:
        return f"{size}   refining: {done} of {wanted}, {left.image.drawing.frame_ms:.0f} ms each"
    return f"{size}   refined" + (f" ({done} samples)" if wanted > 1 else "") + ", asleep"


def given_up(level: QualityLevel, settings: Settings, budget_ms: float) -> str:
    """Return what a level has less than the settings, and why."""
    lost = []
    if level.samples != settings.samples:
        lost.append(f"samples {settings.samples} to {level.samples}")
    if level.resolution_scale != settings.resolution_scale:
        lost.append(f"estimators at {level.resolution_scale:.0%}")
    if level.frame_scale != 1.0:
        lost.append(f"picture at {level.frame_scale:.0%}")
    if not lost:
        return f"moving: full quality fits into {budget_ms:.0f} ms"
    return f"moving, to fit into {budget_ms:.0f} ms: {', '.join(lost)}"


def memory_mb() -> float:
    """Return the memory that the process holds, MB; 0 where the system does not say."""
    if sys.platform.startswith("linux"):
        pages = Path("/proc/self/statm").read_text().split()[1]
        return int(pages) * 4096 / 1e6
    if sys.platform == "win32":
        return 0.0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6

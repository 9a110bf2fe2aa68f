"""The [camera] table."""

from __future__ import annotations

from ssdo_gl.scene.camera import PROJECTIONS, Camera
from ssdo_gl.scene.files import Table
from ssdo_gl.settings.settings import LONGEST, MAX_EXPOSURE_EV, SHORTEST

# What a camera has that was not placed by a file.
USUAL_FOV_Y = 40.0


def read_camera(table: Table, base: Camera | None = None) -> tuple[Camera | None, float, float]:
    """Return the camera (None if it has no position), its field of view and exposure.

    Parameters
    ----------
    base : Camera or None
        Gives field of view and exposure where the table has none.
    """
    usual = (USUAL_FOV_Y, 0.0) if base is None else (base.fov_y, base.exposure)
    table.allow("position", "target", "up", "fov_y", "exposure", "projection", "height")
    fov_y = table.number("fov_y", usual[0], low=0.0, high=180.0, open_ends=True)
    exposure = table.number("exposure", usual[1], low=-MAX_EXPOSURE_EV, high=MAX_EXPOSURE_EV)
    if "position" not in table:
        for key in ("target", "up"):
            if key in table:
                table.fail("position", f"a camera with {key!r} needs a position too")
        return None, fov_y, exposure
    position = table.vector("position")
    target = table.vector("target")
    if position == target:
        table.fail("target", "must not coincide with position")
    up = table.direction("up", (0.0, 1.0, 0.0))
    camera, height = Camera(position, target, up, fov_y, exposure), read_height(table)
    return camera if height is None else camera.orthographic(height or None), fov_y, exposure


def read_height(table: Table) -> float | None:
    """Return what parallel rays show; 0 if that is not said, None for a pinhole."""
    is_parallel = table.text("projection", PROJECTIONS[0], PROJECTIONS) != PROJECTIONS[0]
    if "height" not in table:
        return 0.0 if is_parallel else None
    if not is_parallel:
        table.fail("height", 'it belongs to projection = "orthographic"')
    return table.number("height", low=SHORTEST, high=LONGEST)

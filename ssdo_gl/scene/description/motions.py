"""The `animate` table that an object or a light may carry."""

from __future__ import annotations

from ssdo_gl.scene.description.table import Table
from ssdo_gl.scene.light import Vector
from ssdo_gl.scene.motion import Motion

MOTION_TABLE = "animate"
KEYS = ("spin", "pivot", "orbit", "orbit_center", "sway", "period")


def read_motion(table: Table, center: Vector) -> Motion | None:
    """Return the motion of an object or light whose middle is `center`, if it has one.

    `spin` turns about `pivot`, which is `center` unless the file says otherwise.
    """
    animate = table.table(MOTION_TABLE)
    if animate is None:
        return None
    animate.allow(*KEYS)
    zero = (0.0, 0.0, 0.0)
    motion = Motion(
        spin=animate.vector("spin", zero),
        orbit=animate.vector("orbit", zero),
        pivot=animate.vector("pivot", center),
        orbit_center=animate.vector("orbit_center", zero),
        sway=animate.vector("sway", zero),
        period=animate.number("period", 4.0, low=0.0, open_ends=True),
    )
    moves = any(motion.spin) or any(motion.orbit) or any(motion.sway)
    return motion if moves else None


def names_pivot(table: Table) -> bool:
    """Return whether the file gives `animate` a pivot of its own."""
    animate = table.table(MOTION_TABLE)
    return animate is not None and "pivot" in animate

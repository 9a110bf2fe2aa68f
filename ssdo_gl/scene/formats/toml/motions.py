"""The `animate` table that an object or a light may carry."""

from __future__ import annotations

from ssdo_gl.math3d import Vector
from ssdo_gl.scene.files import Table
from ssdo_gl.scene.motion import Motion

MOTION_TABLE = "animate"
KEYS = ("spin", "pivot", "orbit", "orbit_center", "sway", "period")
# Seconds; at the largest time that may be asked for, the phase is still a number.
_SHORTEST_PERIOD = 1e-6
_ZERO: Vector = (0.0, 0.0, 0.0)


def read_motion(table: Table, center: Vector) -> Motion | None:
    """Return the motion of an object or light whose middle is `center`, if it has one.

    `spin` turns about `pivot`, which is `center` unless the file says otherwise.
    """
    animate = table.table(MOTION_TABLE)
    if animate is None:
        return None
    animate.allow(*KEYS)
    motion = Motion(
        spin=animate.vector("spin", _ZERO),
        orbit=animate.vector("orbit", _ZERO),
        pivot=animate.vector("pivot", center),
        orbit_center=animate.vector("orbit_center", _ZERO),
        sway=animate.vector("sway", _ZERO),
        period=animate.number("period", 4.0, low=_SHORTEST_PERIOD),
    )
    moves = any(motion.spin) or any(motion.orbit) or any(motion.sway)
    return motion if moves else None


def spins_in_place(table: Table) -> bool:
    """Return whether each copy of the object turns about its own middle."""
    animate = table.table(MOTION_TABLE)
    return animate is not None and "pivot" not in animate and any(animate.vector("spin", _ZERO))

"""What of a scene a camera can see, and what that rules out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ssdo_gl.graph.frame import FrameView
from ssdo_gl.math3d import IntArray, Region
from ssdo_gl.planning.bodies import Bodies

# Bodies outside the frame by less than this count as seen: jitter moves a sample by half
# a pixel, and rounding by far less.
FRAME_MARGIN_PX = 2.0


@dataclass(frozen=True)
class ViewFacts:
    """Facts about one view of a scene. Everything is conservative: in doubt, it matters.

    Attributes
    ----------
    is_empty : bool
        No body is in view.
    is_alone : bool
        A single solid box is in view, seen from outside: nothing stands above any visible
        tangent plane.
    gloss_region : (int, int, int, int) or None
        Outside this part of the frame no surface reflects more than diffuse light: x, y,
        width and height in pixels, from the bottom left. None: nor does any inside. With
        `gi` a frame of a duck takes .80 of the time that it takes without, of a truck .91.
    """

    is_empty: bool
    is_alone: bool
    gloss_region: Region | None

    @property
    def kinds(self) -> tuple[bool, ...]:
        """All that is decided by: it stays the same over many views."""
        return self.is_empty, self.is_alone, self.gloss_region is None


def view_facts(bodies: Bodies, eye: FrameView) -> ViewFacts:
    """Return what can be said of the view from `eye`."""
    seen = seen_bodies(bodies, eye)
    return ViewFacts(
        is_empty=len(seen) == 0,
        is_alone=len(seen) == 1 and _is_box_from_outside(bodies, int(seen[0]), eye),
        gloss_region=region_of(bodies, seen[bodies.is_glossy[seen]], eye),
    )


def seen_bodies(bodies: Bodies, eye: FrameView) -> IntArray:
    """Return the numbers of the bodies whose boxes reach into the frame."""
    wider = [1.0 + 2.0 * FRAME_MARGIN_PX / n for n in eye.size]
    x, y = (half * factor for half, factor in zip(eye.tan_half_fov, wider, strict=True))
    u, v = (half * factor for half, factor in zip(eye.half_frame, wider, strict=True))
    # Inward normals of the frame's sides, and of the plane through the eye.
    sides = np.array([[1, 0, -x], [-1, 0, -x], [0, 1, -y], [0, -1, -y], [0, 0, -1]])
    planes = sides @ eye.view_from_world
    height = (bodies.center - eye.position_ws) @ planes.T + np.array([u, u, v, v, 0.0])
    return np.flatnonzero((height + bodies.reach_along(planes) >= 0.0).all(axis=1))


def _is_box_from_outside(bodies: Bodies, body: int, eye: FrameView) -> bool:
    if not bodies.is_box[body]:
        return False
    if eye.half_frame[1] <= 0.0:
        return not bodies.holds(body, eye.position_ws)
    # Rays begin on the near plane, which may cut the box open.
    ahead = -eye.view_from_world[2]
    depth = (bodies.center[body] - eye.position_ws) @ ahead
    return bool(depth - bodies.reach_along(ahead[None])[body, 0] > eye.near)


def region_of(bodies: Bodies, chosen: IntArray, eye: FrameView) -> Region | None:
    """Return a part of the frame outside which none of the bodies `chosen` is seen.

    None, if there is none of them.
    """
    if len(chosen) == 0:
        return None
    signs = np.where(np.indices((2, 2, 2)).reshape(3, 8).T, 1.0, -1.0)
    corners = bodies.center[chosen, None] + signs @ bodies.half_edges[chosen]
    x, y, back = np.moveaxis((corners - eye.position_ws) @ eye.view_from_world.T, -1, 0)
    size = np.array(eye.size)
    if eye.half_frame[1] <= 0.0 and np.any(back >= 0.0):
        return 0, 0, *eye.size
    halves = (half - tan * back for half, tan in zip(eye.half_frame, eye.tan_half_fov, strict=True))
    across = [0.5 + 0.5 * a / half for a, half in zip((x, y), halves, strict=True)]
    low, high = (
        size * [limit(side) for side in across] + margin
        for limit, margin in ((np.min, -FRAME_MARGIN_PX), (np.max, FRAME_MARGIN_PX))
    )
    first = np.clip(np.floor(low), 0, size).astype(int)
    end = np.clip(np.ceil(high), first, size).astype(int)
    return int(first[0]), int(first[1]), int(end[0] - first[0]), int(end[1] - first[1])

"""What of a scene a camera can see, and what that rules out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ssdo_gl.facts.bodies import Bodies
from ssdo_gl.graph.frame import FrameView
from ssdo_gl.math3d import IntArray, Region

# Bodies outside the frame by less than this count as seen: jitter moves a sample by half
# a pixel, and rounding by far less.
FRAME_MARGIN_PX = 2.0
# Of the corners of a box.
_SIGNS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


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
    emission_region : (int, int, int, int) or None
        The same of surfaces that show light of their own.
    """

    is_empty: bool
    is_alone: bool
    gloss_region: Region | None
    emission_region: Region | None

    @property
    def kinds(self) -> tuple[bool, ...]:
        """All that is decided by: it stays the same over many views."""
        return (
            *(self.is_empty, self.is_alone),
            *(self.gloss_region is None, self.emission_region is None),
        )


def view_facts(bodies: Bodies, eye: FrameView) -> ViewFacts:
    """Return what can be said of the view from `eye`."""
    seen = seen_bodies(bodies, eye)
    return ViewFacts(
        is_empty=len(seen) == 0,
        is_alone=len(seen) == 1 and _is_box_from_outside(bodies, int(seen[0]), eye),
        gloss_region=region_of(bodies, seen[bodies.is_glossy[seen]], eye),
        emission_region=region_of(bodies, seen[bodies.emits[seen]], eye),
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
    corners = bodies.center[chosen, None] + _SIGNS @ bodies.half_edges[chosen]
    corners_vs = (corners.reshape(-1, 3) - eye.position_ws) @ eye.view_from_world.T
    back = corners_vs[:, 2:]
    if eye.half_frame[1] <= 0.0 and (back >= 0.0).any():
        return 0, 0, *eye.size
    size = np.array(eye.size)
    halves = np.array(eye.half_frame) - back * np.array(eye.tan_half_fov)
    across = size * (0.5 + 0.5 * corners_vs[:, :2] / halves)
    low = np.floor(np.minimum.reduce(across) - FRAME_MARGIN_PX)
    high = np.ceil(np.maximum.reduce(across) + FRAME_MARGIN_PX)
    first = np.minimum(np.maximum(low, 0.0), size)
    width, height = np.minimum(np.maximum(high, first), size) - first
    return int(first[0]), int(first[1]), int(width), int(height)

"""Float64 twins of the estimators that look along slices. Imports nothing from ssdo_gl."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracle.screen_space import (
    BAYER,
    FAR_REACH,
    Array,
    Decisions,
    Estimator,
    Flags,
    Indices,
    Picture,
    distance_in_frame,
    frame_from_z,
    height_tests,
    kronecker_points,
    march_fraction,
)


@dataclass(frozen=True)
class Receivers:
    """Receivers (n), once for each of their directions (d), and their sample points."""

    p: Array  # (n, d, 3)
    shading: Array
    geometric: Array
    view: Array  # towards the camera
    u: Array  # (n, d, 3)

    @classmethod
    def at(
        cls, picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
    ) -> Receivers:
        """Return the receivers at `texel` (n, 2), whose sample sets `pixel` (n, 2) chooses."""
        first = BAYER[pixel[:, 1] % 4, pixel[:, 0] % 4] * estimator.directions
        u = kronecker_points(first[:, None] + np.arange(estimator.directions), estimator.offset)

        def spread(values: Array) -> Array:
            return np.broadcast_to(values[:, None], u.shape)

        p = picture.position(texel)
        shading, geometric = (
            spread(normals[texel[:, 1], texel[:, 0]])
            for normals in (picture.shading, picture.geometric)
        )
        view = -p / np.linalg.norm(p, axis=-1, keepdims=True)
        return cls(spread(p), shading, geometric, spread(view), u)


def rises_above(
    picture: Picture,
    p: Array,
    n: Array,
    texel: Indices,
    estimator: Estimator,
    decide: Decisions,
    live: Flags | None = None,
    reach: float | None = None,
) -> Flags:
    """Whether the surfaces at `texel` rise above the plane through p, within `reach` of it."""
    z = picture.z[texel[..., 1], texel[..., 0]]
    pq = picture.position(texel, z) - p
    far = np.maximum(-p[..., 2], z)
    tests = height_tests(pq, n, -p[..., 2], far, estimator)
    if reach is not None:
        tests.append((np.full_like(z, reach), np.linalg.norm(pq, axis=-1), far))
    return decide.all_greater((z > 0.0) if live is None else live & (z > 0.0), *tests)


def arc_integral(theta: Array, gamma: Array) -> Array:
    """Return the integral of cos(t - gamma) sin(t) from 0 to theta."""
    return np.asarray(
        0.25 * (np.cos(gamma) - np.cos(2.0 * theta - gamma) + 2.0 * theta * np.sin(gamma))
    )


def slice_normal(r: Receivers, along: Array) -> tuple[Array, Array]:
    """Return angle from the view vector, and length, of the normal's projection."""
    x = np.einsum("...i,...i", r.shading, along)
    y = np.einsum("...i,...i", r.shading, r.view)
    return np.arctan2(x, y), np.hypot(x, y)


class Walk:
    """The texels that the steps along one side of a slice fall on."""

    def __init__(self, picture: Picture, r: Receivers, along: Array, estimator: Estimator) -> None:
        distance = np.linalg.norm(r.p, axis=-1)
        sine = np.minimum(estimator.radius / distance, 1.0)
        open_end = sine >= 1.0
        root = np.sqrt(1.0 - np.where(open_end, 0.0, sine) ** 2)
        reach = np.where(open_end, FAR_REACH * distance, sine * distance / root)
        reach = np.minimum(reach, distance_in_frame(picture, r.p, along))
        self.start_px = picture.pixel(r.p)
        self.across_px = picture.pixel(r.p + reach[..., None] * along) - self.start_px
        self.first = np.minimum(1.0 / np.maximum(np.linalg.norm(self.across_px, axis=-1), 1.0), 1.0)
        self.estimator = estimator

    def px(self, i: int, jitter: Array) -> Array:
        """Return where step `i` stands."""
        s = march_fraction((i + jitter) / self.estimator.steps, self.estimator.growth)
        s = self.first + s * (1.0 - self.first)
        return np.asarray(self.start_px + s[..., None] * self.across_px)


def gtao(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    r = Receivers.at(picture, texel, pixel, estimator)
    decide = Decisions(r.u.shape[:-1])
    axes = frame_from_z(r.view)
    turn = np.pi * r.u[..., :1]
    along = axes[..., 0] * np.cos(turn) + axes[..., 1] * np.sin(turn)
    gamma, length = slice_normal(r, along)
    blocked = np.zeros_like(length)
    for side, jitter in ((1.0, r.u[..., 1]), (-1.0, r.u[..., 2])):
        end = np.clip(side * gamma + np.pi / 2.0, 0.0, np.pi)
        walk = Walk(picture, r, side * along, estimator)
        highest = np.cos(end)
        for i in range(estimator.steps):
            q = decide.texel(walk.px(i, jitter), np.ones(jitter.shape, bool))
            to_q = picture.position(q) - r.p
            distance = np.linalg.norm(to_q, axis=-1)
            rises = rises_above(
                picture, r.p, r.geometric, q, estimator, decide, reach=estimator.radius
            )
            cosine = np.einsum("...i,...i", to_q, r.view) / np.maximum(distance, 1e-30)
            highest = np.where(rises, np.maximum(highest, cosine), highest)
        horizon = np.minimum(np.arccos(np.minimum(highest, 1.0)), end)
        hidden = arc_integral(end, side * gamma) - arc_integral(horizon, side * gamma)
        blocked += length * np.maximum(hidden, 0.0)
    return np.maximum(1.0 - blocked.mean(1), 0.0), decide.unsure.any(1)

"""Float64 twins of the published estimators: slices, horizons, a spiral and a box.

Imports nothing from ssdo_gl.
"""

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
    solid_end,
)


@dataclass(frozen=True)
class Receivers:
    """Receivers (n), once for each of their directions (d), and their sample points."""

    p: Array  # (n, d, 3)
    shading: Array
    geometric: Array
    view: Array  # towards the camera
    u: Array  # (n, d, 3)
    turn: Array  # (n, d), in [0, 1)

    @classmethod
    def at(
        cls, picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
    ) -> Receivers:
        """Return the receivers at `texel` (n, 2), whose sample sets `pixel` (n, 2) chooses."""
        number, i = BAYER[pixel[:, 1] % 4, pixel[:, 0] % 4], np.arange(estimator.directions)
        u = kronecker_points((number * estimator.directions)[:, None] + i, estimator.offset)
        shift = ((estimator.offset[0] + number * 2**28) % 2**32 >> 8) / 2.0**24
        turn = (i + shift[:, None]) / estimator.directions

        def spread(values: Array) -> Array:
            return np.broadcast_to(values[:, None], u.shape)

        p = picture.position(texel)
        shading, geometric = (
            spread(normals[texel[:, 1], texel[:, 0]])
            for normals in (picture.shading, picture.geometric)
        )
        view = -p / np.linalg.norm(p, axis=-1, keepdims=True)
        return cls(spread(p), shading, geometric, spread(view), u, turn)

    def direction(self, turn: Array) -> Array:
        """Return the direction `turn` (n, d) about the view vector."""
        axes, turn = frame_from_z(self.view), turn[..., None]
        return np.asarray(axes[..., 0] * np.cos(turn) + axes[..., 1] * np.sin(turn))


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

    def fraction(self, x: Array) -> Array:
        """Return which fraction of the way a step at `x` (0 to 1) stands at."""
        s = march_fraction(x, self.estimator.growth)
        return np.asarray(self.first + s * (1.0 - self.first))

    def px(self, fraction: Array) -> Array:
        """Return pixel coordinates of a fraction of the way."""
        return np.asarray(self.start_px + fraction[..., None] * self.across_px)


def gtao(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    r = Receivers.at(picture, texel, pixel, estimator)
    decide = Decisions(r.u.shape[:-1])
    along = r.direction(np.pi * r.turn)
    gamma, length = slice_normal(r, along)
    blocked = np.zeros_like(length)
    for side, jitter in ((1.0, r.u[..., 1]), (-1.0, r.u[..., 2])):
        end = np.clip(side * gamma + np.pi / 2.0, 0.0, np.pi)
        highest = highest_elevation(
            picture, r, side * along, jitter, np.cos(end), estimator, decide
        )
        horizon = np.minimum(np.arccos(np.minimum(highest, 1.0)), end)
        hidden = arc_integral(end, side * gamma) - arc_integral(horizon, side * gamma)
        blocked += length * np.maximum(hidden, 0.0)
    return np.maximum(1.0 - blocked.mean(1), 0.0), decide.unsure.any(1)


def highest_elevation(
    picture: Picture,
    r: Receivers,
    along: Array,
    jitter: Array,
    lowest: Array,
    estimator: Estimator,
    decide: Decisions,
) -> Array:
    """Return the largest sine of an elevation among the steps along one side."""
    walk, highest = Walk(picture, r, along, estimator), lowest
    for i in range(estimator.steps):
        x = (i + jitter) / estimator.steps
        q = decide.texel(walk.px(walk.fraction(x)), np.ones(jitter.shape, bool))
        to_q = picture.position(q) - r.p
        rises = rises_above(picture, r.p, r.geometric, q, estimator, decide, reach=estimator.radius)
        distance = np.maximum(np.linalg.norm(to_q, axis=-1), 1e-30)
        sine = np.einsum("...i,...i", to_q, r.view) / distance
        highest = np.where(rises, np.maximum(highest, sine), highest)
    return highest


def hbao(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    r = Receivers.at(picture, texel, pixel, estimator)
    decide = Decisions(r.u.shape[:-1])
    along = r.direction(2.0 * np.pi * r.turn)
    x, y = (np.einsum("...i,...i", r.geometric, axis) for axis in (along, r.view))
    tangent = -x / np.hypot(x, y)
    highest = highest_elevation(picture, r, along, r.u[..., 1], tangent, estimator, decide)
    return np.maximum(1.0 - (highest - tangent).mean(1), 0.0), decide.unsure.any(1)


def sao(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    count = estimator.directions
    first = BAYER[pixel[:, 1] % 4, pixel[:, 0] % 4] * count
    noise = kronecker_points(first, estimator.offset)[:, None]
    i = np.arange(count)
    p = np.broadcast_to(picture.position(texel)[:, None], (len(texel), count, 3))
    n = np.broadcast_to(picture.geometric[texel[:, 1], texel[:, 0]][:, None], p.shape)
    tan, z = np.asarray(picture.tan_half_fov), -p[..., 2]
    radius = np.minimum(estimator.radius, 2.0 * tan.max() * z)
    turn = 2.0 * np.pi * ((i * 0.61803398875 + noise[..., 0]) % 1.0)
    share = (i + noise[..., 1]) / count
    away = np.maximum(share**2 * radius * picture.size[1] / (2.0 * tan[1] * z), 1.0)
    offset = away[..., None] * np.stack([np.cos(turn), np.sin(turn)], -1) + 0.5
    decide = Decisions(away.shape)
    q = texel[:, None] + decide.texel(offset, np.ones(away.shape, bool))
    inside = np.clip(q, 0, picture.size.astype(np.int64) - 1)
    live = np.all(q == inside, -1)
    counts = rises_above(picture, p, n, inside, estimator, decide, live)
    to_q = picture.position(inside) - p
    d2 = (to_q**2).sum(-1)
    window = np.maximum(1.0 - d2 / radius**2, 0.0) ** 2
    tap = window * np.einsum("...i,...i", to_q, n) / (d2 + (0.1 * radius) ** 2)
    obscured = (2.0 * np.pi * 0.1 * radius * tap * counts).mean(1)
    return np.maximum(1.0 - np.sqrt(obscured), 0.0) ** 2, decide.unsure.any(1)


def zbuffer(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    u = Receivers.at(picture, texel, pixel, estimator).u[..., :2]
    decide = Decisions(u.shape[:-1])
    offset = (2.0 * u - 1.0) * estimator.box_px + 0.5
    q = texel[:, None] + decide.texel(offset, np.ones(u.shape[:-1], bool))
    inside = np.clip(q, 0, picture.size.astype(np.int64) - 1)
    z = picture.z[inside[..., 1], inside[..., 0]]
    own = picture.z[texel[:, 1], texel[:, 0]][:, None]
    live = np.all(q == inside, -1) & (z > 0.0)
    blocked = decide.all_greater(live, (own * 0.99, z, own))
    return 1.0 - blocked.mean(1), decide.unsure.any(1)


SECTOR_COUNT = 32
# Shares of a slice carry some 1e-6 in float32, 32 times that in sectors.
NEAR_SECTOR = 1e-4


@dataclass(frozen=True)
class Sectors:
    """Slices as 32 directions each.

    along (n, d, 3); gamma (n, d); jitter (n, d); share (n, d): of the hemisphere, for each
    direction; hidden (n, d, 32): what is blocked; blocker (n, d, 32, 2): the texel that does
    it, -1 where open; unsure (n, d).
    """

    along: Array
    gamma: Array
    jitter: Array
    share: Array
    hidden: Flags
    blocker: Indices
    unsure: Flags


def share_before(gamma: Array, x: Array, y: Array) -> Array:
    """Return which share of a slice's hemisphere lies before (x along the slice, y along v)."""
    side = np.where(x < 0.0, -1.0, 1.0)
    angle = np.arctan2(np.abs(x), y)
    end = side * gamma + np.pi / 2.0
    first = 0.5 * (np.cos(gamma) + (gamma - np.pi / 2.0) * np.sin(gamma))
    total = np.cos(gamma) + gamma * np.sin(gamma)
    share = (first + side * arc_integral(angle, side * gamma)) / total
    return np.clip(np.where(angle >= end, np.maximum(side, 0.0), share), 0.0, 1.0)


def find_sectors(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Receivers, Sectors]:
    """Run the bitmask."""
    r = Receivers.at(picture, texel, pixel, estimator)
    along, jitter = r.direction(np.pi * r.turn), r.u[..., 1]
    gamma, length = slice_normal(r, along)
    share = length * (np.cos(gamma) + gamma * np.sin(gamma))
    share /= SECTOR_COUNT * share.sum(1, keepdims=True)
    unsure = np.zeros(gamma.shape, bool)
    shape = (*gamma.shape, SECTOR_COUNT)
    hidden, blocker = np.zeros(shape, bool), np.full((*shape, 2), -1)
    decide = Decisions(gamma.shape)
    stride = 1.0 / estimator.steps
    for side, moved in ((1.0, r.u[..., 2]), (-1.0, (r.u[..., 2] + 0.5) % 1.0)):
        walk = Walk(picture, r, side * along, estimator)
        for i in range(estimator.steps):
            x = (i + moved) * stride
            q = decide.texel(walk.px(walk.fraction(x)), np.ones(x.shape, bool))
            first, last, near = _hidden_at(picture, r, along, gamma, jitter, walk, x, q, decide)
            k = np.arange(SECTOR_COUNT)
            found = (k >= first[..., None]) & (k < last[..., None])
            unsure = unsure | near
            blocker = np.where((found & ~hidden)[..., None], q[..., None, :], blocker)
            hidden |= found
    return r, Sectors(along, gamma, jitter, share, hidden, blocker, unsure | decide.unsure)


def _hidden_at(
    picture: Picture,
    r: Receivers,
    along: Array,
    gamma: Array,
    jitter: Array,
    walk: Walk,
    x: Array,
    texel: Indices,
    decide: Decisions,
) -> tuple[Array, Array, Flags]:
    """Return the first sector that a step hides, the one after the last, and unsure flags."""
    estimator, stride = walk.estimator, 1.0 / walk.estimator.steps

    def ray(fraction: Array) -> Array:
        """Return directions of depth 1 through a fraction of the way."""
        ndc = walk.px(fraction) / picture.size * 2.0 - 1.0
        return np.concatenate([ndc * picture.tan_half_fov, -np.ones((*x.shape, 1))], -1)

    def seen(fraction: Array, depth: Array) -> tuple[Array, Array]:
        """Return the place in the slice of the point `depth` behind the receiver."""
        q = ray(fraction) * (depth - r.p[..., 2])[..., None] - r.p
        return np.einsum("...i,...i", q, along), np.einsum("...i,...i", q, r.view)

    own = walk.fraction(x)
    z = -r.p[..., 2]
    line = ray(own)
    beside = line * z[..., None] - r.p
    a, b = np.einsum("...i,...i", line, line), np.einsum("...i,...i", line, beside)
    inside = b * b - a * ((beside**2).sum(-1) - estimator.radius**2)
    root = np.sqrt(np.maximum(inside, 0.0))
    front = np.maximum(picture.z[texel[..., 1], texel[..., 0]] - z, (-b - root) / a)
    back = solid_end(picture, texel, np.minimum(estimator.radius, z), estimator) - z
    back = np.minimum(np.minimum(back, (-b + root) / a), FAR_REACH * z)
    deep = decide.all_greater(np.ones(x.shape, bool), (back, front, z))
    rises = rises_above(picture, r.p, r.geometric, texel, estimator, decide, deep)
    nearer = walk.fraction(np.maximum(x - estimator.front_slack * stride, 0.0))
    farther = walk.fraction(x + estimator.back_slack * stride)
    below = seen(own, back)[1] > 0.0
    ends = [seen(nearer, front), seen(np.where(below, farther, own), back)]
    sectors = [SECTOR_COUNT * share_before(gamma, *end) + jitter for end in ends]
    near = np.any([np.abs(s - np.rint(s)) < NEAR_SECTOR for s in sectors], 0)
    # A share of exactly 0 or 1 is that in float32, too.
    low, high = (np.floor(edge(*sectors)) for edge in (np.minimum, np.maximum))
    return np.where(rises, low, 0), np.where(rises, high, 0), near & rises


def bitmask(
    picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator
) -> tuple[Array, Flags]:
    """Return visibility (n) and where float32 may decide otherwise (n)."""
    _, found = find_sectors(picture, texel, pixel, estimator)
    blocked = (found.share * found.hidden.sum(2)).sum(1)
    return np.maximum(1.0 - blocked, 0.0), found.unsure.any(1)


def bounce_sectors(
    picture: Picture, r: Receivers, found: Sectors, sent: Array, hidden: float
) -> Array:
    """Return irradiance (n, 3) from the blockers of all directions.

    `sent` (h, w, 3) is the radiance that each texel sends towards the camera's side;
    towards the other side it sends `hidden` times that.
    """
    q = np.maximum(found.blocker, 0)
    normal = picture.geometric[q[..., 1], q[..., 0]]
    to_receiver = r.p[:, :, None] - picture.position(q)
    faces = np.einsum("ndki,ndki->ndk", normal, to_receiver) > 0.0
    weight = np.pi * found.share[..., None] * found.hidden * np.where(faces, 1.0, hidden)
    return np.asarray(np.einsum("ndk,ndkc->nc", weight, sent[q[..., 1], q[..., 0]]))


def sky_parts(r: Receivers, found: Sectors, count: int = 4) -> tuple[Array, Array, Array]:
    """Return where the light of each slice's parts is looked up, and what that stands for.

    Directions (n, d, count, 3), one in each of `count` equal angles; shares of the hemisphere
    (n, d, count); which part of each is open.
    """
    edges = found.gamma[..., None] + np.pi * (np.arange(count + 1) / count - 0.5)
    gamma = np.broadcast_to(found.gamma[..., None], edges.shape)
    before = share_before(gamma, np.sin(edges), np.cos(edges))
    before[..., 0], before[..., -1] = 0.0, 1.0
    first = np.floor(SECTOR_COUNT * before + found.jitter[..., None])
    k = np.arange(SECTOR_COUNT)
    inside = (k >= first[..., :-1, None]) & (k < first[..., 1:, None])
    blocked = (inside & found.hidden[..., None, :]).sum(-1) / np.maximum(inside.sum(-1), 1)
    shift = (found.jitter[..., None] + 0.61803399 * np.arange(count)) % 1.0
    angle = (edges[..., :-1] + shift * np.pi / count)[..., None]
    w = np.sin(angle) * found.along[..., None, :] + np.cos(angle) * r.view[..., None, :]
    share = SECTOR_COUNT * found.share[..., None] * np.diff(before, axis=-1)
    return w, share, 1.0 - blocked

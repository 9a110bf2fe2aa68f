"""Float64 twins of the screen-space estimators. Imports nothing from ssdo_gl.

Arrays follow OpenGL: row 0 is the bottom of the picture. Every decision that float32
could take differently (a texel's border, a comparison that is nearly a tie) is reported,
so that a test may demand equality everywhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]

# The fractions 1/g, 1/g^2 (g^3 = g + 1) and 1/golden of 2^32, rounded.
_PLASTIC = 1.32471795724474602596
ALPHA = [
    round(2**32 / _PLASTIC),
    round(2**32 / _PLASTIC**2),
    round(2**32 * (np.sqrt(5.0) - 1.0) / 2.0),
]
BAYER = np.array([[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]])

NORMAL_ERROR = 1.3e-4
DEPTH_ERROR = 1e-5
BACK_GAP = 1e-4
FAR_REACH = 1e4
BORDER_PX = 0.25

# Distance from a texel's border (pixels) and relative distance from a tie within which
# float32 may decide otherwise: pixel coordinates below 128 carry 8e-6, sums of products
# some 1e-6.
NEAR_BORDER_PX = 1e-4
NEAR_TIE = 1e-5


@dataclass(frozen=True)
class Picture:
    """A G-buffer: z (h, w), 0 = background; unit normals (h, w, 3); z_back or None."""

    z: Array
    shading: Array
    geometric: Array
    tan_half_fov: tuple[float, float]
    near: float
    z_back: Array | None = None

    @property
    def size(self) -> Array:
        return np.array([self.z.shape[1], self.z.shape[0]], np.float64)

    def position(self, texel: Indices, z: Array | None = None) -> Array:
        """Return view-space points (..., 3) at texel centres (..., 2)."""
        ndc = (texel + 0.5) / self.size * 2.0 - 1.0
        depth = self.z[texel[..., 1], texel[..., 0]] if z is None else z
        ray = np.concatenate([ndc * self.tan_half_fov, -np.ones((*ndc.shape[:-1], 1))], -1)
        return np.asarray(ray * depth[..., None])

    def pixel(self, p: Array) -> Array:
        """Return continuous pixel coordinates (..., 2) of view-space points (..., 3)."""
        ndc = p[..., :2] / (-p[..., 2:] * self.tan_half_fov)
        return np.asarray((ndc * 0.5 + 0.5) * self.size)


@dataclass(frozen=True)
class Estimator:
    """What the estimators' uniforms and defines say."""

    kind: str  # march, rgs09, hemisphere; those of slices.py
    radius: float
    directions: int
    steps: int
    offset: tuple[int, int, int]
    thickness: float
    bias: float
    growth: float = 0.0
    front_slack: float = 0.0
    back_slack: float = 0.0
    box_px: float = 0.0


@dataclass(frozen=True)
class Samples:
    """Outcome per receiver (n) and direction (d).

    blocker (n, d, 2) texels, -1 where open; w (n, d, 3) unit directions; share (n, d);
    unsure (n, d): float32 may decide otherwise.
    """

    blocker: Indices
    w: Array
    share: Array
    unsure: Flags

    @property
    def blocked(self) -> Flags:
        return np.asarray(self.blocker[..., 0] >= 0)


def kronecker_points(index: Indices, offset: tuple[int, int, int]) -> Array:
    """Return points (..., 3) of the unit cube; 24 bits per coordinate."""
    bits = [(offset[k] + index * ALPHA[k]) % 2**32 for k in range(3)]
    return np.stack([(b >> 8) / 2.0**24 for b in bits], -1)


def frame_from_z(n: Array) -> Array:
    """Return rotations (..., 3, 3) with columns x, y, n (Duff et al. 2017)."""
    s = np.where(n[..., 2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (s + n[..., 2])
    b = n[..., 0] * n[..., 1] * a
    x = np.stack([1.0 + s * n[..., 0] ** 2 * a, s * b, -s * n[..., 0]], -1)
    y = np.stack([b, s + n[..., 1] ** 2 * a, -n[..., 1]], -1)
    return np.stack([x, y, n], -1)


def cosine_hemisphere(u: Array) -> Array:
    """Return directions (..., 3) around z from points (..., 2) of the square."""
    r, phi = np.sqrt(u[..., 0]), 2.0 * np.pi * u[..., 1]
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - u[..., 0])], -1)


def uniform_hemisphere(u: Array) -> Array:
    """Return directions (..., 3), every solid angle alike."""
    z, phi = 1.0 - u[..., 0], 2.0 * np.pi * u[..., 1]
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)


class Decisions:
    """Conjunctions of comparisons; remembers those that hang on a near tie."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.unsure: Flags = np.zeros(shape, bool)

    def all_greater(self, live: Flags, *triples: tuple[Array, Array, Array]) -> Flags:
        """Return where every a > b; near ties are those within NEAR_TIE * scale."""
        result, possible = live.copy(), live.copy()
        for a, b, scale in triples:
            result &= a > b
            possible &= a > b - NEAR_TIE * scale
        certain = live.copy()
        for a, b, scale in triples:
            certain &= a > b + NEAR_TIE * scale
        self.unsure |= possible & ~certain
        return result

    def texel(self, px: Array, live: Flags) -> Indices:
        border = np.abs(px - np.rint(px)).min(-1) < NEAR_BORDER_PX
        self.unsure |= live & border
        return np.floor(px).astype(np.int64)


def height_tests(
    pq: Array, n: Array, receiver_z: Array, scale: Array, estimator: Estimator
) -> list[tuple[Array, Array, Array]]:
    """Return the comparisons that tell whether p + pq rises above the plane through p."""
    height = np.einsum("...i,...i", pq, n)
    length = np.minimum(estimator.radius, receiver_z)
    depths = 1.0 + (receiver_z - pq[..., 2]) / receiver_z
    lowest = DEPTH_ERROR * receiver_z + (estimator.bias + NORMAL_ERROR * depths) * length
    return [(height, lowest, scale)]


def solid_end(picture: Picture, texel: Indices, length: Array, estimator: Estimator) -> Array:
    """Return the depth at which the solid at `texel` ends; `length` is min(R, z)."""
    z = picture.z[texel[..., 1], texel[..., 0]]
    end = z + estimator.thickness * length
    if picture.z_back is None:
        return np.asarray(end)
    back = picture.z_back[texel[..., 1], texel[..., 0]]
    return np.asarray(np.where(back > z * (1.0 + BACK_GAP), back, end))


def _surface_tests(
    picture: Picture,
    p: Array,
    n: Array,
    texel: Indices,
    inverse_z: tuple[Array, Array],
    estimator: Estimator,
    decide: Decisions,
    live: Flags,
    has_end: bool,
    end_plane: tuple[Array, Array] | None = None,
) -> Flags:
    """Whether the surface at `texel` blocks a stretch between two inverse depths."""
    z = picture.z[texel[..., 1], texel[..., 0]]
    one = np.ones_like(z)
    receiver_z = -p[..., 2]
    length = np.minimum(estimator.radius, receiver_z)
    far = np.maximum(receiver_z, z)
    tests = [
        (one, z * inverse_z[0], one),
        *height_tests(picture.position(texel, z) - p, n, receiver_z, far, estimator),
    ]
    if end_plane is not None:
        # Rays aimed at a surface: blockers lie above its plane, too.
        plane_height = np.einsum("...i,...i", picture.position(texel, z), end_plane[0])
        lowest = end_plane[1] + DEPTH_ERROR * receiver_z + estimator.bias * length
        tests.append((plane_height, lowest, far))
    if has_end:
        tests.append((solid_end(picture, texel, length, estimator) * inverse_z[1], one, one))
    return decide.all_greater(live & (z > 0.0), *tests)


def distance_in_frame(picture: Picture, p: Array, w: Array) -> Array:
    """Distance along w at which p + t w leaves the frame or passes the near plane."""
    tan = np.asarray(picture.tan_half_fov)
    z, rate_z = -p[..., 2:], -w[..., 2:]
    e = 1.0 - 2.0 * BORDER_PX / picture.size
    gap = np.concatenate([e * z - p[..., :2] / tan, e * z + p[..., :2] / tan], -1)
    rate = np.concatenate([e * rate_z - w[..., :2] / tan, e * rate_z + w[..., :2] / tan], -1)
    gap = np.concatenate([gap, z - picture.near], -1)
    rate = np.concatenate([rate, rate_z], -1)
    leave = np.where(rate < 0.0, gap / np.where(rate < 0.0, -rate, 1.0), FAR_REACH * z)
    return np.asarray(np.minimum(leave.min(-1), FAR_REACH * z[..., 0]))


def march_fraction(x: Array, growth: float) -> Array:
    return np.asarray(x * (1.0 - growth + growth * x))


def _inverse_depths(
    x: Array, slack: float, inverse: tuple[Array, Array], growth: float
) -> tuple[Array, Array]:
    change = inverse[1] - inverse[0]
    own = inverse[0] + march_fraction(x, growth) * change
    reach = slack * (1.0 - growth + 2.0 * growth * x) * np.abs(change)
    lowest, highest = np.minimum(*inverse), np.maximum(*inverse)
    return np.maximum(own - reach, lowest), np.minimum(own + reach, highest)


def _march(
    picture: Picture,
    p: Array,
    n: Array,
    w: Array,
    u: Array,
    estimator: Estimator,
    reach: Array | float = np.inf,
    end_plane: tuple[Array, Array] | None = None,
) -> tuple[Indices, Flags]:
    reach = np.minimum(reach, estimator.radius)
    reach = np.minimum(reach, distance_in_frame(picture, p, w))
    end = p + reach[..., None] * w
    start_px, end_px = picture.pixel(p), picture.pixel(end)
    inverse = -1.0 / p[..., 2], -1.0 / end[..., 2]
    decide = Decisions(u.shape)
    blocker = np.full((*u.shape, 2), -1, np.int64)
    for i in range(estimator.steps):
        last = i == estimator.steps - 1
        stride = 1.0 / max(estimator.steps - 1, 1)
        x = np.ones_like(u) if last else (i + u) * stride

        live = blocker[..., 0] < 0
        s = march_fraction(x, estimator.growth)[..., None]
        texel = decide.texel(start_px + s * (end_px - start_px), live)
        front = _inverse_depths(x, estimator.front_slack * stride, inverse, estimator.growth)
        back = _inverse_depths(x, estimator.back_slack * stride, inverse, estimator.growth)
        span = np.minimum(*front), np.maximum(*back)
        hit = _surface_tests(picture, p, n, texel, span, estimator, decide, live, True, end_plane)
        blocker = np.where((live & hit)[..., None], texel, blocker)
    return blocker, decide.unsure


def _point(
    picture: Picture, p: Array, n: Array, w: Array, u: Array, estimator: Estimator
) -> tuple[Indices, Flags]:
    has_end = estimator.kind == "hemisphere"
    endless = estimator.radius > FAR_REACH * -p[..., 2]
    reach = np.where(endless, distance_in_frame(picture, p, w), estimator.radius)
    s_vs = p + (reach * (np.sqrt(u) if has_end else u))[..., None] * w
    decide = Decisions(u.shape)
    visible = -s_vs[..., 2] > picture.near
    s_vs = np.where(visible[..., None], s_vs, [0.0, 0.0, -1.0])
    px = picture.pixel(s_vs)
    inside = visible & np.all((px >= 0.0) & (px < picture.size), -1)
    near_frame = np.all((px > -1.0) & (px < picture.size + 1.0), -1)
    texel = decide.texel(px, visible & near_frame)
    texel = np.clip(texel, 0, picture.size.astype(np.int64) - 1)
    inverse_z = -1.0 / s_vs[..., 2]
    hit = _surface_tests(
        picture, p, n, texel, (inverse_z, inverse_z), estimator, decide, inside, has_end
    )
    return np.where((inside & hit)[..., None], texel, -1), decide.unsure


def sample(picture: Picture, texel: Indices, pixel: Indices, estimator: Estimator) -> Samples:
    """Run an estimator.

    Parameters
    ----------
    texel : (n, 2)
        Receivers, texels of the frame; not background.
    pixel : (n, 2)
        The same, pixels of the estimator's image: they choose the sample set.
    """
    first = BAYER[pixel[:, 1] % 4, pixel[:, 0] % 4] * estimator.directions
    index = first[:, None] + np.arange(estimator.directions)
    u = kronecker_points(index, estimator.offset)
    if estimator.kind == "rgs09":
        local = uniform_hemisphere(u[..., :2])
        share = local[..., 2] * 2.0 / estimator.directions
    else:
        local = cosine_hemisphere(u[..., :2])
        share = np.full(index.shape, 1.0 / estimator.directions)
    axes = frame_from_z(picture.shading[texel[:, 1], texel[:, 0]])
    w = np.einsum("nij,ndj->ndi", axes, local)
    p = np.broadcast_to(picture.position(texel)[:, None], w.shape)
    n = np.broadcast_to(picture.geometric[texel[:, 1], texel[:, 0]][:, None], w.shape)
    # Mirrored above the tangent plane.
    w = w - 2.0 * np.minimum(np.einsum("ndi,ndi->nd", w, n), 0.0)[..., None] * n
    run = _march if estimator.kind == "march" else _point
    blocker, unsure = run(picture, p, n, w, u[..., 2], estimator)
    return Samples(blocker, w, share, unsure)


def rectangle_visibility(
    picture: Picture,
    texel: Indices,
    estimator: Estimator,
    corner: Array,
    edge_u: Array,
    edge_v: Array,
) -> tuple[Array, Flags]:
    """Return what arrives of a two-sided rectangle's light, in [0, 1], and unsure flags.

    Directions are aimed at points of the rectangle, each with weight cos cos' / d^2.
    """
    first = BAYER[texel[:, 1] % 4, texel[:, 0] % 4] * estimator.directions
    index = first[:, None] + np.arange(estimator.directions)
    u = kronecker_points(index, estimator.offset)
    p = np.broadcast_to(picture.position(texel)[:, None], u.shape)
    n, shading = (
        np.broadcast_to(normals[texel[:, 1], texel[:, 0]][:, None], u.shape)
        for normals in (picture.geometric, picture.shading)
    )
    to_light = corner + u[..., :1] * edge_u + u[..., 1:2] * edge_v - p
    distance = np.linalg.norm(to_light, axis=-1)
    w = to_light / distance[..., None]
    plane = np.cross(edge_u, edge_v) / np.linalg.norm(np.cross(edge_u, edge_v))
    side = np.where(((p - corner) @ plane)[..., None] < 0.0, -plane, plane)
    end_plane = side, np.einsum("...i,i", side, corner)
    weight = np.maximum(np.einsum("...i,...i", w, shading), 0.0)
    weight *= -np.einsum("...i,...i", w, side) / distance**2
    weight *= np.einsum("...i,...i", w, n) > 0.0
    blocker, unsure = _march(picture, p, n, w, u[..., 2], estimator, distance, end_plane)
    arrives = weight * (blocker[..., 0] < 0)
    total = weight.sum(1)
    share = np.where(total > 0.0, arrives.sum(1) / np.where(total > 0.0, total, 1.0), 1.0)
    return share, unsure & (weight > 0.0)


def visibility(samples: Samples) -> Array:
    """Return 1 - the share of blocked directions, (n,), at least 0."""
    return np.maximum(1.0 - (samples.share * samples.blocked).sum(1), 0.0)


def bounce_solid_angle(
    picture: Picture, texel: Indices, samples: Samples, sent: Array, hidden: float
) -> Array:
    """Return irradiance (n, 3) from blocking texels.

    `sent` (h, w, 3) is the radiance that each texel sends towards the camera's side;
    towards the other side it sends `hidden` times that.
    """
    q = np.maximum(samples.blocker, 0)
    p = picture.position(texel)[:, None]
    normal = picture.geometric[q[..., 1], q[..., 0]]
    faces = np.einsum("ndi,ndi->nd", normal, p - picture.position(q)) > 0.0
    weight = np.pi * samples.share * samples.blocked * np.where(faces, 1.0, hidden)
    return np.einsum("nd,ndc->nc", weight, sent[q[..., 1], q[..., 0]])


def bounce_rgs09(
    picture: Picture,
    texel: Indices,
    samples: Samples,
    sent: Array,
    radius: float,
    distance_clamp: float,
) -> Array:
    """Return irradiance (n, 3) by A_s cos cos / d^2 with A_s = pi R^2 / N."""
    q = np.maximum(samples.blocker, 0)
    to_sender = picture.position(q) - picture.position(texel)[:, None]
    d2 = np.maximum((to_sender**2).sum(-1), 1e-30)
    w = to_sender / np.sqrt(d2)[..., None]
    cos_r = np.maximum(np.einsum("ndi,ni->nd", w, picture.shading[texel[:, 1], texel[:, 0]]), 0.0)
    cos_s = np.maximum(-np.einsum("ndi,ndi->nd", w, picture.shading[q[..., 1], q[..., 0]]), 0.0)
    count = samples.w.shape[1]
    area = np.pi * radius**2 / count
    form = area * cos_r * cos_s / np.maximum(d2, (distance_clamp * radius) ** 2)
    return np.einsum("nd,ndc->nc", form * samples.blocked, sent[q[..., 1], q[..., 0]])

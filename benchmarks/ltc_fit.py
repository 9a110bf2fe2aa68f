"""Fits linearly transformed cosines to GGX, and says how well they fit.

E. Heitz, J. Dupuy, S. Hill, D. Neubelt, "Real-Time Polygonal-Light Shading with Linearly
Transformed Cosines", SIGGRAPH 2016. A clamped cosine, stretched by a matrix M, stands for
the lobe of each roughness and view: its integral over a polygon is that of the cosine over
the polygon stretched back.

    python -m benchmarks.ltc_fit [--write]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.math3d import FloatArray
from ssdo_gl.passes.lobe_tables import TABLE_SIZE
from ssdo_gl.passes.lobe_transforms import TABLE_FILE

# Samples along each side of the unit square, from either of the two lobes.
SIDE = 20
# The paper minimises the mean cube of the difference.
POWER = 3
ROUNDS = 60
# Narrower lobes have the shape of this one.
MIN_ALPHA = 2e-3


def lobe(w_out: FloatArray, w: FloatArray, alpha: FloatArray) -> FloatArray:
    """Return GGX times Smith times cosine, without Fresnel, for (C, 1, 3) and (C, S, 3)."""
    h = w_out + w
    h /= np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-30)
    a_2 = alpha**2
    d = a_2 / (np.pi * (a_2 * h[..., 2] ** 2 + h[..., 0] ** 2 + h[..., 1] ** 2) ** 2)
    c_out, c_in = w_out[..., 2], np.maximum(w[..., 2], 0.0)
    below = c_in * np.sqrt(a_2 + (1 - a_2) * c_out**2) + c_out * np.sqrt(a_2 + (1 - a_2) * c_in**2)
    return np.asarray(np.where(w[..., 2] > 0.0, d * 0.5 / np.maximum(below, 1e-30) * c_in, 0.0))


def visible_directions(
    w_out: FloatArray, alpha: FloatArray, u: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return directions (C, S, 3) behind visible normals, and their densities (C, S)."""
    stretched = w_out * np.stack([alpha, alpha, np.ones_like(alpha)], -1)
    stretched /= np.linalg.norm(stretched, axis=-1, keepdims=True)
    phi = 2.0 * np.pi * u[:, 0]
    z = 1.0 - u[:, 1] * (1.0 + stretched[..., 2])
    sine = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
    h = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], -1) + stretched
    h = h * np.stack([alpha, alpha, np.ones_like(alpha)], -1)
    h[..., 2] = np.maximum(h[..., 2], 1e-9)
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    w = 2.0 * np.sum(w_out * h, -1, keepdims=True) * h - w_out
    a_2 = alpha**2
    d = a_2 / (np.pi * (a_2 * h[..., 2] ** 2 + h[..., 0] ** 2 + h[..., 1] ** 2) ** 2)
    spread = np.sqrt(a_2 + (1 - a_2) * w_out[..., 2] ** 2)
    return w, d / (2.0 * (w_out[..., 2] + spread))


def transforms(parameters: FloatArray, axis: FloatArray) -> FloatArray:
    """Return M (C, 3, 3) of (m11, m22, m13) in the frame around the lobe's mean direction."""
    m11, m22, m13 = parameters.T
    zero, one = np.zeros_like(m11), np.ones_like(m11)
    inner = np.stack([m11, zero, m13, zero, m22, zero, zero, zero, one], -1).reshape(-1, 3, 3)
    x, z = axis[:, 0], axis[:, 2]
    frame = np.stack([z, zero, x, zero, one, zero, -x, zero, z], -1).reshape(-1, 3, 3)
    return np.asarray(frame @ inner)


def cosine_density(m: FloatArray, w: FloatArray) -> FloatArray:
    """Return the density at directions w (C, S, 3) of cosines transformed by m (C, 3, 3)."""
    inverse = np.linalg.inv(m)
    back = np.einsum("cij,csj->csi", inverse, w)
    length_2 = np.sum(back**2, -1)
    det = np.abs(np.linalg.det(inverse))[:, None]
    return np.asarray(
        np.maximum(back[..., 2], 0.0) / np.pi * det / np.maximum(length_2, 1e-30) ** 2
    )


def cosine_directions(m: FloatArray, u: FloatArray) -> FloatArray:
    """Return directions (C, S, 3) drawn from cosines transformed by m."""
    r, phi = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
    even = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - u[:, 0])], -1)
    w = np.einsum("cij,sj->csi", m, even)
    return np.asarray(w / np.linalg.norm(w, axis=-1, keepdims=True))


class Fit:
    """The fit of all nodes of the table at once."""

    def __init__(self) -> None:
        node = np.linspace(0.0, 1.0, TABLE_SIZE)
        roughness, cosine = np.meshgrid(node, np.clip(node, 2e-2, 1.0), indexing="ij")
        self.alpha = np.maximum(roughness.reshape(-1, 1) ** 2, MIN_ALPHA)
        cosine = cosine.reshape(-1, 1)
        self.w_out = np.stack([np.sqrt(1.0 - cosine**2), 0.0 * cosine, cosine], -1)
        place = (np.arange(SIDE) + 0.5) / SIDE
        self.u = np.stack(np.meshgrid(place, place), -1).reshape(-1, 2)
        self.seen, self.seen_density = visible_directions(self.w_out, self.alpha, self.u)
        value = lobe(self.w_out, self.seen, self.alpha)
        weight = value / np.maximum(self.seen_density, 1e-30)
        self.amount = weight.mean(axis=1)
        axis = (weight[..., None] * self.seen).mean(axis=1)
        axis[:, 1] = 0.0
        self.axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        self.seen_value = value / self.amount[:, None]

    def error(self, parameters: FloatArray) -> FloatArray:
        """Return the mean cubed difference of each node, by samples of both lobes."""
        m = transforms(parameters, self.axis)
        ours = cosine_density(m, self.seen)
        both = np.maximum(self.seen_density + ours, 1e-30)
        total = np.mean(np.abs(self.seen_value - ours) ** POWER / both, axis=1)
        w = cosine_directions(m, self.u)
        theirs = lobe(self.w_out, w, self.alpha) / self.amount[:, None]
        ours = cosine_density(m, w)
        h = self.w_out + w
        h /= np.maximum(np.linalg.norm(h, axis=-1, keepdims=True), 1e-30)
        a_2 = self.alpha**2
        d = a_2 / (np.pi * (a_2 * h[..., 2] ** 2 + h[..., 0] ** 2 + h[..., 1] ** 2) ** 2)
        spread = np.sqrt(a_2 + (1 - a_2) * self.w_out[..., 2] ** 2)
        density = np.where(w[..., 2] > 0.0, d / (2.0 * (self.w_out[..., 2] + spread)), 0.0)
        both = np.maximum(density + ours, 1e-30)
        total += np.mean(np.abs(theirs - ours) ** POWER / both, axis=1)
        return np.asarray(total)

    def run(self) -> FloatArray:
        """Return the matrices (C, 3, 3), by a search along each parameter in turn."""
        alpha = np.maximum(self.alpha[:, 0], 1e-3)
        parameters = np.stack([alpha, alpha, np.zeros_like(alpha)], -1)
        step = np.full(parameters.shape, 0.4)
        best = self.error(parameters)
        for _ in range(ROUNDS):
            for k in range(3):
                improved = np.zeros(len(best), bool)
                for sign in (1.0, -1.0):
                    moved = parameters.copy()
                    if k < 2:
                        moved[:, k] *= np.exp(sign * step[:, k])
                    else:
                        moved[:, k] += sign * step[:, k] * parameters[:, 0]
                    found = self.error(moved)
                    better = found < best
                    parameters[better], best[better] = moved[better], found[better]
                    improved |= better
                step[:, k] *= np.where(improved, 1.3, 0.5)
        return transforms(parameters, self.axis)


def table_of(m: FloatArray) -> NDArray[np.float32]:
    """Return the inverse matrices as the shader reads them, (roughness, cosine, 4).

    Of the five numbers of an inverse that are not 0 the middle one becomes 1.
    """
    inverse = np.linalg.inv(m)
    inverse /= inverse[:, 1:2, 1:2]
    numbers = np.stack([inverse[:, 0, 0], inverse[:, 0, 2], inverse[:, 2, 0], inverse[:, 2, 2]], -1)
    return numbers.reshape(TABLE_SIZE, TABLE_SIZE, 4).astype(np.float32)


def main(argv: Sequence[str] | None = None) -> None:
    """Fit, print how well, and write the table if asked to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help=f"replace {TABLE_FILE.name}")
    arguments = parser.parse_args(argv)
    fit = Fit()
    m = fit.run()
    ours = cosine_density(m, fit.seen)
    # Half the L1 distance of two densities: the largest share of light that may be misplaced.
    misplaced = 0.5 * np.mean(np.abs(fit.seen_value - ours) / fit.seen_density, axis=1)
    for row in range(1, TABLE_SIZE, 5):
        shares = misplaced.reshape(TABLE_SIZE, TABLE_SIZE)[row]
        print(
            f"roughness {row / (TABLE_SIZE - 1):.2f}: {shares.mean():.3f}, worst {shares.max():.3f}"
        )
    if arguments.write:
        np.save(TABLE_FILE, table_of(m), allow_pickle=False)


if __name__ == "__main__":
    main()

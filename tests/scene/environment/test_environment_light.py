"""Irradiance of environments against closed forms, quadrature and symmetry."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.environment.environment_kinds import (
    ConstantEnvironment,
    GradientEnvironment,
    MapEnvironment,
)
from ssdo_gl.scene.environment.environment_light import (
    clamped_cosine_overlap,
    irradiance,
    radiance_image,
)

GRADIENT = GradientEnvironment((1.0, 2.0, 3.0), (0.5, 0.4, 0.3), (0.1, 0.0, 0.2))
# Midpoint quadrature over a sphere of 400 x 800 patches: the kink of the clamped cosine
# costs an error of the order of a patch squared, 6e-5.
QUADRATURE = 1e-4
# Patches of 2.8 degrees against a smooth sky, see `environment_light`.
MAP_ERROR = 1e-3


def sphere_quadrature(rows: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Return directions (N, 3) and solid angles (N,) of lat-long patches."""
    polar_edges = np.linspace(0.0, np.pi, rows + 1)
    polar = 0.5 * (polar_edges[1:] + polar_edges[:-1])
    azimuth = (np.arange(2 * rows) + 0.5) * (np.pi / rows)
    p, a = np.meshgrid(polar, azimuth, indexing="ij")
    direction = np.stack([np.sin(p) * np.cos(a), np.cos(p), np.sin(p) * np.sin(a)], axis=-1)
    weight = np.repeat(-np.diff(np.cos(polar_edges))[:, None] * (np.pi / rows), 2 * rows, axis=1)
    return direction.reshape(-1, 3), weight.reshape(-1)


NORMALS = np.array([[0, 1, 0], [0, -1, 0], [1, 0, 0], [0.3, -0.5, 0.8], [-0.6, 0.6, -0.2]])
NORMALS = NORMALS / np.linalg.norm(NORMALS, axis=1, keepdims=True)


def test_constant_irradiance_is_pi_times_radiance() -> None:
    environment = ConstantEnvironment((0.2, 0.5, 2.0))
    expected = np.broadcast_to(np.pi * np.array([0.2, 0.5, 2.0]), NORMALS.shape)
    assert np.array_equal(irradiance(environment, NORMALS), expected)


def test_gradient_irradiance_agrees_with_quadrature() -> None:
    direction, weight = sphere_quadrature()
    radiance = GRADIENT.sample(direction) * weight[:, None]
    expected = np.maximum(NORMALS @ direction.T, 0.0) @ radiance
    assert irradiance(GRADIENT, NORMALS) == pytest.approx(expected, rel=QUADRATURE)


def test_overlap_of_clamped_cosines_has_its_known_values() -> None:
    # Aligned: the integral of cos^2 over a hemisphere; opposite: nothing;
    # perpendicular: sin over a quarter sphere.
    values = clamped_cosine_overlap(np.array([1.0, 0.0, -1.0]))
    assert values == pytest.approx([2.0 * np.pi / 3.0, 2.0 / 3.0, 0.0], abs=1e-12)


def test_gradient_equal_everywhere_is_constant() -> None:
    grey = (0.7, 0.7, 0.7)
    flat = irradiance(GradientEnvironment(grey, grey, grey), NORMALS)
    assert flat == pytest.approx(np.full(NORMALS.shape, np.pi * 0.7), rel=1e-12)


@pytest.mark.parametrize("size", [(1, 1), (2, 4), (5, 7), (64, 128), (200, 300)])
def test_a_constant_map_is_exact(size: tuple[int, int]) -> None:
    environment = MapEnvironment(np.full((*size, 3), 0.5, dtype=np.float32))
    assert irradiance(environment, NORMALS) == pytest.approx(0.5 * np.pi, rel=1e-12)


def test_a_map_of_the_gradient_agrees_with_its_closed_form() -> None:
    column = radiance_image(GRADIENT)[:, :1]
    environment = MapEnvironment(np.repeat(column, 512, axis=1).astype(np.float32))
    normals = np.random.default_rng(2).normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    exact = irradiance(GRADIENT, normals)
    assert irradiance(environment, normals) == pytest.approx(exact, rel=MAP_ERROR)


@pytest.mark.parametrize("rotation", [0.0, 90.0, 33.0, -400.0])
def test_a_coarse_map_agrees_with_quadrature_of_its_own_lookup(rotation: float) -> None:
    image = np.random.default_rng(3).random((3, 5, 3)).astype(np.float32)
    environment = MapEnvironment(image, rotation)
    direction, weight = sphere_quadrature()
    radiance = environment.sample(direction) * weight[:, None]
    expected = np.maximum(NORMALS @ direction.T, 0.0) @ radiance
    # Edges of the coarse texels fall inside quadrature patches: 1 / 400 of a texel row.
    assert irradiance(environment, NORMALS) == pytest.approx(expected, rel=3e-3)


def test_map_directions_follow_the_convention() -> None:
    # Four columns: +z|-x, -x|-z, -z|+x, +x|+z; two rows: up, down.
    image = np.arange(8, dtype=np.float32).reshape(2, 4, 1).repeat(3, axis=2)
    environment = MapEnvironment(image)

    def seen(x: float, y: float, z: float) -> float:
        direction = np.array([x, y, z]) / np.linalg.norm([x, y, z])
        return float(environment.sample(direction)[0])

    assert seen(-1, 1, 2) == 0.0
    assert seen(-1, 1, -2) == 1.0
    assert seen(1, 1, -2) == 2.0
    assert seen(1, 1, 2) == 3.0
    assert seen(1, -1, 2) == 7.0


def test_rotation_turns_the_image_counter_clockwise_from_above() -> None:
    image = np.zeros((4, 8, 3), dtype=np.float32)
    image[:, 6] = 1.0  # just clockwise of +x
    turned = MapEnvironment(image, 90.0).world_image()
    # Counter-clockwise from above takes +x to -z, the middle of the image.
    assert turned[0, 4].tolist() == [1.0, 1.0, 1.0]
    assert turned.sum() == image.sum()


def test_rotation_by_part_of_a_column_keeps_the_energy() -> None:
    image = np.random.default_rng(1).random((2, 8, 3)).astype(np.float32)
    turned = MapEnvironment(image, 10.0).world_image()
    assert turned.sum(axis=1) == pytest.approx(image.sum(axis=1), rel=1e-6)
    # 10 degrees are 2/9 of a column: each texel keeps 7/9 and takes 2/9 of the next.
    expected = 7 / 9 * image + 2 / 9 * np.roll(image, -1, axis=1)
    assert turned == pytest.approx(expected, rel=1e-6)


def test_radiance_images_show_what_the_environment_sends() -> None:
    assert radiance_image(ConstantEnvironment((1.0, 2.0, 3.0))).tolist() == [[[1.0, 2.0, 3.0]]]
    gradient = radiance_image(GRADIENT)
    assert gradient.shape == (256, 4, 3)
    # The first row's middle is 0.35 degrees from the zenith.
    assert gradient[0, 0] == pytest.approx(GRADIENT.zenith, rel=1e-3)
    assert gradient[-1, 0] == pytest.approx(GRADIENT.ground, abs=1e-3)

"""The sun of an image shines as a light of its own: as bright, where it was, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.environment import MapEnvironment, sun_apart, sun_note, turned_sun

HEIGHT, WIDTH = 128, 256
SKY = np.array([0.4, 0.5, 0.8], np.float32)
# Of a texel of 1.4 degrees, half of it to either side.
TEXEL = np.pi / HEIGHT
ROW, COLUMN = 40, 200


def sunny(level: float = 2e4, rows: int = 1) -> np.ndarray:
    """Return an even sky with a sun of so many texels a side."""
    image = np.tile(SKY, (HEIGHT, WIDTH, 1))
    image[ROW : ROW + rows, COLUMN : COLUMN + rows] = level * np.array([1.0, 0.9, 0.7])
    return image


def to_texel(row: float, column: float) -> np.ndarray:
    polar, azimuth = np.pi * row / HEIGHT, 2.0 * np.pi * (column / WIDTH - 0.5)
    sine = np.sin(polar)
    return np.array([sine * np.sin(azimuth), np.cos(polar), -sine * np.cos(azimuth)])


@pytest.mark.parametrize("rows", [1, 2])
def test_it_shines_from_where_it_was_and_as_brightly(rows: int) -> None:
    image = sunny(rows=rows)
    environment = sun_apart(image)
    assert environment.sun is not None
    middle = to_texel(ROW + rows / 2, COLUMN + rows / 2)
    assert np.dot(environment.sun.direction, -middle) > np.cos(0.1 * TEXEL)
    size = rows**2 * TEXEL**2 * np.sin(np.pi * (ROW + rows / 2) / HEIGHT)
    sun = (2e4 * np.array([1.0, 0.9, 0.7]) - SKY) * size
    np.testing.assert_allclose(environment.sun.irradiance, sun, rtol=1e-3)
    # A disk of as much solid angle.
    assert environment.sun.angle == pytest.approx(np.degrees(2.0 * np.sqrt(size / np.pi)), rel=0.01)
    np.testing.assert_array_equal(environment.image, np.tile(SKY, (HEIGHT, WIDTH, 1)))
    assert "a light of its own" in sun_note(environment)


@pytest.mark.parametrize("rows", [5, 9])
def test_a_lamp_that_is_wider_is_taken_whole(rows: int) -> None:
    """What stayed of it would light rooms by rays that seldom find it."""
    environment = sun_apart(sunny(level=400.0, rows=rows))
    assert environment.sun is not None
    assert environment.image.max() == SKY.max()
    middle = to_texel(ROW + rows / 2, COLUMN + rows / 2)
    assert np.dot(environment.sun.direction, -middle) > np.cos(0.3 * TEXEL)


def test_the_image_that_was_given_is_left_alone() -> None:
    image = sunny()
    before = image.copy()
    sun_apart(image)
    np.testing.assert_array_equal(image, before)


@pytest.mark.parametrize("turn", [0.0, 30.0, -200.0])
def test_it_turns_with_its_image(turn: float) -> None:
    sun = turned_sun(sun_apart(sunny(), turn))
    assert sun is not None
    found = MapEnvironment(sunny(), turn).sample(-np.array([sun.direction]))
    assert found.max() > 1e3


def softbox() -> np.ndarray:
    image = np.tile(0.1 * SKY, (HEIGHT, WIDTH, 1))
    image[30:50, 100:130] = 40.0
    return image


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((HEIGHT, WIDTH, 3), np.float32),
        np.ones((HEIGHT, WIDTH, 3), np.float32),
        np.ones((1, 1, 3), np.float32),
        np.eye(4, 8, dtype=np.float32)[..., None].repeat(3, axis=2),
        softbox(),
        # A star, which brings a hundredth of the light.
        sunny(level=30.0),
    ],
    ids=["black", "even", "one", "coarse", "lamp", "star"],
)
def test_what_is_no_sun_stays_in_the_image(image: np.ndarray) -> None:
    environment = sun_apart(image, name="studio.hdr")
    assert environment.sun is None and turned_sun(environment) is None
    assert environment.image is image
    assert sun_note(environment) == ""


def test_a_sun_at_the_zenith_is_found() -> None:
    image = np.tile(SKY, (HEIGHT, WIDTH, 1))
    image[0] = 2e4
    environment = sun_apart(image)
    assert environment.sun is not None
    assert environment.sun.direction[1] < -0.9999

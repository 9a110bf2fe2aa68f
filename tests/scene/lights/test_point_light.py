"""Point lights against what their definition says."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene.lights import PointLight

LIGHT = PointLight((1.0, 2.0, 3.0), (3.0, 6.0, 9.0))


def test_irradiance_falls_with_the_square_of_the_distance() -> None:
    points = np.array([[1.0, 0.0, 3.0], [1.0, -2.0, 3.0], [3.0, 0.0, 3.0]])
    up = np.tile([0.0, 1.0, 0.0], (3, 1))
    wanted = [6.0 / 4.0, 6.0 / 16.0, 6.0 / 8.0 * np.sqrt(0.5)]
    assert LIGHT.irradiance_at(points, up) == pytest.approx(wanted)


def test_rays_choose_it_by_its_flux_in_their_unit_of_length() -> None:
    own = LIGHT.emitter(np.array([1.0, 0.0, 3.0]), 2.0)
    assert own.place == pytest.approx([0.0, 1.0, 0.0])
    assert own.emitted == pytest.approx([0.75, 1.5, 2.25])
    assert own.power == pytest.approx(4.0 * np.pi * 1.5)


def test_a_sender_at_no_distance_does_not_count() -> None:
    assert LIGHT.sender_radiance(0.5) == pytest.approx(9.0 / (np.pi * 0.25))
    assert LIGHT.sender_radiance(0.0) == 0.0


def test_its_map_looks_all_around() -> None:
    view = LIGHT.shadow_view(lambda axes: (np.zeros(3), np.ones(3)), 2)
    assert (LIGHT.map_faces, view.half_size, len(view.parts)) == (6, (1.0, 1.0), 1)
    assert view.origin_ws == pytest.approx(LIGHT.position)

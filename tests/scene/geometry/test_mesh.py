"""Meshes: the box around what is drawn of one."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl.scene.geometry.mesh import Mesh

# The last vertex belongs to no triangle.
POSITIONS = np.array([[1.0, -2, 3], [0, 5, 0], [-4, 1, 1], [99, 99, 99]])


def test_bounds_hold_what_is_drawn_and_no_more() -> None:
    low, high = Mesh(POSITIONS, np.array([[0, 1, 2]])).bounds()
    assert low.tolist() == [-4.0, -2.0, 0.0]
    assert high.tolist() == [1.0, 5.0, 3.0]


def test_bounds_are_found_out_once_and_cannot_be_spoilt() -> None:
    mesh = Mesh(POSITIONS, np.array([[0, 1, 2]]))
    assert mesh.bounds()[0] is mesh.bounds()[0]
    with pytest.raises(ValueError, match="read-only"):
        mesh.bounds()[1][0] = 7.0
    larger = dataclasses.replace(mesh, positions=2.0 * POSITIONS)
    assert larger.bounds()[0].tolist() == [-8.0, -4.0, 0.0]

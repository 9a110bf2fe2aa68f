"""Emitters that show an image: cells tile them, and know how bright they are."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from passes.pass_harness import make_scene, quad

from ssdo_gl.raytracing.bvh import build_bvh
from ssdo_gl.raytracing.emitter_images import LEAST, MOST_CELLS
from ssdo_gl.raytracing.emitter_tables import EmitterTables, emitter_tables
from ssdo_gl.raytracing.emitter_tree import emitter_tree
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.material import Material, Texture

CORNER, EDGE_U, EDGE_V = np.array([[-1.0, 0.0, 2.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


UVS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def panel(pixels: np.ndarray) -> tuple[EmitterTables, float]:
    """Return tables of a panel that emits 2 times the image, and half the scene's diagonal."""
    shown = Texture(np.dstack([pixels, np.ones(pixels.shape[:2])]).astype(np.float32))
    mesh = dataclasses.replace(quad(CORNER, EDGE_U, EDGE_V), uvs=UVS)
    glow = Material(albedo=(0.0,) * 3, emission=(2.0,) * 3, emission_texture=shown)
    scene = make_scene([mesh], materials=[glow], objects=[SceneObject(0, 0)])
    bvh = build_bvh(scene)
    return emitter_tables(bvh, scene), bvh.triangles.half_diagonal


def test_cells_tile_the_panel() -> None:
    pixels = np.zeros((32, 32, 3))
    pixels[:16, :16] = 1.0
    tables, unit = panel(pixels)
    rows = tables.entries.astype(float)
    assert len(rows) == MOST_CELLS**2
    assert rows[:, 2, 3].sum() * unit**2 == pytest.approx(2.0, rel=1e-5)
    assert rows[:, 1, 3].sum() == pytest.approx(1.0, rel=1e-5)
    # Each is where its part of the image is.
    middle = rows[:, 0, :3] + 0.5 * (rows[:, 1, :3] + rows[:, 2, :3])
    origin = rows[0, 0, :3]
    place = (middle - origin) @ np.stack([EDGE_U / 4.0, EDGE_V]).T * unit
    uv = rows[:, 4, :2] + 0.5 * (rows[:, 4, 2:] + rows[:, 5, :2])
    assert np.abs(uv - uv[0] - (place - place[0])).max() < 1e-5


def test_power_is_that_of_the_image() -> None:
    pixels = np.zeros((32, 32, 3))
    pixels[8:16, 4:8] = 1.0
    tables, _ = panel(pixels)
    rows = tables.entries
    bright = rows[:, 5, 3] > 0.5
    assert bright.sum() == (MOST_CELLS // 4) * (MOST_CELLS // 8)
    # What lies between points that were asked may shine, too.
    assert rows[:, 5, 3].min() >= 0.9 * LEAST * pixels.mean()
    tree = emitter_tree(rows)
    powers = tree.nodes[2**tree.levels - 1 :, 2, 3]
    shares = powers[tree.leaves[bright]].sum() / powers.sum()
    # Their neighbours' colours reach half a texel over. Without the image it is 3 %.
    assert shares > 0.75


def test_without_an_image_nothing_is_cut() -> None:
    mesh = quad(CORNER, EDGE_U, EDGE_V)
    scene = make_scene(
        [mesh], materials=[Material(emission=(1.0,) * 3)], objects=[SceneObject(0, 0)]
    )
    tables = emitter_tables(build_bvh(scene), scene)
    assert len(tables.entries) == 1 and tables.entries[0, 5, 3] == 1.0


def test_an_image_of_one_colour_is_not_cut() -> None:
    tables, _ = panel(np.full((8, 8, 3), 0.5))
    assert len(tables.entries) == 1 and tables.entries[0, 5, 3] == pytest.approx(0.5, rel=0.05)

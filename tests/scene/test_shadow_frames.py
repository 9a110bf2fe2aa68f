"""Where shadow maps look from and where they lie in the atlas."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.scene import shadow_frames as shadow_frames_module
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.shadow_frames import (
    FACE_FROM_LIGHT,
    atlas_layout,
    shadow_frames,
)

POINT = PointLight((1, 2, 3), (1, 1, 1))
SPOT = SpotLight((1, 2, 3), (0.6, -0.8, 0.0), (1, 1, 1), 10, 40)
WIDE_SPOT = SpotLight((1, 2, 3), (0.0, -1.0, 0.0), (1, 1, 1), 10, 80)
SUN = DirectionalLight((0.0, -0.6, 0.8), (1, 1, 1))
PANEL = RectangleLight((-1, 3, -1), (2, 0, 0), (0, 0, 4), (1, 1, 1))
BOTH = RectangleLight((-1, 3, -1), (2, 0, 0), (0, 0, 4), (1, 1, 1), two_sided=True)
OFF = PointLight((0, 0, 0), (1, 1, 1), shadow="none")
ARRIVING = PointLight((0, 0, 0), (1, 1, 1), shadow="ssdo")
EVERYTHING = (POINT, OFF, SPOT, WIDE_SPOT, SUN, PANEL, ARRIVING, BOTH, SPOT, SUN)


def bounds_of(axes):
    """The corners of [-1, 1] x [0, 2] x [-5, 5] along other axes."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (0, 2) for z in (-5, 5)]) @ axes.T
    return corners.min(axis=0), corners.max(axis=0)


def test_faces_by_kind():
    assert [light.face_count for light in EVERYTHING] == [6, 0, 1, 5, 1, 5, 0, 6, 1, 1]


def test_face_axes_are_orthonormal_and_cover_all_directions():
    for axes in FACE_FROM_LIGHT:
        np.testing.assert_array_equal(axes @ axes.T, np.eye(3))
    looks = {tuple(axes[2]) for axes in FACE_FROM_LIGHT}
    assert looks == {(0, 0, 1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, -1)}


@pytest.mark.parametrize("count", range(11))
def test_tiles_never_overlap_and_fill_the_atlas_well(count):
    lights = EVERYTHING[:count]
    layout = atlas_layout(lights)
    taken = set()
    for light, tile in zip(lights, layout.tiles, strict=True):
        assert (tile is None) == (light.face_count == 0)
        if tile is not None:
            span = light.tile_span
            for x in range(light.face_count * span):
                for y in range(span):
                    place = tile[0] + x, tile[1] + y
                    assert place not in taken
                    assert place[0] < layout.columns
                    assert place[1] < layout.rows
                    taken.add(place)
    # Lights whose faces stay together leave gaps: half the atlas or four rows at most.
    assert layout.columns * layout.rows <= 2 * len(taken) + 4 * layout.columns


def halvings(layout):
    """Return how often faces are halved until an atlas of one tile holds all."""
    return (layout.side - 1).bit_length()


def test_maps_of_fewer_lights_are_no_coarser():
    rng = np.random.default_rng(0)
    for _ in range(300):
        lights = rng.choice(np.array(EVERYTHING, object), rng.integers(2, 13))
        fewer = lights[rng.random(len(lights)) < 0.6]
        assert halvings(atlas_layout(fewer)) <= halvings(atlas_layout(lights))


def test_the_atlas_is_no_larger_than_its_faces_where_they_fit():
    # 12 x 8 tiles, were it as square as can be.
    layout = atlas_layout([POINT, POINT, SPOT])
    assert (layout.columns, layout.rows) == (16, 4)


def test_no_more_is_tried_once_an_atlas_is_nearly_full(monkeypatch):
    tried = []

    def noting(sizes, order, columns):
        tried.append(columns)
        return placed(sizes, order, columns)

    placed = shadow_frames_module._placed
    monkeypatch.setattr(shadow_frames_module, "_placed", noting)
    atlas_layout([POINT] * 997)
    # Two orders of nine widths each, were all tried.
    assert tried == [155, 155, 156]


def test_sharp_shadows_have_larger_faces():
    assert [light.tile_span for light in (POINT, SPOT, WIDE_SPOT, SUN, PANEL)] == [2, 4, 2, 4, 1]


@pytest.mark.parametrize("light", [SPOT, SUN, PANEL, BOTH, POINT])
def test_axes_are_a_rotation_onto_where_the_light_shines(light):
    axes = light.axes()
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    if isinstance(light, RectangleLight):
        np.testing.assert_allclose(axes @ [0, -1, 0], [0, 0, 1], atol=1e-15)
        assert (axes @ light.edge_v)[2] == pytest.approx(0.0, abs=1e-15)
    elif not isinstance(light, PointLight):
        np.testing.assert_allclose(axes @ light.direction, [0, 0, 1], atol=1e-15)


def test_a_light_without_area_has_axes_all_the_same():
    sliver = RectangleLight((0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 1, 1))
    np.testing.assert_array_equal(sliver.axes(), np.eye(3))


def test_the_map_of_the_sun_encloses_the_scene():
    (frame,) = shadow_frames([SUN], bounds_of)
    assert frame.is_parallel
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (0, 2) for z in (-5, 5)])
    seen = (corners - frame.origin_ws) @ frame.light_from_world.T
    assert np.all(np.abs(seen[:, :2]) <= frame.half_size)
    assert seen[:, 2].min() >= 0.0
    assert seen[:, 2].max() <= frame.depth
    # ... and little more: 1e-3 around it.
    assert np.abs(seen[:, 0]).max() > 0.998 * frame.half_size[0]


@pytest.mark.parametrize("flat", [np.zeros(3), np.array([3.0, 0.0, 0.0])])
def test_the_map_of_the_sun_of_a_flat_scene_is_not_degenerate(flat):
    (frame,) = shadow_frames([SUN], lambda axes: (-flat, flat))
    assert min(*frame.half_size, frame.depth) > 0.0


@pytest.mark.parametrize("parts_per_side", [1, 2, 3])
def test_parts_of_a_rectangle_tile_it(parts_per_side):
    (frame,) = shadow_frames([PANEL], bounds_of, parts_per_side)
    assert frame.parts_per_side == parts_per_side
    np.testing.assert_allclose(frame.origin_ws, [0, 3, 1])
    centres = frame.origin_ws + frame.parts
    np.testing.assert_allclose(centres.mean(axis=0), frame.origin_ws, atol=1e-15)
    x = [-1 + 2 * (i + 0.5) / parts_per_side for i in range(parts_per_side)]
    z = [-1 + 4 * (i + 0.5) / parts_per_side for i in range(parts_per_side)]
    # Row by row: the first edge runs fastest.
    np.testing.assert_allclose(centres, [[a, 3, b] for b in z for a in x])


def test_a_spot_fills_its_single_face():
    narrow, wide = shadow_frames([SPOT, WIDE_SPOT], bounds_of)
    assert narrow.half_size[0] == pytest.approx(np.tan(np.radians(40)))
    assert wide.half_size == (1.0, 1.0)

"""Rectangle lights: sides, parts, body, and which of them are one body."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from ssdo_gl import math3d
from ssdo_gl.math3d import Vector
from ssdo_gl.scene.geometry import shapes
from ssdo_gl.scene.lights import PointLight, RectangleLight
from ssdo_gl.settings.fields import SettingError

# Emits downwards.
LIGHT = RectangleLight((0.0, 2.0, 3.0), (2.0, 0.0, 0.0), (0.0, 0.0, 1.0), (3.0, 6.0, 9.0))


def test_rectangle_is_placed_by_its_centre() -> None:
    assert LIGHT.place == (1.0, 2.0, 3.5)


@pytest.mark.parametrize("edge_v", [(0.0, 0.0, 0.0), (-4.0, 0.0, 0.0)])
def test_what_is_seen_without_an_area_is_refused(edge_v: Vector) -> None:
    flat = dataclasses.replace(LIGHT, edge_v=edge_v)
    with pytest.raises(SettingError, match=r"edge_u = .*, edge_v = .*: expected edges that span"):
        flat.body()


def test_far_away_it_is_a_point() -> None:
    """Radiance times area times both cosines over the distance squared."""
    below, up = np.array([[1.0, -98.0, 3.5]]), np.array([[0.0, 1.0, 0.0]])
    assert LIGHT.irradiance_at(below, up) == pytest.approx([6.0 * 2.0 / 1e4], rel=1e-3)
    assert LIGHT.irradiance_at(below + (0.0, 200.0, 0.0), up) == pytest.approx([0.0])


def test_parts_of_its_map_lie_evenly_on_it() -> None:
    view = LIGHT.shadow_view(lambda axes: (np.zeros(3), np.ones(3)), 2)
    places = view.origin_ws + view.parts
    assert sorted(map(tuple, places)) == [
        (0.5, 2.0, 3.25), (0.5, 2.0, 3.75), (1.5, 2.0, 3.25), (1.5, 2.0, 3.75)
    ]  # fmt: skip


def test_a_visible_one_is_seen_where_it_is() -> None:
    body = LIGHT.body()
    assert body is not None
    corners = math3d.transform_points(body.world_from_object, shapes.quad().positions)
    assert {tuple(c) for c in corners} == {tuple(c) for c in LIGHT.outline()}
    assert body.material.emission == LIGHT.radiance
    assert dataclasses.replace(LIGHT, visible=False).body() is None


def test_parts_of_one_body_differ_in_place_size_brightness_and_shadow() -> None:
    def shares(**changes: object) -> bool:
        return LIGHT.can_share_body(dataclasses.replace(LIGHT, **changes))

    assert shares(corner=(9.0, 9.0, 9.0), edge_u=(1.0, 0.0, 0.0), radiance=(1.0, 1.0, 1.0))
    assert not shares(name="other")
    assert not shares(visible=False)
    assert shares(shadow="none")
    point = PointLight((0, 0, 0), (1, 1, 1))
    assert not LIGHT.can_share_body(point)
    assert not point.can_share_body(point)


@pytest.mark.parametrize(("two_sided", "faces"), [(False, 5), (True, 6)])
def test_a_side_that_emits_needs_faces(two_sided: bool, faces: int) -> None:
    assert dataclasses.replace(LIGHT, two_sided=two_sided).map_faces == faces

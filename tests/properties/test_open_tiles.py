"""Tiles that are taken to be open are, whatever sheets are in view and however they stand."""

from __future__ import annotations

import importlib.resources
import shutil

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from properties.planned_and_full import BOX, QUAD, at, compare, make_scene, turned

from ssdo_gl import resources
from ssdo_gl.gpu.readback import read_texture
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.passes.open_tiles import OpenTilesPass
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.environment import GradientEnvironment
from ssdo_gl.scene.light import PointLight

# 10 x 6 tiles.
SIZE = (160, 96)
# The same in every run; each takes a third of a second.
EXAMPLES = 30
LIGHT = PointLight((1.5, 3.0, 2.5), (20.0, 20.0, 20.0))

DAWN = GradientEnvironment((0.5, 0.6, 0.7), (0.9, 0.5, 0.3), (0.2, 0.2, 0.2))


def sheet(x, y, z, turn, side=5.0):
    """Return a square about its centre."""
    middle = at(-0.5 * side, -0.5 * side, 0.0) @ np.diag([side, side, 1.0, 1.0])
    return QUAD, at(x, y, z) @ turned(*turn) @ middle


FLOOR, WALL = sheet(0, -1, 0, (-90.0, 0.0, 0.0)), sheet(0, 0, -1, (0.0, 0.0, 0.0))
CORNER = (FLOOR, WALL, sheet(-1.2, 0, 0, (0.0, 90.0, 0.0)))
# Stands free in front of the wall, nearer to it than a radius of .5.
SCREEN = sheet(0.5, 0.0, -0.6, (0.0, 0.0, 0.0), side=2.0)


def rendered(device, shaders, *sheets, environment=None, **more):
    chosen = {"size": SIZE, "samples": 64, "steps": 8, **more}
    camera = Camera((2.0, 1.5, 6.0), (0.0, -0.3, 0.0))
    scene = make_scene(*sheets, lights=[LIGHT], environment=environment, camera=camera)
    return compare(device, shaders, scene, **chosen)


@pytest.fixture
def seen_tiles(monkeypatch):
    """Collect what each run of the pass finds."""
    found: list[np.ndarray] = []
    execute = OpenTilesPass.execute

    def watched(self, context):
        execute(self, context)
        found.append(read_texture(context.target.color_attachments[0])[..., 0])

    monkeypatch.setattr(OpenTilesPass, "execute", watched)
    return found


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"resolution_scale": 0.5},
        {"method": "ssao", "estimator": "march"},
        {"radius": 0.1},
        {"radius": 1.2},
        {"steps": 2},
        {"filter": "none"},
    ],
)
def test_a_corner_of_large_sheets_is_looked_at_by_tiles(device, shaders, seen_tiles, more):
    # Visibility is not among them: for its sake the bounce would share a march.
    wanted = ("beauty", "bounce", "direct")
    found = rendered(device, shaders, *CORNER, wanted=wanted, **more)
    assert found.effects.open_tile_size == 16 and "open_tiles" in found.ran
    assert "open_tiles" not in found.ran_in_full
    # Some of them show the corner, some have the free middle of a sheet around them.
    assert len(seen_tiles) == 1 and 0.0 < seen_tiles[0].mean() < 1.0


def test_almost_open_tiles_are_not(device, shaders, seen_tiles):
    rendered(device, shaders, *CORNER, wanted=("beauty",))
    rendered(device, shaders, *CORNER, SCREEN, wanted=("beauty",))
    alone, crowded = seen_tiles
    assert np.all(crowded <= alone) and crowded.sum() < alone.sum()


@pytest.mark.parametrize(
    ("sheets", "more"),
    [
        # 4.99 radii along a side are 4 of a radius of 1.25, almost.
        ([sheet(0, -1, 0, (-90.0, 0.0, 0.0), 4.99), WALL], {"radius": 1.25}),
        ([FLOOR, WALL, (BOX, at(0.0, -0.5, 0.0))], {}),
        (CORNER, {"environment": DAWN}),
        (CORNER, {"wanted": ("beauty", "visibility")}),
        (CORNER, {"samples": 16}),
        (CORNER, {"estimator": "rgs09"}),
    ],
)
def test_where_they_would_gain_nothing_no_tiles_are_looked_at(device, shaders, sheets, more):
    found = rendered(device, shaders, *sheets, **{"wanted": ("beauty",), **more})
    assert found.effects.open_tile_size == 0 and "open_tiles" not in found.ran
    assert found.effects.bounce


turns = st.one_of(st.sampled_from([0.0, 90.0, 180.0, -45.0, 3.0]), st.floats(-180.0, 180.0))
places = st.floats(-1.5, 1.5, width=32)
poses = st.tuples(places, places, places, st.tuples(turns, turns, turns))


@settings(
    max_examples=EXAMPLES,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(
    others=st.lists(poses, min_size=1, max_size=4),
    radius=st.sampled_from([0.05, 0.2, 0.5, 0.5]),
    steps=st.sampled_from([2, 4, 8]),
    method=st.sampled_from(["ssao", "bounce"]),
)
def test_random_sheets_show_the_same_with_tiles(device, shaders, others, radius, steps, method):
    sheets = [sheet(x, y, z, turn, side=2.5) for x, y, z, turn in others]
    rendered(
        device, shaders, FLOOR, *sheets, wanted=("beauty",), radius=radius, steps=steps,
        method=method,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("margin", "without"),
    [
        # Depths up to where the ball begins, neighbours that are not looked at, and a wall
        # that counts as level with the floor.
        ("leaves + u_step_reach < b.nearest", "along * inverse_length - wide < b.nearest"),
        ("int(ceil(spread)) + 1", "0"),
        ("height + a.deviation + b.deviation < ball.min_height", "height < u_radius"),
    ],
)
def test_tiles_without_a_margin_show(device, tmp_path, margin, without):
    """Whoever takes a margin away is told by the comparison of images."""
    with importlib.resources.as_file(resources.folder("shaders")) as folder:
        shutil.copytree(folder, tmp_path / "shaders")
    path = tmp_path / "shaders" / "passes/open_tiles.frag"
    text = path.read_text()
    assert text.count(margin) == 1
    path.write_text(text.replace(margin, without))
    broken = ShaderLibrary(device.gl, tmp_path / "shaders")
    with pytest.raises(AssertionError, match="beauty"):
        # Smaller tiles: one alone is less than a radius.
        rendered(device, broken, *CORNER, SCREEN, wanted=("beauty",), size=(320, 192))

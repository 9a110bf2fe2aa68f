"""What each light sees, texel by texel, inside a room whose walls are known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from oracle.shadows import box_distance
from passes.pass_harness import box, make_frame, make_scene, quad, run_pass

from ssdo_gl.effects.shadows import shadow_map
from ssdo_gl.effects.shadows.map_faces import BORDER_TEXELS
from ssdo_gl.effects.shadows.shadow_map import (
    EMPTY_DEPTH,
    ShadowMapPass,
    ShadowMapSettings,
    TranslucentShadowsPass,
    tile_size,
)
from ssdo_gl.gpu.geometry import Geometry
from ssdo_gl.gpu.texture import make_texture
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import DirectionalLight, PointLight, RectangleLight, SpotLight
from ssdo_gl.scene.material import Material, Texture
from ssdo_gl.scene.shadow_frames import atlas_layout
from ssdo_gl.settings.settings import Settings

# Along the faces of a rectangle's map, of other maps, and of maps with one face.
TILE = 16
TEXELS = 2 * TILE
ONLY = 4 * TILE
LOW, HIGH = np.array([-1.0, -1.5, -2.0]), np.array([1.2, 1.0, 3.0])
ROOM = box(LOW, HIGH)
# Walls reach past the light, so they are cut close to it, where 1 / w is large: its
# rounding, interpolated to the far end of the wall, measures up to 2.2e-5.
Z_TOLERANCE = 4e-5
# The axes (u, v, depth) of each face in a light's own frame, written down by hand.
FACES = np.array(
    [
        [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(0, 1, 0), (0, 0, 1), (1, 0, 0)],
        [(0, 1, 0), (0, 0, 1), (-1, 0, 0)],
        [(0, 0, 1), (1, 0, 0), (0, 1, 0)],
        [(0, 0, 1), (1, 0, 0), (0, -1, 0)],
        [(1, 0, 0), (0, 1, 0), (0, 0, -1)],
    ],
    np.float64,
)


def atlas(gl, shaders, scene, **settings):
    """The atlas with row 0 at the bottom, where tiles are counted from."""
    shadow_map = ShadowMapPass(ShadowMapSettings(**{"resolution": TILE, **settings}))
    image = run_pass(gl, shaders, shadow_map, make_frame(scene))["shadow_atlas"]
    return image[::-1, :, 0]


def slopes(half, texels=TEXELS):
    """Slopes (u, v) at the texel centres of a face, its border included."""
    place = (np.arange(texels) + 0.5) / texels * 2.0 - 1.0
    place = place * half * texels / (texels - 2 * BORDER_TEXELS)
    u, v = np.meshgrid(place, place)
    return np.stack([u, v, np.ones_like(u)], -1)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_point_light_sees_the_room_on_six_faces(gl, shaders, scale):
    position = np.array([0.3, -0.4, 0.5])
    room = box(LOW * scale, HIGH * scale)
    light = PointLight(tuple(position * scale), (1, 1, 1))
    found = atlas(gl, shaders, make_scene([room], lights=[light]))
    assert found.shape == (TEXELS, 6 * TEXELS)
    for face, axes in enumerate(FACES):
        rays = slopes(1.0) @ axes
        wanted = box_distance(position, rays, LOW, HIGH) * scale
        tile = found[:, face * TEXELS : (face + 1) * TEXELS]
        np.testing.assert_allclose(tile, wanted, rtol=Z_TOLERANCE)


def test_spot_light_sees_its_cone(gl, shaders):
    light = SpotLight((0.0, 0.5, 0.0), (0.0, 0.0, -1.0), (1, 1, 1), 10, 35)
    found = atlas(gl, shaders, make_scene([ROOM], lights=[light]))
    assert found.shape == (ONLY, ONLY)
    # The frame's x and y may point anywhere around the axis: compare what is symmetric.
    rays = slopes(np.tan(np.radians(35)), ONLY) * [1, 1, -1]
    assert found[32, 32] == pytest.approx(2.0, rel=1e-2)
    wanted = [
        np.sort(box_distance((0, 0.5, 0), turned, LOW, HIGH).ravel())
        for turned in (rays, rays[..., [1, 0, 2]], rays * [-1, 1, 1], rays * [1, -1, 1])
    ]
    error = [np.abs(np.sort(found.ravel()) - w).max() for w in wanted]
    assert min(error) < 1e-4


@pytest.mark.parametrize("parts", [1, 2])
def test_rectangle_light_sees_the_room_from_each_part(gl, shaders, parts):
    # Emits along edge_u x edge_v = -y; its frame is x = +x, y = -y x x = +z ... by hand:
    light = RectangleLight((-0.4, 0.8, -0.6), (0.8, 0, 0), (0, 0, 1.2), (1, 1, 1))
    axes = np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0)], np.float64)
    found = atlas(
        gl, shaders, make_scene([ROOM], lights=[light]), resolution=TEXELS, parts_per_side=parts
    )
    assert found.shape == (TEXELS, 5 * TEXELS)
    size = TEXELS // parts
    for j in range(parts):
        for i in range(parts):
            at = (-0.4 + 0.8 * (i + 0.5) / parts, 0.8, -0.6 + 1.2 * (j + 0.5) / parts)
            for face in range(5):
                rays = slopes(1.25, size) @ FACES[face] @ axes
                wanted = box_distance(at, rays, LOW, HIGH)
                left, bottom = face * TEXELS + i * size, j * size
                tile = found[bottom : bottom + size, left : left + size]
                np.testing.assert_allclose(tile, wanted, rtol=Z_TOLERANCE)


def test_directional_light_sees_parallel_depth(gl, shaders):
    """A slab lit from above: its top at one depth, the floor at another, nothing beside."""
    slab = box((-0.5, 0.5, -0.5), (0.5, 0.6, 0.5))
    floor = quad((-1, 0, 1), (2, 0, 0), (0, 0, -2))
    light = DirectionalLight((0.0, -1.0, 0.0), (1, 1, 1))
    found = atlas(gl, shaders, make_scene([slab, floor], lights=[light]))
    # Bounds are 0..0.6, grown by 1e-3 of their extent.
    top = 0.0005 * 0.6
    assert found[32, 32] == pytest.approx(top, abs=1e-4)
    assert found[3, 3] == pytest.approx(top + 0.6, rel=1e-3)
    assert found[0, 0] == pytest.approx(EMPTY_DEPTH)
    # A quarter of the floor, which the border's two texels on each side make smaller.
    assert np.mean(found < 0.1) == pytest.approx(0.25 * (60 / 64) ** 2, abs=0.02)


def test_nothing_seen_is_farther_than_anything(gl, shaders):
    light = PointLight((10.0, 0.0, 0.0), (1, 1, 1))
    found = atlas(gl, shaders, make_scene([box((-1, -1, -1), (1, 1, 1))], lights=[light]))
    assert found[TEXELS // 2, TEXELS // 2] == np.float32(EMPTY_DEPTH)
    assert np.all(np.isfinite(found))


def test_a_light_does_not_see_its_own_body(gl, shaders):
    """A bulb around a point light, drawn for the camera, is no obstacle to its light."""
    bulb = box((-0.1, 0.1, -0.1), (0.1, 0.3, 0.1))
    lamp = box((-0.2, -0.5, -0.2), (0.2, -0.3, 0.2))
    light = PointLight((0.0, 0.2, 0.0), (1, 1, 1))
    alone = atlas(gl, shaders, make_scene([ROOM, lamp], lights=[light]))
    objects = [SceneObject(0, 0), SceneObject(1, 0), SceneObject(2, 0, light=0)]
    scene = make_scene([ROOM, lamp, bulb], objects=objects, lights=[light])
    np.testing.assert_array_equal(atlas(gl, shaders, scene), alone)
    # Face 4 looks down, onto the lamp.
    assert alone[16, 4 * TEXELS + 16] == pytest.approx(0.5, rel=Z_TOLERANCE)
    # To another light the bulb is an obstacle.
    objects[2] = SceneObject(2, 0, light=1)
    lights = [PointLight((0.0, 0.0, 0.0), (1, 1, 1)), light]
    scene = make_scene([ROOM, lamp, bulb], objects=objects, lights=lights)
    # Face 3 looks up; the first light's faces are the lowest row.
    up = atlas(gl, shaders, scene)[:TEXELS, 3 * TEXELS : 4 * TEXELS]
    assert up[16, 16] == pytest.approx(0.1, rel=Z_TOLERANCE)


def test_cut_outs_let_light_through(gl, shaders):
    card = quad((-0.5, 0.0, 0.5), (1, 0, 0), (0, 0, -1))
    colors = np.array([[1, 1, 1, a] for a in (0, 1, 1, 0)], np.float64)
    card = dataclasses.replace(card, colors=colors)
    light = PointLight((0.0, 0.5, 0.0), (1, 1, 1))
    scene = make_scene(
        [ROOM, card],
        materials=[Material(), Material(alpha_cutoff=0.5)],
        objects=[SceneObject(0, 0), SceneObject(1, 1)],
        lights=[light],
    )
    down = atlas(gl, shaders, scene)[:, 4 * TEXELS : 5 * TEXELS]
    # Face 4 looks along -y with u = z, v = x: the card's left half (x < 0) is cut out.
    assert down[24, 16] == pytest.approx(0.5, rel=1e-5)
    assert down[8, 16] > 1.5


def test_holes_of_an_image_lie_where_its_coordinates_put_them(gl, shaders):
    """Those of the material: the first of the mesh, or the second, which are turned around."""
    image = np.full((8, 8, 4), 255, np.uint8)
    image[:, :4, 3] = 0
    uvs = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    card = quad((-0.5, 0.0, 0.5), (1, 0, 0), (0, 0, -1))
    card = dataclasses.replace(card, uvs=uvs, second_uvs=1.0 - uvs)
    for second in (frozenset(), frozenset({"albedo"})):
        holed = Material(alpha_cutoff=0.5, albedo_texture=Texture(image), second_uvs=second)
        scene = make_scene(
            [ROOM, card],
            materials=[Material(), holed],
            objects=[SceneObject(0, 0), SceneObject(1, 1)],
            lights=[PointLight((0.0, 0.5, 0.0), (1, 1, 1))],
        )
        down = atlas(gl, shaders, scene)[:, 4 * TEXELS : 5 * TEXELS]
        solid, hole = (8, 24) if second else (24, 8)
        assert down[solid, 16] == pytest.approx(0.5, rel=1e-5)
        assert down[hole, 16] > 1.5


@pytest.mark.parametrize("seed", [0, 3])
def test_translucent_things_drawn_over_the_others_are_where_a_depth_test_puts_them(
    gl, shaders, seed
):
    pane = quad((-0.5, 0.0, 0.5), (1, 0, 0), (0, 0, -1))
    before = quad((-0.25, 0.2, 0.25), (0.5, 0, 0), (0, 0, -0.5))
    scene = make_scene(
        [ROOM, pane, before],
        materials=[Material(), Material(alpha=0.5, blends=True)],
        objects=[SceneObject(0, 0), SceneObject(1, 1), SceneObject(2, 0)],
        lights=[
            PointLight((0.0, 0.5, 0.0), (1, 1, 1)),
            RectangleLight((0.3, 0.6, 0), (0.1, 0, 0), (0, 0, 0.1), (1, 1, 1)),
        ],
    )
    settings, frame = ShadowMapSettings(resolution=TILE), make_frame(scene, seed=seed)
    geometry = Geometry(gl, scene)

    def drawn(item, **inputs):
        return next(iter(run_pass(gl, shaders, item, frame, inputs, geometry).values()))

    both = drawn(ShadowMapPass(settings))
    whole = drawn(ShadowMapPass(settings, whole_alone=True))
    found = drawn(TranslucentShadowsPass(settings, unread=frozenset()), whole_shadow_atlas=whole)
    geometry.release()
    assert np.array_equal(found, both)
    assert 100 < np.count_nonzero(whole != both) < 0.5 * whole.size


def test_frames_of_a_picture_draw_what_is_whole_once(monkeypatch):
    drawn = []
    original = ShadowMapPass.execute
    monkeypatch.setattr(
        ShadowMapPass,
        "execute",
        lambda self, context: (drawn.append(1), original(self, context))[1],
    )
    scene = make_scene(
        [ROOM, quad((-0.5, 0.0, 0.5), (1, 0, 0), (0, 0, -1))],
        materials=[Material(), Material(alpha=0.5, blends=True)],
        objects=[SceneObject(0, 0), SceneObject(1, 1)],
        lights=[PointLight((0.0, 0.5, 0.0), (1, 1, 1))],
    )
    settings = Settings("direct", size=(32, 18), antialias=4)
    with Renderer(scene, settings) as renderer:
        result = renderer.render(time_passes=True)
    assert [item.name for item in result.passes if "shadow" in item.name] == [
        "shadow_map",
        "translucent_shadows",
    ]
    assert len(drawn) == 1


def test_many_lights_share_the_largest_atlas():
    lights = [PointLight((0, 0, 0), (1, 1, 1))] * 20
    layout = atlas_layout(lights)
    settings = ShadowMapSettings(resolution=1024, max_atlas=4096)
    size = tile_size(settings, layout)
    assert size * layout.side <= 4096
    assert 2 * size * layout.side > 4096
    assert tile_size(settings, atlas_layout([])) == 1024


def test_maps_of_a_lamp_that_moves_are_drawn_into_the_last_one(monkeypatch):
    """No memory is asked for anew, and nothing of the last one is left."""
    made = []

    def noting(gl, size, *form):
        made.append(size)
        return make_texture(gl, size, *form)

    monkeypatch.setattr(shadow_map, "make_texture", noting)
    settings = Settings("direct", size=(32, 32), overrides={"shadow_map.resolution": 64})
    lamps = [PointLight((x, 0.5, 0.0), (1.0, 1.0, 1.0)) for x in (-0.6, -0.2, 0.2, 0.6)]
    first, *others = (
        make_scene([ROOM, box((-0.2, -0.6, 0.6), (0.2, -0.2, 1.0))], lights=(lamp,))
        for lamp in lamps
    )

    def picture(renderer):
        return renderer.render(("beauty",)).images["beauty"]

    with Renderer(first, settings) as renderer:
        picture(renderer)
        for scene in others:
            renderer.use_scene(scene)
            found = picture(renderer)
    assert len(made) == 1
    with Renderer(others[-1], settings) as renderer:
        np.testing.assert_array_equal(found, picture(renderer))
        renderer.use_scene(first)
        assert not np.array_equal(found, picture(renderer))

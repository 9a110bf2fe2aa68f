"""What metal and polish send on, by directions, in the surface cache.

`rays/surfel_lobes.glsl` and `rays/quarter_sums.glsl`, by way of `passes/surfel_sum.frag`,
`passes/surfel_mirrored.frag` and `passes/surfel_rest.frag`.
"""

from __future__ import annotations

import numpy as np
import pytest
from passes.cache_harness import Filled, fill
from shaders.harness import evaluate

from ssdo_gl.effects.tables.gloss_tables import TABLE_SIZE, reflectance_table
from ssdo_gl.passes.surfels import surfel_bounces
from ssdo_gl.passes.surfels.surfel_textures import SurfaceCacheSettings
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.geometry.mesh import Mesh, SceneObject
from ssdo_gl.scene.geometry.shapes import box, quad
from ssdo_gl.scene.lights import SpotLight
from ssdo_gl.scene.material import Material
from ssdo_gl.scene.scene import Scene

CAMERA = Camera((0.1, 0.0, 0.2), (0.0, 0.0, 0.0))
FEW = SurfaceCacheSettings(surfels=4096, texel=0.08, light_samples=64)
BLACK = Material(albedo=(0.0, 0.0, 0.0))
REFLECTANCE = 0.8
# Of the light of a spot that a smooth floor reflects, .06 to .15 as much goes back as on: lobes are
# no narrower than they are drawn. As if diffuse both walls receive the same.
BACK_BOUND = 0.17
# A lobe loses what would go below the surface, and wins by a fit to light from everywhere.
ENERGY_BOUND = 0.06
# Narrower lobes of layers are found by few rays of a surfel: .90 at a roughness of .1, .97 at .4.
LAYER_BOUND = 0.12
# The part of a lamp's light that metal sends elsewhere than its facets do: .19 and .12; .41 and .30
# with lobes of alpha .2 at least, half as if diffuse.
STRAY_BOUND = 0.22


def inward() -> Mesh:
    return Mesh(box().positions, box().triangles[:, ::-1])


def metal(roughness: float, emission: float = 0.0) -> Material:
    albedo = (REFLECTANCE,) * 3
    return Material(
        albedo=albedo, metallic=1.0, roughness=roughness, emission=(emission,) * 3, specular=1.0
    )


def lit_floor(device, shaders, floor: Material, walls: Material = BLACK) -> Filled:
    """Return the cache of a closed box of edge 1 with a floor under a slanting spot."""
    lift = np.eye(4)
    lift[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    lift[:3, 3] = quad_to_floor(lift[:3, :3])
    spot = SpotLight(
        position=(-0.25, 0.45, 0.0),
        direction=(0.25, -0.945, 0.0),
        intensity=(1.0, 1.0, 1.0),
        inner_angle=8.0,
        outer_angle=10.0,
    )
    objects = SceneObject(0, 0), SceneObject(1, 1, lift[None])
    scene = Scene((inward(), quad()), (walls, floor), objects, CAMERA, (spot,))
    return fill(device, shaders, scene, FEW)


def quad_to_floor(turn: np.ndarray) -> np.ndarray:
    """Return what moves a turned quad onto the floor of the box, a little above it."""
    middle = turn @ (quad().positions.min(axis=0) + quad().positions.max(axis=0)) / 2.0
    return np.array([0.0, -0.495, 0.0]) - middle


def received(filled: Filled, axis: int, side: float) -> float:
    """Return the power that a wall of the box receives, per unit of its area, which is 1."""
    on_wall = side * filled.positions[:, axis] > 0.498
    on_wall &= np.abs(filled.positions).max(axis=1) < 0.5
    assert on_wall.sum() > 20
    return float(filled.irradiance[on_wall, 0].mean())


@pytest.mark.parametrize("roughness", [0.1, 0.4])
def test_a_metal_floor_sends_light_on_and_not_back(device, shaders, roughness) -> None:
    filled = lit_floor(device, shaders, metal(roughness))
    assert received(filled, 0, -1.0) < BACK_BOUND * received(filled, 0, 1.0)
    on_floor = np.abs(filled.positions[:, 1] + 0.495) < 1e-3
    arriving = 2.0 * filled.direct[on_floor, 0].mean()  # of two sides one is lit
    walls = ((0, -1.0), (0, 1.0), (2, -1.0), (2, 1.0), (1, 1.0))
    sent = sum(received(filled, *wall) for wall in walls)
    assert sent == pytest.approx(REFLECTANCE * arriving, rel=ENERGY_BOUND)


@pytest.mark.parametrize("roughness", [0.1, 0.4])
def test_a_polished_floor_sends_its_reflection_on_and_not_back(device, shaders, roughness) -> None:
    """A black dielectric one reflects at its surface alone: 4 % of what is so upright."""
    polish = Material(albedo=(0.0, 0.0, 0.0), roughness=roughness, specular=1.0)
    filled = lit_floor(device, shaders, polish)
    assert received(filled, 0, -1.0) < BACK_BOUND * received(filled, 0, 1.0)
    on_floor = np.abs(filled.positions[:, 1] + 0.495) < 1e-3
    arriving = 2.0 * filled.direct[on_floor, 0].mean()
    walls = ((0, -1.0), (0, 1.0), (2, -1.0), (2, 1.0), (1, 1.0))
    sent = sum(received(filled, *wall) for wall in walls)
    assert sent == pytest.approx(0.04 * arriving, rel=LAYER_BOUND)


@pytest.mark.parametrize("row", [3, 11, 17])
def test_a_layer_sends_what_it_reflects_at_any_angle(gl, shaders, row) -> None:
    """A lobe drawn wider than the layer's took less of Fresnel's share of low light: .76 of it."""
    cosines, roughness = np.array([0.1, 0.16, 0.3, 0.6, 1.0]), row / 31.0
    alpha = max(roughness**2, 0.05)
    u, v = np.random.default_rng(4).random((2, 20_000))
    cos_h = np.sqrt((1.0 - u) / (1.0 + (alpha**2 - 1.0) * u))
    sin_h = np.sqrt(1.0 - cos_h**2)
    h = np.stack([sin_h * np.cos(2 * np.pi * v), sin_h * np.sin(2 * np.pi * v), cos_h], axis=-1)
    density_h = alpha**2 * cos_h / (np.pi * (cos_h**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    includes = ["lib/octahedral.glsl", "lib/brdf.glsl", "rays/surfel_lobes.glsl"]
    lobe = f"lobe_of_quarter(vec4(w_in, 0), vec3(0, 0, 1), w_out, {roughness}, vec2(0.04, 1), 0.0)"
    sent = []
    for cosine in cosines:
        w_in = np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine])
        toward = h @ w_in
        w_out = 2.0 * toward[:, None] * h - w_in
        given = {"w_in": np.broadcast_to(w_in, h.shape), "w_out": w_out}
        found = evaluate(gl, shaders, includes, lobe, given, 1, defines={"GLOSSY": 1, "LOBES": 1})
        weight = w_out[:, 2] * 4.0 * toward / density_h
        sent.append((found[:, 0] * np.where((toward > 0.0) & (weight > 0.0), weight, 0.0)).mean())
    shares = reflectance_table()[row, :, :2] @ [0.04, 1.0]
    reflected = np.interp(cosines, np.linspace(0.0, 1.0, TABLE_SIZE), shares)
    np.testing.assert_allclose(sent, reflected, rtol=LAYER_BOUND)


@pytest.mark.parametrize("roughness", [0.32, 0.4])
def test_metal_mirrors_a_lamp_close_to_it(gl, shaders, roughness) -> None:
    """One that fills 25 degrees around its middle, as a bulb does in a shade."""
    rng, alpha = np.random.default_rng(5), roughness**2
    w_out = cosine_directions(rng, 4000)
    across = np.tan(np.radians(25.0)) * in_disk(rng, 400)
    lamp = np.array([0.6, 0.0, 0.8]) + across @ np.array([[0.8, 0.0, -0.6], [0.0, 1.0, 0.0]])
    lamp /= np.linalg.norm(lamp, axis=1, keepdims=True)
    weight = lamp[:, 2] / lamp[:, 2].sum()
    size = np.linalg.norm(weight @ lamp)
    spread = (1.0 - size**2) / (size * (3.0 - size**2))
    quarter = np.append(weight @ lamp / size, spread)
    exact = np.array([weight @ ggx(w, lamp, alpha) for w in w_out])
    includes = ["lib/octahedral.glsl", "lib/brdf.glsl", "rays/surfel_lobes.glsl"]
    lobe = f"lobe_of_quarter(quarter, vec3(0, 0, 1), w_out, {roughness}, vec2(1), 1.0)"
    given = {"w_out": w_out, "quarter": np.broadcast_to(quarter, (len(w_out), 4))}
    sent = evaluate(gl, shaders, includes, lobe, given, 1, defines={"GLOSSY": 1, "LOBES": 1})[:, 0]
    stray = 0.5 * np.abs(sent / sent.sum() - exact / exact.sum()).sum()
    assert stray < STRAY_BOUND, stray


def in_disk(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return points spread evenly over a disk of radius 1."""
    radius, turn = np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=1)


def cosine_directions(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return directions spread by the cosine about z."""
    flat = in_disk(rng, count)
    return np.column_stack([flat, np.sqrt(1.0 - (flat**2).sum(axis=1))])


def ggx(w_out: np.ndarray, w_in: np.ndarray, alpha: float) -> np.ndarray:
    """Return the BRDF of facets of F = 1, height-correlated (Heitz 2014)."""
    half = w_out + w_in
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    density = alpha**2 / (np.pi * (half[:, 2] ** 2 * (alpha**2 - 1.0) + 1.0) ** 2)
    rough = [np.sqrt(alpha**2 + (1.0 - alpha**2) * z**2) for z in (w_out[2], w_in[:, 2])]
    return density * 0.5 / (w_in[:, 2] * rough[0] + w_out[2] * rough[1])


@pytest.mark.parametrize("roughness", [0.05, 0.5])
def test_in_a_furnace_metal_is_as_bright_as_what_is_diffuse(device, shaders, roughness) -> None:
    scene = Scene((inward(),), (metal(roughness, emission=1.0),), (SceneObject(0, 0),), CAMERA)
    filled = fill(device, shaders, scene, FEW)
    inside = filled.direct[:, 0] > 0.0
    share = reflected_share(roughness)
    expected = np.pi / (1.0 - share)
    np.testing.assert_allclose(filled.irradiance[inside].mean(), expected, rtol=0.02)


@pytest.mark.parametrize("floor", [metal(0.2), Material(albedo=(0.5,) * 3, roughness=0.1)])
def test_bounces_end_where_more_of_them_change_nothing(device, shaders, monkeypatch, floor) -> None:
    """In a room all of metal, or with a polished floor: errors of light, RMS over its mean."""
    found = lit_floor(device, shaders, floor, walls=metal(0.2)).irradiance
    monkeypatch.setattr(surfel_bounces, "LOBE_TURNS", 12)
    monkeypatch.setattr(surfel_bounces, "LOBE_CHANGE", 0.0)
    monkeypatch.setattr(surfel_bounces, "LOBE_TOLERANCE", 1e-5)
    wanted = lit_floor(device, shaders, floor, walls=metal(0.2)).irradiance
    error = np.sqrt(np.mean((found - wanted) ** 2)) / wanted.mean()
    assert error < 0.005, error


def reflected_share(roughness: float) -> float:
    """Return what metal reflects of light from everywhere, by the fits of ``lib/brdf.glsl``."""
    r, f0 = roughness, REFLECTANCE
    once = 0.9998 + r * (-0.0143 + r * (0.3322 + r * (-2.2012 + r * 1.2952)))
    grazing = max(0.0494 + r * (-0.0181 + r * (-0.1335 + r * 0.1070)), 0.0)
    return (f0 * (once - grazing) + grazing) * (1.0 + f0 * (1.0 / once - 1.0))


def test_a_layer_comes_back_from_its_words(gl, shaders) -> None:
    rng = np.random.default_rng(2)
    normal = rng.normal(size=(500, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    roughness = rng.uniform(0.0, 1.0, 500)
    roughness[:2] = 0.0, 1.0
    layer = rng.uniform(0.0, 1.0, (500, 2))
    layer[:3] = [0.0, 0.0], [1.0, 1.0], [0.04, 1.0]
    given = {"normal": normal, "roughness": roughness, "layer": layer}
    packed = "unpacked_layer(packed_layer(LayerHit(normal, roughness, layer)))"
    defines = {"GLOSSY": 1, "LOBES": 1}
    includes = ["lib/octahedral.glsl", "lib/brdf.glsl", "rays/surfel_lobes.glsl"]

    def found(field: str, count: int) -> np.ndarray:
        return evaluate(gl, shaders, includes, f"{packed}.{field}", given, count, defines=defines)

    np.testing.assert_allclose(found("normal", 3), normal, atol=1e-4)
    np.testing.assert_allclose(found("roughness", 1)[:, 0], roughness, atol=1e-5)
    np.testing.assert_allclose(np.sqrt(found("layer", 2)), np.sqrt(layer), atol=2.1e-3)
    whole = evaluate(
        gl, shaders, includes, f"vec3(is_all_layer({packed}.layer), has_layer({packed}.layer), 0)",
        given, 3, defines=defines,
    )  # fmt: skip
    np.testing.assert_array_equal(whole[:3], [[0, 0, 0], [1, 1, 0], [0, 1, 0]])

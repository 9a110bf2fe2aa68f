"""Metal, mirrors and gloss: the invariants of every scene, and materials at their limits."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from hard_cases.hard_scene import quad, room, sphere, transformed
from hard_cases.invariants import difference, sane
from hard_cases.methods import METHODS, label, render
from hard_cases.test_light import dimmed
from hard_cases.test_scale_and_place import EXACT, FLIPPED_RMSE, MEAN_BOUND, turn

from ssdo_gl import math3d
from ssdo_gl.scene.geometry.mesh import SceneObject
from ssdo_gl.scene.lights import PointLight
from ssdo_gl.scene.material import Material, Texture

# Each method that draws gloss, with its first estimator: reflections march the same way
# whatever tells visibility.
GLOSSY = tuple(
    next(m for m in METHODS if m[0] == name)
    for name in ("direct", "ssdo", "bounce", "gi", "reference-near", "reference-gi")
)
IMAGES = ("beauty", "specular", "normal_ws")
RADIANCES = ("beauty", "specular")


def glossy(scene):
    """Return the room with a floor of plastic, a wall of copper, a mirror and a matt ball."""
    floor, wall, other, solids = scene.materials
    kinds = (
        dataclasses.replace(floor, specular=1.0, roughness=0.2),
        dataclasses.replace(wall, metallic=1.0, roughness=0.5),
        dataclasses.replace(other, metallic=1.0, roughness=0.0, albedo=(1.0, 1.0, 1.0)),
        dataclasses.replace(solids, specular=1.0, roughness=0.8),
    )
    return dataclasses.replace(scene, materials=kinds)


def images_of(method):
    return tuple(name for name in IMAGES if name != "specular" or method[0] != "reference-gi")


@pytest.fixture(scope="module")
def drawn(device, shaders):
    """Return a function that renders a scene by a method."""

    def images(scene, method, **settings):
        return render(device, shaders, scene, method, images=images_of(method), **settings)

    return images


@pytest.fixture(scope="module")
def base(drawn):
    """Return a function that renders the unmoved room once for each method."""
    return cache(lambda method: drawn(glossy(room()), method))


def radiances(images):
    return [name for name in RADIANCES if name in images]


@pytest.mark.parametrize("method", GLOSSY, ids=label)
def test_the_room_is_glossy(base, record, method):
    images = base(method)
    record("glossy room", label(method), sane(images), 0, "insane values")
    if "specular" in images:
        assert images["specular"].mean() > 0.1 * images["beauty"][..., :3].mean()


@pytest.mark.parametrize("method", GLOSSY, ids=label)
def test_scaling_by_a_power_of_two_changes_no_gloss(drawn, base, record, method):
    other = drawn(transformed(glossy(room()), math3d.scaling(2.0**13)), method)
    for name in radiances(other):
        rmse, _ = difference(base(method), other, name)
        record("gloss, scale x 2^13", label(method), rmse, EXACT, "rel. RMSE")


PLACES = {
    "scale x 1e-3": (lambda: math3d.scaling(1e-3), True),
    "offset by 1e5": (lambda: math3d.translation([1e5, -1e5, 1e5]), False),
    "turned with the camera": (turn, False),
}


@pytest.mark.parametrize("method", GLOSSY, ids=label)
@pytest.mark.parametrize("place", PLACES)
def test_place_and_scale_do_not_show_in_gloss(drawn, base, record, method, place):
    matrix, bake = PLACES[place]
    other = drawn(transformed(glossy(room()), matrix(), bake=bake), method)
    assert sane(other) == 0
    traces = method[0].startswith("reference") or method[0] == "gi"
    for name in radiances(other):
        if traces and place == "turned with the camera":
            check_means(record, place, method, base(method), other, name)
            continue
        rmse, _ = difference(base(method), other, name)
        record(f"gloss, {place}", label(method), rmse, FLIPPED_RMSE, "rel. RMSE")


def check_means(record, case, method, images, others, name):
    mean = images[name][..., :3].mean()
    gap = abs(others[name][..., :3].mean() - mean) / mean
    record(f"gloss, {case}: mean", label(method), gap, MEAN_BOUND["screen"], "rel. mean")


@pytest.mark.parametrize("method", GLOSSY, ids=label)
def test_a_mirrored_glossy_scene_gives_the_mirrored_image(drawn, base, record, method):
    mirror = np.diag([-1.0, 1.0, 1.0, 1.0])
    other = drawn(transformed(glossy(room()), mirror), method)
    flipped = {name: image[:, ::-1] for name, image in other.items()}
    for name in radiances(other):
        check_means(record, "mirrored", method, base(method), flipped, name)


@pytest.mark.parametrize("method", GLOSSY, ids=label)
def test_gloss_is_linear_in_the_light(drawn, base, record, method):
    exponent = 20
    other = drawn(glossy(dimmed(2.0**exponent)), method)
    for name in radiances(other):
        a = base(method)[name][..., :3].astype(float)
        b = other[name][..., :3] / 2.0**exponent
        gap = float(np.abs(a - b).max() / a.mean())
        record(f"gloss, light x 2^{exponent}", label(method), gap, EXACT, "relative")


@pytest.mark.parametrize("method", GLOSSY, ids=label)
def test_gloss_without_light_is_exactly_black(drawn, record, method):
    images = drawn(glossy(dimmed(0.0)), method)
    brightest = max(float(images[name][..., :3].max()) for name in radiances(images))
    record("gloss, no light", label(method), brightest, 0.0, "radiance")


METAL = Material(albedo=(1.0, 1.0, 1.0), metallic=1.0, roughness=0.0)
PLASTIC = Material(albedo=(0.6, 0.5, 0.4), specular=1.0, roughness=0.3)


def of(*materials):
    """Return the room of these materials in turn."""
    return room(materials=tuple(materials[i % len(materials)] for i in range(4)))


def facing_mirrors():
    """Two mirrors a hand's breadth apart, the eye and a matt ball between them."""
    scene = room()
    meshes = (
        quad((-4, -4, -1), (8, 0, 0), (0, 8, 0)),
        quad((4, -4, 3), (-8, 0, 0), (0, 8, 0)),
        sphere((0.45, 0.3, 0.1), 0.3),
    )
    return dataclasses.replace(
        scene,
        meshes=meshes,
        materials=(METAL, scene.materials[0]),
        objects=(SceneObject(0, 0), SceneObject(1, 0), SceneObject(2, 1)),
    )


def many_lights(count):
    """A mirror and plastic under so many points, as bright together as one of them alone."""
    places = np.random.default_rng(1).uniform((-0.9, 0.1, -0.9), (1.3, 1.5, 1.0), (count, 3))
    lights = (PointLight(tuple(p), (1.0 / count,) * 3, shadow="none") for p in places.tolist())
    return dataclasses.replace(of(METAL, PLASTIC), lights=tuple(lights), environment=None)


def texture(*values):
    """Return 8 x 8 texels of 0.5, in some of whose rows there are `values`, as float32."""
    pixels = np.full((8, 8, 4), 0.5, np.float32)
    for row, value in enumerate(values):
        pixels[2 * row, ::2] = value
    return Texture(pixels, is_data=True)


MAPS = (
    "albedo", "emission", "metallic_roughness", "specular", "specular_color", "normal",
    "occlusion",
)  # fmt: skip


def mapped(*names, values=(np.nan, np.inf, -np.inf)):
    """Return the room with faulty maps everywhere."""
    scene = of(dataclasses.replace(PLASTIC, emission=(0.1,) * 3, metallic=0.5))
    fields = {f"{name}_texture": texture(*values) for name in names}
    kinds = tuple(dataclasses.replace(m, **fields) for m in scene.materials)
    meshes = tuple(
        dataclasses.replace(mesh, uvs=mesh.positions[:, :2] + mesh.positions[:, 2:])
        for mesh in scene.meshes
    )
    return dataclasses.replace(scene, materials=kinds, meshes=meshes)


CASES = {
    "roughness 0": lambda: of(dataclasses.replace(PLASTIC, roughness=0.0)),
    "f0 = 1, roughness 0": lambda: of(METAL),
    "f0 = 1, roughness 1": lambda: of(dataclasses.replace(METAL, roughness=1.0)),
    "mirror facing mirror": facing_mirrors,
    "infinite index of refraction": lambda: of(dataclasses.replace(PLASTIC, ior=1e6)),
    "zero vectors in the normal map": lambda: mapped("normal", values=(0.5, 0.0)),
    "NaN and infinity in every map": lambda: mapped(*MAPS),
}


@pytest.mark.parametrize("method", GLOSSY, ids=label)
@pytest.mark.parametrize("case", CASES)
def test_glossy_images_stay_sane(drawn, record, method, case):
    images = drawn(CASES[case](), method, spp=2)
    record(f"gloss, {case}", label(method), sane(images), 0, "insane values")


@pytest.mark.parametrize("name", MAPS)
def test_faulty_texels_stay_where_they_are(drawn, record, name):
    """Rays of a path tracer meet the map everywhere: none brings anything insane along."""
    images = drawn(mapped(name), GLOSSY[-1], spp=2)
    record(f"NaN in the {name} map", label(GLOSSY[-1]), sane(images), 0, "insane values")


def check_many_lights(drawn, record, counts, method, mean, bound):
    few, many = (
        drawn(many_lights(n), method, spp=16, size=(32, 24))["beauty"][..., :3] for n in counts
    )
    assert np.isfinite(many).all()
    gap = abs(float(mean(many) / mean(few)) - 1.0)
    record(f"{counts[1]} lights in a mirror", label(method), gap, bound, "relative")


def test_more_lights_than_a_texture_has_rows_in_a_mirror(drawn, record):
    # The median: few paths meet a light from near by, and show it by chance. Over counts it
    # has a standard deviation of 2 %.
    check_many_lights(drawn, record, (500, 20_000), GLOSSY[-1], np.median, 0.06)


@pytest.mark.slow
@pytest.mark.parametrize("method", [m for m in GLOSSY if m[0] != "reference-near"], ids=label)
def test_a_hundred_thousand_lights_in_a_mirror(drawn, record, method):
    # Which of them stand near a surface, and are most of the mean, is a matter of chance.
    mean = np.median if method[0] == "reference-gi" else np.mean
    check_many_lights(drawn, record, (20_000, 100_000), method, mean, 0.06)

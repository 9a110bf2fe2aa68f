"""Deliberately broken shaders: for every class of fault, a check that notices it.

Each mutation changes a copy of the shaders as the fault would. Its check must pass with
the shaders as they are and fail with the copy; a check that cannot fail proves nothing.
"""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hard_cases import poison
from hard_cases.drawn import Directions
from hard_cases.hard_scene import quad, room, sphere, transformed
from hard_cases.invariants import difference
from hard_cases.methods import render
from hard_cases.test_depth import with_meshes
from hard_cases.test_energy import white_sky
from hard_cases.test_histories import history_keeps_fault
from hard_cases.test_precision import angle_between
from hard_cases.test_shadows import light_gets_under, plane_shadows_itself
from hard_cases.test_stability_in_time import orbit_scene
from passes.estimator_cases import corner
from shaders.harness import evaluate
from shaders.test_lights import LIGHT

from ssdo_gl import math3d, resources
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.lights import PointLight, RectangleLight

MARCH = ("bounce", "march")
RGS09 = ("bounce", "rgs09")


@dataclass(frozen=True)
class Mutation:
    """A fault: text to replace by file, and the check (error, bound) that notices it."""

    edits: Mapping[str, tuple[tuple[str, str], ...]]
    check: Callable[..., tuple[float, float]]


def scale_shows(device, shaders):
    """Relative change of the image where a scene shrinks to 1/1024: 0, bit by bit."""
    before = render(device, shaders, room(), MARCH, images=("visibility",))
    small = transformed(room(), math3d.scaling(2.0**-10))
    after = render(device, shaders, small, MARCH, images=("visibility",))
    return difference(before, after, "visibility")[0], 1e-6


def plane_is_occluded(device, shaders):
    """Occlusion that a single plane, seen at 85 degrees, finds on itself: none."""
    angle = np.radians(85.0)
    scene = with_meshes(
        quad((-500, 0, 500), (1000, 0, 0), (0, 0, -1000)),
        camera=Camera((0, 3 * np.cos(angle), 3 * np.sin(angle)), (0, 0, 0), up=(0, 0, -1)),
    )
    names = ("visibility", "depth")
    # By itself it would be known to be open, and nothing would be looked for.
    images = render(device, shaders, scene, MARCH, images=names, effects="full")
    return 1.0 - images["visibility"][images["depth"] > 0.0].min(), 0.0


def depth_is_coarse(device, shaders):
    """Relative error of depth on a plane that faces the camera; float32 rounds by 6e-8."""
    distance = 1.2345678
    scene = with_meshes(
        quad((-2, -2, -distance), (4, 0, 0), (0, 4, 0)),
        camera=Camera((0, 0, 0), (0, 0, -1)),
    )
    depth = render(device, shaders, scene, ("direct", None), images=("depth",))["depth"]
    # The rasterizer's interpolation takes some roundings more.
    return float(np.abs(depth / distance - 1.0).max()), 2e-6


def form_factor_is_unbounded(device, shaders):
    """Bounce in a corner of which a pixel shows R / 400, of senders with radiance 1.

    Distances count as R at least, so that a sample sends at most pi R^2 / (N R^2), and N
    of them pi.
    """
    picture = corner(poison.SIZE, (0.06, 0.04))
    senders = np.ones((*picture.z.shape, 4))
    irradiance = poison.bounced(
        device.gl, shaders, senders, picture, estimator="rgs09", distance_clamp=1.0
    )
    return float(irradiance[..., :3].max()), np.pi


def bounce_takes_poison(device, shaders):
    """Largest irradiance in a corner with senders of 1, one of which is not a number.

    By solid angle, at most pi times the brightest sender; an infinite one counts as none.
    """
    picture = corner(poison.SIZE, poison.TAN_HALF)
    worst = 0.0
    for fault in (np.nan, np.inf):
        senders = np.ones((*picture.z.shape, 4))
        senders[poison.FAULT[0]] = fault
        irradiance = poison.bounced(device.gl, shaders, senders, picture)[..., :3]
        worst = max(worst, float(np.where(np.isfinite(irradiance), irradiance, np.inf).max()))
    return worst, np.pi * (1.0 + 1e-5)


def lit_corner(device, shaders, method):
    """Relative gap between the bounce in a lit corner and that of the rays."""
    scene = with_meshes(
        quad((-1, 0, 1), (2, 0, 0), (0, 0, -2)),
        quad((-1, 0, -1), (2, 0, 0), (0, 2, 0)),
        lights=(PointLight((0.0, 2.0, 1.5), (3, 3, 3)),),
        environment=None,
        camera=Camera((0, 1.2, 1.5), (0, 0.3, -1.0)),
    )
    found = render(device, shaders, scene, method, images=("bounce",), samples=64)
    reference = render(device, shaders, scene, ("reference-near", None), images=("bounce",), spp=16)
    return abs(float(found["bounce"].mean()) / float(reference["bounce"].mean()) - 1.0)


def senders_face_wrongly_march(device, shaders):
    """A floor and a wall that light each other: screen space sees all of both."""
    return lit_corner(device, shaders, MARCH), 0.2


def senders_face_wrongly_rgs09(device, shaders):
    """The same for the paper's samples, whose weights are right by their order only."""
    return lit_corner(device, shaders, RGS09), 0.7


def sky_is_dark(device, shaders):
    """Visibility of background, which must be 1."""
    scene = with_meshes(quad((-0.3, 0, 0), (0.6, 0, 0), (0, 0.6, 0)))
    names = ("visibility", "depth")
    images = render(device, shaders, scene, ("ssao", "hemisphere"), images=names, effects="full")
    return 1.0 - images["visibility"][images["depth"] == 0.0].min(), 0.0


def convex_body_is_occluded(device, shaders):
    """Occlusion that a coarse sphere with smooth normals finds on itself: none."""
    scene = with_meshes(sphere((0, 0, 0), 1.0, rings=5), camera=Camera((0, 0, 4), (0, 0, 0)))
    # By itself it would be known to be convex, and nothing would be looked for.
    images = render(device, shaders, scene, MARCH, images=("visibility",), effects="full")
    return 1.0 - images["visibility"].min(), 0.0


def light_comes_from_below(device, shaders):
    """Change of a floor's light where a rectangle goes on below it: none.

    The floor's edge, at which half of it vanishes, moves by rounding: some 1e-6.
    """
    floor = quad((-1, 0, 1), (2, 0, 0), (0, 0, -2))
    images = []
    for low in (-0.5, 0.0):
        card = RectangleLight((-0.5, low, 0.5), (1, 0, 0), (0, 0.5 - low, 0), (5, 5, 5),
                              two_sided=True, visible=False)  # fmt: skip
        scene = with_meshes(floor, lights=(card,), environment=None)
        options = {"images": ("direct",), "shadows": "none"}
        images.append(render(device, shaders, scene, ("direct", None), **options))
    return difference(images[1], images[0], "direct")[0], 1e-5


def contact_is_not_finite(device, shaders):
    """Irradiances that are not numbers, from point lights at no and at any distance."""
    distance = np.array([0.0, 1e-38, 1e-30, 1e-20, 1e-10, 1.0, 1e18, 1e25])
    place = distance[:, None] * [0.0, 1.0, 0.0]
    n = np.tile([0.0, 1.0, 0.0], (len(distance), 1))
    body = "unshadowed_irradiance(make(LIGHT_POINT, place, n, n, vec2(0.0)), vec3(0.0), n, n)"
    found = evaluate(device.gl, shaders, ["lights/lights.glsl"], body, {"place": place, "n": n},
                     3, functions=LIGHT)  # fmt: skip
    return float((~np.isfinite(found)).sum()), 0.0


def half_size_shows_another_picture(device, shaders):
    """Occlusion at half resolution against full: RMSE of what both estimate."""
    full, half = (
        render(device, shaders, room(), MARCH, images=("visibility",), resolution_scale=scale)
        for scale in (1.0, 0.5)
    )
    # Noise of 4 directions, filtered, and edges of a pixel's width.
    return difference(full, half, "visibility")[0], 0.08


def octahedron_loses_a_fold(device, shaders):
    """Largest angle between normals and what their codes give back, radians."""
    n = Directions(0, (1e-3, 1e-20)).array(10_000)
    found = evaluate(device.gl, shaders, ["lib/octahedral.glsl"], "oct_decode(oct_encode(n))",
                     {"n": n}, 3)  # fmt: skip
    # As in test_precision.py: 5 ULP of 1 rad.
    return float(angle_between(found.astype(float), n).max()), 5.0 * 2.0**-23


def noise_swims(device, shaders):
    """What a step around a round scene changes: nothing (see test_stability_in_time.py)."""
    frames = []
    for angle in (0.0, np.pi / 12.0):
        camera = Camera((2.5 * np.sin(angle), 1.6, 2.5 * np.cos(angle)), (0.0, 0.3, 0.0))
        scene = dataclasses.replace(orbit_scene(), camera=camera)
        frames.append(render(device, shaders, scene, MARCH, images=("visibility",)))
    return difference(*frames, "visibility")[0], 1e-4


def light_is_gained(device, shaders):
    """By how much open and blocked directions together exceed a white sky: not at all."""
    names = ("directional", "bounce")
    scene = white_sky(room())
    images = render(device, shaders, scene, MARCH, images=names, filter="none", samples=64)
    # Albedo has 16 bits.
    return float((images["directional"] + images["bounce"]).max()) - 1.0, 5e-5


HEIGHT_TEST = "plane_height(t.rate, px, z) > t.lowest"
MUTATIONS = {
    "bias made absolute": Mutation(
        {"screen_space/tangent_height.glsl": (("u_bias * length_scale_at(z)", "0.025"),)},
        scale_shows,
    ),
    "thickness made absolute": Mutation(
        {"screen_space/occlusion.glsl": (("u_thickness * length_scale_at(z)", "0.1"),)}, scale_shows
    ),
    "tangent-plane test removed": Mutation(
        {"screen_space/occlusion.glsl": ((HEIGHT_TEST, f"true || {HEIGHT_TEST}"),)},
        plane_is_occluded,
    ),
    "texel not snapped": Mutation(
        {
            "screen_space/occlusion.glsl": (
                ("bool is_above(", "vec2 sample_px;\nbool is_above("),
                (HEIGHT_TEST, HEIGHT_TEST.replace("px", "sample_px")),
            ),
            "screen_space/march.glsl": (
                ("return g.start_px + march", "return sample_px = g.start_px + march"),
            ),
            "screen_space/point_samples.glsl": (
                ("ivec2 texel = texel_of_uv(uv);",
                 "sample_px = uv * u_frame_size_px; ivec2 texel = texel_of_uv(uv);"),
            ),
        },
        plane_is_occluded,
    ),
    "depth in 16 bits": Mutation(
        # The mantissa of a half float: 10 bits.
        {"passes/gbuffer.frag": (
            ("o_z_vs = z;", "float u = exp2(floor(log2(z)) - 10.0); o_z_vs = round(z / u) * u;"),
        )},
        depth_is_coarse,
    ),
    "distance clamp removed": Mutation(
        {"estimators/rgs09.glsl": (("max(d2, d_min * d_min)", "d2"),)}, form_factor_is_unbounded
    ),
    "min instead of select, senders": Mutation(
        {"effects/bounce.frag": (
            ("return is_light && largest > 0.0 ? radiance * factor : vec3(0.0);",
             "return min(radiance, vec3(FLOAT_MAX));"),
        )},
        bounce_takes_poison,
    ),
    "min instead of select, filter": Mutation(
        {"lib/edge_aware_filter.glsl": (
            ("bool is_sound(int signal, vec4 value)\n{",
             "bool is_sound(int signal, vec4 value)\n{\nreturn true;"),
            ("= use ? values[i]", "= use ? min(values[i], vec4(u_value_bound))"),
        )},
        poison.filter_takes_poison,
    ),
    "faults stay in a history": Mutation(
        {"window/live_sum.frag": (("return is_finite(value)", "return true || is_finite(value)"),)},
        history_keeps_fault,
    ),
    "filter mixes depths": Mutation(
        {"lib/edge_aware_filter.glsl": (("return z > 0.0 ? weight : 0.0;", "return 1.0;"),)},
        poison.filter_mixes_depths,
    ),
    "sender cosine of the wrong sign, march": Mutation(
        {"screen_space/estimator.glsl": (
            ("faces(texel, to_receiver)", "faces(texel, -to_receiver)"),
        )},
        senders_face_wrongly_march,
    ),
    "sender cosine of the wrong sign, rgs09": Mutation(
        {"estimators/rgs09.glsl": (("max(dot(gbuffer_shading_normal_vs(texel), -w), 0.0)",
                          "max(dot(gbuffer_shading_normal_vs(texel), w), 0.0)"),)},
        senders_face_wrongly_rgs09,
    ),
    "background not neutral": Mutation(
        {"lib/edge_aware_filter.glsl": (
            ("return vec4(1.0, 0.0, 0.0, 0.0)", "return vec4(0.0)"),
        )},
        sky_is_dark,
    ),
    "light from below the horizon": Mutation(
        {"lights/rectangle.glsl": (
            ("vec3 plane_normal, inout Cut cut)\n{",
             "vec3 plane_normal, inout Cut cut)\n{\n    return true;"),
        )},
        light_comes_from_below,
    ),
    "shadow maps block below the tangent plane": Mutation(
        {"lights/shadow.glsl": (("SHADOW_TEXEL_SLACK = 0.25", "SHADOW_TEXEL_SLACK = -2.0"),)},
        plane_shadows_itself,
    ),
    "shadow depth with a bias": Mutation(
        {"lights/shadow.glsl": (("offset.z < 0.0 && height", "offset.z < -0.1 * p.z && height"),)},
        light_gets_under,
    ),
    "division by a distance that vanishes": Mutation(
        {"lights/lights.glsl": (
            ("bounded_irradiance(light.power / distance * cos_theta / distance)",
             "light.power * cos_theta / dot(to_light, to_light)"),
        )},
        contact_is_not_finite,
    ),
    "half size without its stride": Mutation(
        {"screen_space/receiver.glsl": (("return pixel * u_receiver_stride;", "return pixel;"),)},
        half_size_shows_another_picture,
    ),
    "sign() of zero at a fold": Mutation(
        {"lib/octahedral.glsl": (("abs(p.yx)) * sign_not_zero(p)", "abs(p.yx)) * sign(p)"),)},
        octahedron_loses_a_fold,
    ),
    "noise that hangs on the position": Mutation(
        {"screen_space/receiver.glsl": (
            ("uint(i), u_pattern_offset)",
             "uint(i), u_pattern_offset + floatBitsToUint(r.z_vs) * 2654435769u)"),
        )},
        noise_swims,
    ),
    "blocked directions count twice": Mutation(
        {"estimators/march.glsl": (("(PI * d.share *", "(2.0 * PI * d.share *"),)}, light_is_gained
    ),
    "smooth normals decide what is above": Mutation(
        dict.fromkeys(
            ("effects/directional.frag", "effects/ssao.frag"),
            (("(r.position_vs, r.geometric_vs)", "(r.position_vs, r.normal_vs)"),),
        ),
        convex_body_is_occluded,
    ),
}  # fmt: skip


def mutated(mutation, folder):
    """Write a copy of the shaders with the fault in it and return the folder."""
    copy = folder / "shaders"
    shutil.copytree(Path(str(resources.folder("shaders"))), copy)
    for name, edits in mutation.edits.items():
        text = (copy / name).read_text(encoding="utf-8")
        for old, new in edits:
            assert old in text, f"{name} no longer contains {old!r}: bring the mutation up to date"
            text = text.replace(old, new)
        (copy / name).write_text(text, encoding="utf-8")
    return copy


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_broken_shader_is_noticed(device, shaders, record, tmp_path, name):
    mutation = MUTATIONS[name]
    error, bound = mutation.check(device, shaders)
    broken = ShaderLibrary(device.gl, mutated(mutation, tmp_path))
    wrong, _ = mutation.check(device, broken)
    record(
        f"fault noticed: {name}", mutation.check.__name__, error, bound, f"(broken: {wrong:.2g})"
    )
    assert not wrong <= bound, f"{name} goes unnoticed: {wrong:.3g} where {bound:.3g} is allowed"


def test_a_mutation_that_no_longer_applies_is_an_error(tmp_path):
    stale = Mutation({"effects/bounce.frag": (("no such text", ""),)}, sky_is_dark)
    with pytest.raises(AssertionError, match="no longer contains"):
        mutated(stale, tmp_path)

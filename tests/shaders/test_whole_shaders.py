"""Shaders that make an image of images, against the same in NumPy."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest
from oracle.analytic_pictures import oct_encode
from program_of_text import fullscreen_source
from shaders.harness import evaluate

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.geometry import IMAGE_NAMES, Features
from ssdo_gl.gpu.texture import make_framebuffer, make_texture
from ssdo_gl.graph.frame import FrameView, depth_uniforms, wide_depth_range

TAN = (0.8, 0.6)


def drawn(gl, program, size, inputs, uniforms=None, outputs=1, components=4):
    """Return what a shader makes of arrays (height, width, channels), rows from the bottom."""
    made = [make_texture(gl, size, components, "f4") for _ in range(outputs)]
    textures = {}
    for name, value in inputs.items():
        value = np.asarray(value, np.float32)
        value = value[..., None] if value.ndim == 2 else value
        height, width, channels = value.shape
        textures[f"t_{name}"] = make_texture(gl, (width, height), channels, "f4", value)
    draw_fullscreen(gl, program, make_framebuffer(gl, made), uniforms or {}, textures)
    shape = (size[1], size[0], components)
    found = [np.frombuffer(t.read(alignment=1), np.float32).reshape(shape) for t in made]
    return found if outputs > 1 else found[0]


def blocks(image, size):
    """Yield (row, column, block) for square blocks, those at the rim cut off."""
    for y in range(0, image.shape[0], size):
        for x in range(0, image.shape[1], size):
            yield y // size, x // size, image[y : y + size, x : x + size]


def view(size):
    return FrameView(size, np.zeros(3), np.eye(3), TAN, 0.1, 100.0)


def test_texels_that_are_not_finite_are_counted_by_block(gl, shaders):
    image = np.random.default_rng(1).normal(size=(7, 10, 4)).astype(np.float32) * 1e30
    image[0, 0, 0] = np.nan
    image[1, 2, 3] = np.inf
    image[6, 9] = -np.inf  # in the corner block of one by three texels
    image[3, 3, 1] = image[3, 3, 2] = np.nan  # two channels of one texel
    program = shaders.fullscreen("window/count_non_finite.frag", {"BLOCK": 4})
    found = drawn(gl, program, (3, 2), {"image": image}, components=1)[..., 0]
    for row, column, block in blocks(~np.isfinite(image).all(axis=-1), 4):
        assert found[row, column] == block.sum()
    assert found.sum() == 4


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_halves_of_the_samples_are_compared_by_block(gl, shaders, channels):
    """Also where the squares of differences leave float32."""
    rng = np.random.default_rng(channels)
    a, b = (rng.uniform(0.0, 9.0, (10, 7, 4)).astype(np.float32) for _ in range(2))
    a[:4, :4] *= np.float32(1e25)
    b[4:8, :4] *= np.float32(1e-25)
    a[4:8, :4] *= np.float32(1e-25)
    b[:4, 4:] = np.float32(1.5) * a[:4, 4:]  # alike: no difference at all
    a[9, 6] = np.nan
    z = np.ones((10, 7), np.float32)
    z[2, 1] = z[8, 2] = 0.0
    inverse = (1.0 / 3.0, 1.0 / 4.5)
    program = shaders.fullscreen(
        "passes/accumulate_error.frag", {"BLOCK_SIZE": 4, "CHANNEL_COUNT": channels}
    )
    found = drawn(
        gl, program, (2, 3), {"sum_a": a, "sum_b": b, "z_vs": z}, {"u_inverse_counts": inverse}
    )
    means = [s[..., :channels].astype(np.float64) * i for s, i in zip((a, b), inverse, strict=True)]
    counts = (z > 0.0) & np.isfinite(means[0]).all(axis=-1)
    apart, mean = np.abs(means[0] - means[1]), 0.5 * (means[0] + means[1])
    for row, column, block in blocks(np.dstack([apart, mean, counts]), 4):
        shown = block[block[..., -1] > 0.0]
        largest = shown[:, :channels].max(initial=0.0)
        average = shown[:, channels:-1].mean(axis=1).sum()
        # Of the numbers themselves: differences of what is alike are rounding.
        np.testing.assert_allclose(found[row, column, 0], largest, rtol=1e-6, atol=3e-6 * average)
        np.testing.assert_allclose(found[row, column, 2], average, rtol=1e-5)
        assert found[row, column, 3] == len(shown)
        if largest > 1e-3 * average:
            squares = ((shown[:, :channels] / largest) ** 2).sum()
            np.testing.assert_allclose(found[row, column, 1], squares, rtol=1e-4)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_sums_of_both_halves_become_means(gl, shaders, count):
    rng = np.random.default_rng(count)
    sums = {f"sum_{h}_{i}": rng.normal(size=(3, 5, 4)) for h in "ab" for i in range(count)}
    program = shaders.fullscreen("passes/accumulate_resolve.frag", {"OUTPUT_COUNT": count})
    found = drawn(gl, program, (5, 3), sums, {"u_inverse_count": 1.0 / 7.0}, outputs=count)
    for i, image in enumerate([found] if count == 1 else found):
        wanted = (sums[f"sum_a_{i}"] + sums[f"sum_b_{i}"]) / 7.0
        np.testing.assert_allclose(image, wanted, rtol=2e-6, atol=2e-7)


def test_light_of_surfels_is_that_of_sources_and_of_the_tiles_of_sky(gl, shaders):
    rng = np.random.default_rng(4)
    rows, sides = 3, 2
    sky, light = (rng.uniform(0.0, 2.0, (rows * n, 6, 4)) for n in (sides, 1))
    defines = {"SURFEL_RAYS_PER_SIDE": sides, "OF_QUARTER": 0}
    program = shaders.fullscreen("passes/surfel_sum.frag", defines)
    inputs = {"surfel_sky": sky, "surfel_light": light}
    rows_of = {"u_surfel_rows": rows, "u_first_row": 0}
    found = drawn(gl, program, (6, rows), inputs, rows_of)
    wanted = light + sum(np.split(sky, sides))
    # What arrives, and how grazing.
    np.testing.assert_allclose(found, wanted, rtol=1e-6)


def test_probes_stand_in_the_middle_of_a_tile_and_on_what_it_tells_least_of(gl, shaders):
    tile, (width, height) = 4, (10, 6)
    z = np.full((height, width), 2.0)
    normals = np.tile([0.0, 0.0, 1.0], (height, width, 1))
    z[1:3, 1:3] = 0.0  # no surface in the middle of the first tile
    z[0, 5] = 4.0  # a farther surface in the second
    normals[4, 0] = [1.0, 0.0, 0.0]  # and one that faces elsewhere above the first
    z[4:, 8:] = 0.0  # nothing at all in the last
    code = oct_encode(normals) / 65535.0
    gl_view = view((width, height))
    program = shaders.choosing(gl_view.choices).fullscreen(
        "effects/far_probe_points.frag", {"PROBE_TILE": tile, "PROBE_SIDE": 8}
    )
    inputs = {"z_vs": z, "normals_vs": np.concatenate([code, code], axis=-1)}
    used = {n: v for n, v in gl_view.uniforms().items() if program.takes(n)}
    first, second = np.split(drawn(gl, program, (3, 4), inputs, used), 2)

    def stands_at(probe, pixel):
        if pixel is None:
            np.testing.assert_array_equal(probe, np.zeros(4))
            return
        x, y = pixel
        ndc = 2.0 * np.array([(x + 0.5) / width, (y + 0.5) / height]) - 1.0
        np.testing.assert_allclose(probe[:2], ndc * TAN * z[y, x], rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(probe[2], -z[y, x], rtol=1e-6)
        bits = np.abs(probe[3:]).astype(np.float32).view(np.uint32)[0] - 0x20000000
        code = np.array([bits & 16383, bits >> 14]) / 8191.0 - 1.0
        np.testing.assert_allclose(code, oct_encode(normals[y, x]) / 32767.0 - 1.0, atol=1e-4)

    stands_at(first[0, 0], (1, 0))  # the first of those nearest to the middle that show a surface
    stands_at(first[0, 1], (5, 1))
    stands_at(first[0, 2], (9, 1))  # of two columns, the one nearer to the middle
    stands_at(first[1, 0], (1, 5))
    stands_at(first[1, 2], None)
    stands_at(second[0, 0], None)  # all of the tile lies in the plane of its first pixel
    stands_at(second[0, 1], (5, 0))
    stands_at(second[1, 0], (0, 4))
    stands_at(second[1, 2], None)
    # A tile that has a second one says so.
    assert (first[..., 3] < 0.0).tolist() == (second[..., 3] > 0.0).tolist()


def test_the_logarithmic_depth_goes_from_near_to_far(gl, shaders):
    near, far = 1e-3, 1e4
    z = np.geomspace(near, far, 64)
    source = (
        '#version 330 core\n#include "lib/depth_test.glsl"\nuniform sampler2D t_z;\n'
        "layout(location = 0) out vec4 o_none;\n"
        "void main() { write_depth(texelFetch(t_z, ivec2(gl_FragCoord.xy), 0).x);"
        " o_none = vec4(0.0); }"
    )
    defines = {"WIDE_DEPTH_RANGE": wide_depth_range(near, far)}
    program = fullscreen_source(shaders, source, defines, name="<depth>")
    color = make_texture(gl, (64, 1), 4, "f4")
    depth = gl.depth_texture((64, 1))
    target = gl.framebuffer([color], depth)
    target.clear(depth=1.0)
    target.use()
    gl.enable_only(moderngl.DEPTH_TEST)
    gl.depth_func = "1"
    values = make_texture(gl, (64, 1), 1, "f4", z)
    program.set(depth_uniforms(near, far), {"t_z": values})
    program.empty_vertex_array().render(moderngl.TRIANGLES, vertices=3)
    gl.depth_func = "<="
    gl.enable_only(moderngl.NOTHING)
    found = np.frombuffer(depth.read(alignment=4), np.float32)
    # A logarithm in float32, and 24 bits.
    np.testing.assert_allclose(found, np.log(z / near) / np.log(far / near), atol=1e-6)


@pytest.mark.parametrize("name", IMAGE_NAMES)
def test_every_image_calls_for_its_texture_coordinates(gl, shaders, name):
    branches = "#if HAS_UVS\n r.x = 1.0;\n#endif\n#if HAS_SECOND_UVS\n r.y = 1.0;\n#endif\n"
    for second in (frozenset(), frozenset({name})):
        defines = Features(images=frozenset({name}), second_uvs=second).defines
        defines = {key: on for key, on in defines.items() if key.endswith(("_IMAGE", "_UVS"))}
        body = f"vec2 r = vec2(x);\n{branches}return r;"
        includes = ["lib/material_uvs.glsl"]
        found = evaluate(gl, shaders, includes, body, {"x": [0.0]}, 2, defines=defines)
        assert found.tolist() == [[1.0, float(bool(second))]]

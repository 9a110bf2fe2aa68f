"""Compute shaders of files of their own: uniforms, groups, faults and changes on disk."""

from __future__ import annotations

import numpy as np
import pytest

from ssdo_gl.gpu.shader import ShaderError, ShaderLibrary

SHADER = """#version 330 core
layout(local_size_x = 4) in;
layout(std430, binding = 0) buffer Numbers { uint u_numbers[]; };
uniform uint u_factor;
uniform float u_unused;
void main()
{
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint i = 4u * group + gl_LocalInvocationID.x;
    if (i < uint(u_numbers.length())) u_numbers[i] = u_factor * i;
}
"""


@pytest.fixture
def library(device, tmp_path) -> ShaderLibrary:
    if device.gl.version_code < 450:
        pytest.skip("this driver has no compute shaders")
    (tmp_path / "numbers.comp").write_text(SHADER)
    return ShaderLibrary(device.gl, tmp_path)


def numbers(gl, library, count, factor):
    kernel, buffer = library.kernel("numbers.comp"), gl.buffer(reserve=4 * count)
    buffer.bind_to_storage_buffer(0)
    kernel.set({"u_factor": factor})
    kernel.run(-(-count // 4))
    found = np.frombuffer(buffer.read(), np.uint32)
    buffer.release()
    return found


# More groups than one axis of a dispatch has.
@pytest.mark.parametrize("count", [1, 1000, 4 * 65535 + 9])
def test_every_invocation_runs(gl, library, count):
    np.testing.assert_array_equal(numbers(gl, library, count, 3), 3 * np.arange(count))


def test_unknown_uniforms_are_refused(library):
    kernel = library.kernel("numbers.comp")
    kernel.set({"u_unused": 1.0})
    with pytest.raises(ShaderError, match=r"numbers\.comp: no uniform is called u_facto"):
        kernel.set({"u_facto": 1})
    with pytest.raises(ShaderError, match="u_factor takes whole numbers"):
        kernel.set({"u_factor": 0.5})


def test_changes_on_disk_are_taken_and_faults_named(gl, library, tmp_path):
    assert numbers(gl, library, 5, 1)[4] == 4
    file = tmp_path / "numbers.comp"
    file.write_text(SHADER.replace("u_factor * i", "u_factor * i + 7u"))
    assert library.reload() == []
    assert numbers(gl, library, 5, 1)[4] == 11
    file.write_text(SHADER.replace("u_factor * i", "u_factor * j"))
    (fault,) = library.reload()
    assert "numbers.comp:10" in str(fault)
    assert numbers(gl, library, 5, 1)[4] == 11

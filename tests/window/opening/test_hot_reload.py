"""Shaders that change on disk: compiled anew, or kept as they were with the reason."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from ssdo_gl.gpu.fullscreen import draw_fullscreen
from ssdo_gl.gpu.shader import ShaderLibrary
from ssdo_gl.gpu.texture import make_framebuffer, make_texture, read_texture
from ssdo_gl.window.opening import hot_reload
from ssdo_gl.window.opening.hot_reload import ShaderWatch

VERTEX = """#version 330 core
void main()
{
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
FRAGMENT = """#version 330 core
#include "lib/answer.glsl"
layout(location = 0) out vec4 o_color;

void main()
{
    o_color = vec4(answer());
}
"""
ANSWER = "float answer()\n{\n    return VALUE;\n}\n"


class Folder:
    """A folder of shaders whose files change, each time at another time."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._now_ns = 1_700_000_000 * 10**9
        (root / "lib").mkdir()
        (root / "passes").mkdir()
        self.write("passes/fullscreen.vert", VERTEX)
        self.write("one.frag", FRAGMENT)
        self.answer("1.0")

    def write(self, name: str, text: str) -> None:
        (self.root / name).write_text(text)
        # Two writes within the resolution of the file system's clock would look alike.
        self._now_ns += 10**9
        os.utime(self.root / name, ns=(self._now_ns, self._now_ns))

    def answer(self, value: str) -> None:
        self.write("lib/answer.glsl", ANSWER.replace("VALUE", value))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Folder:
    monkeypatch.setattr(hot_reload, "LOOK_EVERY_S", 0.0)
    return Folder(tmp_path)


@pytest.fixture
def library(gl, folder: Folder) -> ShaderLibrary:
    return ShaderLibrary(gl, folder.root)


def drawn(gl, library: ShaderLibrary) -> float:
    output = make_texture(gl, (1, 1), 4, "f4")
    target = make_framebuffer(gl, [output])
    draw_fullscreen(gl, library.fullscreen("one.frag"), target, {}, {})
    value = float(read_texture(output)[0, 0, 0])
    assert np.isfinite(value)
    return value


def test_changed_include_is_compiled_anew(gl, folder, library) -> None:
    watch = ShaderWatch(library, folder.root)
    assert drawn(gl, library) == 1.0
    assert not watch.poll()
    folder.answer("2.0")
    assert watch.poll()
    assert (drawn(gl, library), watch.faults) == (2.0, ())
    assert not watch.poll()


def test_broken_shader_keeps_what_worked_and_names_file_and_line(gl, folder, library) -> None:
    watch = ShaderWatch(library, folder.root)
    drawn(gl, library)
    folder.answer("nonsense")
    assert watch.poll()
    assert drawn(gl, library) == 1.0
    (fault,) = watch.faults
    assert "lib/answer.glsl:3" in fault
    folder.answer("3.0")
    assert watch.poll()
    assert (drawn(gl, library), watch.faults) == (3.0, ())


def test_fault_shared_by_many_programs_is_told_once(gl, folder, library) -> None:
    folder.write("two.frag", FRAGMENT)
    watch = ShaderWatch(library, folder.root)
    drawn(gl, library)
    library.fullscreen("two.frag")
    folder.answer("nonsense")
    watch.reload()
    assert len(watch.faults) == 1


def test_file_that_vanishes_is_a_fault_until_it_is_back(gl, folder, library) -> None:
    """Editors replace a file by removing it first."""
    watch = ShaderWatch(library, folder.root)
    drawn(gl, library)
    (folder.root / "lib" / "answer.glsl").unlink()
    assert watch.poll()
    assert watch.faults
    assert drawn(gl, library) == 1.0
    folder.answer("4.0")
    assert watch.poll()
    assert (drawn(gl, library), watch.faults) == (4.0, ())


def test_looks_only_now_and_then(gl, folder, library, monkeypatch) -> None:
    monkeypatch.setattr(hot_reload, "LOOK_EVERY_S", 3600.0)
    watch = ShaderWatch(library, folder.root)
    drawn(gl, library)
    folder.answer("2.0")
    assert not watch.poll()
    watch.reload()
    assert drawn(gl, library) == 2.0


def test_shaders_that_are_no_files_are_not_watched(gl, library) -> None:
    watch = ShaderWatch(library, None)
    assert not watch.poll()

"""Whatever is wrong with a scene file is said in one line that names place and cure."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scene.fixture_types import ErrorOf, Write

from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene_error import SceneError

SPHERE = '[[object]]\nshape = "sphere"\nradius = 1\n'


OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        # Keys and their nearest relatives.
        ("[camra]\n", ["'camra'", "did you mean 'camera'"]),
        ("[camera]\npositon = [0, 0, 1]\n", ["[camera]", "'positon'", "'position'"]),
        ("[render]\nradios = 1\n", ["[render]", "'radios'", "'radius'"]),
        ("[materials.red]\nalbdo = [1, 0, 0]\n", ["[materials.red]", "'albdo'", "'albedo'"]),
        ("[[light]]\nkind = 'pint'\n", ["[[light]] 1 kind", "'pint'", "'point'"]),
        ("[[object]]\nshape = 'spere'\n", ["[[object]] 1 shape", "'sphere'"]),
        ("[[object]]\nshape = 'sphere'\nradus = 1\n", ["'radus'", "did you mean 'radius'"]),
        (
            "[[object]]\nshape = 'sphere'\nradius = 1\nname = 'ball'\nrepeat = { cont = 1 }\n",
            ["[[object]] 1 ('ball') repeat", "'cont'", "'count'"],
        ),
        ("xyzzy = 1\n", ["'xyzzy'", "choose one of title"]),
        # Types.
        ("title = 3\n", ["title = 3", "expected text"]),
        ("camera = 3\n", ["camera = 3", "expected a table"]),
        ("[light]\nkind = 'point'\n", ["light", "[[light]]"]),
        ("[camera]\nposition = 'here'\n", ["position = 'here'", "3 finite numbers"]),
        ("[camera]\nposition = [0, 1]\n", ["position = [0, 1]", "3 finite numbers"]),
        ("[camera]\nposition = [0, true, 1]\n", ["3 finite numbers"]),
        ("[render]\nsamples = 1.5\n", ["samples = 1.5", "whole number from 1 to 1024"]),
        ("[render]\nmethod = 'ssdoo'\n", ["method = 'ssdoo'", "did you mean 'ssdo'"]),
        (
            "[render]\nmethod = 'ssdo'\nestimator = 'zbuffer'\n",
            ["[render] estimator = 'zbuffer'", "one of march, rgs09"],
        ),
        ("[render]\nseed = " + "9" * 5000 + "\n", ["thousands of digits"]),
        ("[render]\nseed = 0x" + "f" * 5000 + "\n", ["seed = a whole number of thousands"]),
        ("[camera]\nfov_y = 0x" + "f" * 5000 + "\n", ["fov_y = a whole number of thousands"]),
        ("[render]\nsize = [0, 5]\n", ["size = [0, 5]", "[width, height]"]),
        # Numbers that are none.
        ("[camera]\nposition = [nan, 0, 0]\n", ["position = [nan, 0, 0]", "finite"]),
        ("[camera]\nposition = [inf, 0, 0]\n", ["finite"]),
        ("[camera]\nposition = [1e300, 0, 0]\n", ["finite"]),
        ("[camera]\nfov_y = nan\n", ["fov_y = nan", "greater than 0 and less than 180"]),
        # Ranges.
        ("[camera]\nfov_y = 180\n", ["fov_y = 180", "less than 180"]),
        ("[camera]\nfov_y = 0\n", ["fov_y = 0", "greater than 0"]),
        ("[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]\n", ["target", "coincide"]),
        ("[camera]\nposition = [1, 1, 1]\n", ["'target' is missing"]),
        ("[camera]\ntarget = [1, 1, 1]\n", ["'position' is missing"]),
        ("[camera]\nposition = [1,1,1]\ntarget = [0,0,0]\nup = [0,0,0]\n", ["up", "zero"]),
        ("[materials.m]\nalbedo = [1.2, 0, 0]\n", ["albedo = [1.2, 0, 0]", "at most 1"]),
        ("[materials.m]\nemission = [-1, 0, 0]\n", ["emission = [-1, 0, 0]", "at least 0"]),
        ("[materials.m]\nalpha_cutoff = 2\n", ["alpha_cutoff = 2", "at most 1"]),
        ("[[object]]\nshape = 'sphere'\nradius = -2\n", ["radius = -2", "greater than 0"]),
        ("[[object]]\nshape = 'sphere'\n", ["'radius' is missing"]),
        ("[[object]]\nshape = 'box'\nmin = [0, 0, 0]\nmax = [1, -1, 1]\n", ["max", "exceed min"]),
        (
            "[[object]]\nshape = 'quad'\ncorner = [0,0,0]\nedge_u = [1,1,0]\nedge_v = [2,2,0]\n",
            ["edge_v = [2, 2, 0]", "parallel"],
        ),
        (
            "[[object]]\nshape = 'quad'\ncorner = [0,0,0]\nedge_u = [0,0,0]\nedge_v = [2,2,0]\n",
            ["edge_u = [0, 0, 0]", "zero"],
        ),
        (
            "[[object]]\nshape = 'cylinder'\nbase = [1,1,1]\ntop = [1,1,1]\nradius = 1\n",
            ["top", "coincide with base"],
        ),
        (
            "[[object]]\nshape = 'plane'\npoint = [0,0,0]\nnormal = [0,0,0]\nsize = 1\n",
            ["normal = [0, 0, 0]", "zero"],
        ),
        (
            "[[object]]\nshape = 'plane'\npoint = [0,0,0]\nnormal = [0,1,0]\nsize = [1, -1]\n",
            ["size = [1, -1]", "greater than 0"],
        ),
        (
            "[[object]]\nshape = 'torus'\nradius = 1\nthickness = 2\n",
            ["thickness = 2", "less than 2"],
        ),
        (
            "[[object]]\nshape = 'torus'\nradius = 1\nthickness = 1e-200\n",
            ["thickness = 1e-200", "greater than 1e-12"],
        ),
        (
            (
                "[[object]]\nshape = 'torus'\nradius = 1\nthickness = 1\naxis = [0, 0, 1]\n"
                "arc = { from = [0, 0, 3], degrees = 90 }\n"
            ),
            ["arc from", "parallel to axis"],
        ),
        ("[[object]]\nshape = 'sphere'\nradius = 1\nsegments = 2\n", ["segments = 2", "from 3"]),
        (SPHERE + "transform = { scale = 0 }\n", ["scale = 0", "zero"]),
        (SPHERE + "repeat = { count = [1, 0, 1], step = [1, 1, 1] }\n", ["count", ">= 1"]),
        (SPHERE + "repeat = { count = 2.5, step = [1, 1, 1] }\n", ["count = 2.5", ">= 1"]),
        (SPHERE + "repeat = { count = [9999, 9999, 1], step = [1, 1, 1] }\n", ["1048576 copies"]),
        (SPHERE + "animate = { sway = [0, 1, 0], period = 0 }\n", ["period = 0", "at least 1e-06"]),
        (
            SPHERE + "animate = { sway = [0, 1, 0], period = 1e-310 }\n",
            ["period = 1e-310", "at least 1e-06"],
        ),
        (SPHERE + "animate = { sway = [0, 1e20, 0] }\n", ["3 finite numbers up to 1e+15"]),
        (
            "[[object]]\nshape = 'sphere'\nradius = 1e20\n",
            ["radius = 1e+20", "greater than 0 and at most 1e+15"],
        ),
        (SPHERE + "material = 'rd'\n[materials.red]\n", ["material = 'rd'", "did you mean 'red'"]),
        (SPHERE + "material = 'red'\n", ["no [materials.red] in this file"]),
        ("[[light]]\nkind = 'point'\nposition = [0,0,0]\n", ["'intensity' is missing"]),
        (
            "[[light]]\nkind = 'directional'\ndirection = [0,0,0]\nirradiance = [1,1,1]\n",
            ["direction = [0, 0, 0]", "zero"],
        ),
        (
            (
                "[[light]]\nkind='spot'\nposition=[0,0,0]\ndirection=[0,0,1]\nintensity=[1,1,1]\n"
                "inner_angle = 30\nouter_angle = 20\n"
            ),
            ["inner_angle = 30", "less than outer_angle (20"],
        ),
        (
            (
                "[[light]]\nkind='spot'\nposition=[0,0,0]\ndirection=[0,0,1]\nintensity=[1,1,1]\n"
                "outer_angle = 1e-9\n"
            ),
            ["outer_angle = 1e-09", "at least 0.01 degrees"],
        ),
        (
            (
                "[[light]]\nkind='area'\ncorner=[0,0,0]\nedge_u=[1,0,0]\nedge_v=[1,0,0]\n"
                "radiance=[1,1,1]\n"
            ),
            ["edge_v = [1, 0, 0]", "area would be zero"],
        ),
        (
            "[[light]]\nkind='point'\nposition=[0,0,0]\nintensity=[1,1,1]\nshadow='soft'\n",
            ["shadow = 'soft'", "expected one of map, ssdo, none"],
        ),
        ("[environment]\nkind = 'dome'\n", ["kind = 'dome'", "constant, gradient, map"]),
        ("[environment]\nkind = 'constant'\nradiance = [-1, 0, 0]\n", ["radiance", "at least 0"]),
        ("[environment]\nkind = 'map'\npath = 'a.hdr'\n", ["path = 'a.hdr'", "no folder"]),
        ("", ["nothing to draw"]),
        (SPHERE + "[[object]]\nshape='sphere'\nradius=1\ncenter=[2e15,0,0]\n", ["finite"]),
        ("[[object]]\nshape='sphere'\nradius=1e-300\n", ["1e-15"]),
    ],
)
def test_a_bad_scene_is_refused_in_one_line(text: str, parts: list[str], error_of: ErrorOf) -> None:
    message = error_of("scene.toml", text=text)
    assert message.startswith("scene.toml: ")
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("a = \n", "line 1, column 5"),
        ("[camera]\nposition = [1, 2\n", "line 3, column 1"),
        ("title = 'x'\ntitle = 'y'\n", "line 2"),
        ("a = 1\n\x00\n", "line 2"),
    ],
)
def test_syntax_errors_name_line_and_column(text: str, place: str, error_of: ErrorOf) -> None:
    message = error_of("scene.toml", text=text)
    assert "not valid TOML" in message
    assert place in message


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (
            "a = 1\r\nb = [1, -.5]\r\n",
            "line 2, column 9: not valid TOML: Invalid value; write -0.5",
        ),
        ("a = {b = .25}", "write 0.25 for .25"),
        ("a = True # yes", "write true for True"),
        ("kind = point", 'text stands in quotes: "point"'),
    ],
)
def test_what_other_languages_take_is_said_in_toml(text: str, hint: str, error_of: ErrorOf) -> None:
    assert hint in error_of("scene.toml", text=text)


@given(st.text(max_size=200))
def test_any_text_is_a_scene_or_one_line(text: str) -> None:
    try:
        read_description(text, "scene.toml")
    except SceneError as error:
        assert "\n" not in str(error)


def test_deep_nesting_is_one_line(error_of: ErrorOf) -> None:
    message = error_of("scene.toml", text="a = " + "[" * 100_000)
    assert "scene.toml" in message


def test_text_that_is_not_utf8(write: Write, error_of: ErrorOf) -> None:
    assert "byte 9 is not UTF-8" in error_of(write({"s.toml": b"title = '\xff'"}))


def test_missing_files_and_unknown_names(error_of: ErrorOf, tmp_path: Path) -> None:
    assert error_of("nowhere.toml") == "nowhere.toml: no such file"
    assert error_of("nowhere.glb") == "nowhere.glb: no such file"
    assert "did you mean 'cornell_meso'" in error_of("cornel_meso")
    assert "no built-in scene" in error_of("")
    assert "expected a file ending in one of .toml, .glb" in error_of("model.fbx")
    assert "is a folder: expected a file" in error_of(tmp_path)
    folder = tmp_path / "folder.toml"
    folder.mkdir()
    assert "is a folder" in error_of(folder)


def mesh_scene(path: str) -> str:
    return f'[[object]]\nshape = "mesh"\npath = {path!r}\n'


@pytest.mark.parametrize(
    ("path", "reason"),
    [
        ("../a.obj", "must not leave the folder of s.toml"),
        ("sub/../../a.obj", "must not leave"),
        ("..\\\\a.obj", "must not leave"),
        ("/etc/passwd", "must be relative"),
        ("C:/a.obj", "must be relative"),
        ("none.obj", "no such file"),
        ("", "expected the name of a file"),
        (".", "expected the name of a file"),
        ("s.toml", "expected one of .glb"),
    ],
)
def test_a_mesh_path_stays_in_its_folder(
    path: str, reason: str, write: Write, error_of: ErrorOf
) -> None:
    file = write({"scenes/s.toml": f'[[object]]\nshape = "mesh"\npath = "{path}"\n', "a.obj": OBJ})
    message = error_of(file.parent / "scenes/s.toml")
    assert "[[object]] 1 path" in message
    assert reason in message


def test_symbolic_links_are_not_followed(write: Write, error_of: ErrorOf) -> None:
    file = write({"a.obj": OBJ, "scenes/s.toml": mesh_scene("link.obj")})
    os.symlink(file.parent.parent / "a.obj", file.parent / "link.obj")
    assert "symbolic links" in error_of(file)
    os.symlink(file.parent.parent, file.parent / "up")
    file.write_text(mesh_scene("up/a.obj"))
    assert "symbolic links" in error_of(file)


def test_a_scene_in_a_linked_folder_finds_its_files(write: Write, tmp_path: Path) -> None:
    file = write({"real/a.obj": OBJ, "real/s.toml": mesh_scene("a.obj")})
    os.symlink(file.parent, tmp_path / "linked")
    assert load_scene(tmp_path / "linked" / "s.toml").triangle_count == 1

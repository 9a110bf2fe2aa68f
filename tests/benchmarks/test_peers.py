"""Peers: who is compared, how errors are told, and who is left out for what."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks import peers
from benchmarks.peer_room import NoPeerError, PeerTimes, make_room
from benchmarks.peer_three import Three, children_ms, package_folder
from benchmarks.peer_vtk import Vtk
from benchmarks.peers import Contestant, Traced, measure, race, rows_of, table

SHAPE = (9, 16)
HALF = np.full(SHAPE, 0.5)


def traced(visibility=HALF, variance=0.0) -> Traced:
    return Traced(visibility, variance, np.full(SHAPE, 2.0))


def test_noise_of_the_rays_is_no_error_of_a_peer():
    assert traced().error(HALF + 0.3) == pytest.approx(0.3)
    assert traced(variance=0.05).error(HALF + 0.3) == pytest.approx(0.2)
    assert traced(variance=0.05).error(HALF) == 0.0


def test_strength_is_a_choice_of_looks():
    ramp = np.linspace(0.2, 1.0, HALF.size).reshape(SHAPE)
    found = 1.0 - 0.4 * (1.0 - ramp)
    assert traced(ramp).error(found) > 0.2
    assert traced(ramp).best_error(found) == pytest.approx(0.0, abs=1e-9)
    # Nothing makes occlusion of none.
    assert traced(ramp).best_error(np.ones(SHAPE)) == traced(ramp).error(np.ones(SHAPE))


VARIANTS = {"fake, plain": "", "fake SSAO": "occlusion"}


class FakePeer:
    device = "a fake"
    notes = ("fake 1.0",)
    is_closed = False

    def __init__(self, room, scale=1.0):
        self.room = room
        self.variants = VARIANTS
        self.scale = scale

    def depth(self):
        scene, (width, height) = self.room.scene, self.room.size
        with peers.Renderer(scene, peers._settings(self.room, method="direct")) as renderer:
            depth = renderer.render(("depth",)).images["depth"]
        return self.scale * depth.reshape(height, width).astype(np.float64)

    def visibility(self, variant):
        assert variant == "fake SSAO"
        return np.ones(self.room.size[::-1])

    def timed(self, variant, frames):
        return PeerTimes(2.0, 4.0 if variant == "fake SSAO" else 1.0)

    def close(self):
        FakePeer.is_closed = True


def test_who_is_there_is_measured_and_who_is_not_is_named(monkeypatch):
    ours = {name: peers.OURS[name] for name in ("direct, no shadow", "ssao, hemisphere 16")}
    monkeypatch.setattr(peers, "OURS", ours)
    monkeypatch.setattr(peers, "TRACED_SPP", 8)

    def missing(room):
        raise NoPeerError("nobody installed it")

    makers = {
        "fake": FakePeer,
        "absent": missing,
        "askew": lambda room: FakePeer(room, scale=1.1),
    }
    contestants, rays, notes = measure(make_room((32, 18), 0.3), makers, 1)
    rows = rows_of(contestants, rays)
    assert [row["renderer"] for row in rows] == [*ours, *VARIANTS]
    found = {row["renderer"]: row for row in rows}
    assert found["fake SSAO"]["process_ms"] == 4.0 and found["fake SSAO"]["error"] > 0.1
    assert np.isnan(found["fake, plain"]["error"])
    assert found["ssao, hemisphere 16"]["time"] == 1.0
    assert "skipped absent: nobody installed it" in notes and "fake 1.0" in notes
    assert "skipped askew: its depth differs from ours in 100.0% of the pixels" in notes
    assert FakePeer.is_closed
    lines = list(table(rows))
    assert len(lines) == 6 and sum("|  |  |" in line for line in lines) == 2


def test_everybody_takes_a_turn_in_every_round():
    turns = []

    def contestant(name, ms):
        def timed(frames):
            turns.append(name)
            return PeerTimes(next(ms), 1.0)

        return Contestant(name, "", timed, None)

    crowd = [
        contestant(peers.UNITS[1], iter([1.0, 9.0, 2.0])),
        contestant("b", iter([5.0, 4.0, 7.0])),
    ]
    race(crowd, 3)
    assert all(set(turns[i : i + 2]) == {peers.UNITS[1], "b"} for i in (0, 2, 4))
    assert [row["wall_ms"] for row in rows_of(crowd, traced())] == [2.0, 5.0]


def test_a_folder_without_three_is_named(tmp_path):
    with pytest.raises(NoPeerError, match="no --three DIR"):
        package_folder(None)
    with pytest.raises(NoPeerError, match="holds no npm package three"):
        package_folder(tmp_path)
    build = tmp_path / "node_modules" / "three" / "build"
    build.mkdir(parents=True)
    (build / "three.webgpu.js").touch()
    assert package_folder(tmp_path) == build.parent.resolve()


@pytest.mark.skipif(shutil.which("chromium") is None, reason="chromium is not installed")
def test_a_page_that_fails_is_a_peer_left_out(tmp_path):
    pytest.importorskip("playwright")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "three.webgpu.js").touch()
    with pytest.raises(NoPeerError, match="Failed to fetch dynamically imported module"):
        Three(make_room((32, 18), 0.3), tmp_path)


def test_without_vtk_it_says_how_to_have_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "vtk", None)
    with pytest.raises(NoPeerError, match="pip install --no-deps vtk"):
        Vtk(make_room((32, 18), 0.3))


@pytest.mark.parametrize("flags, words", [(["--size", "9"], "size"), (["--rounds", "0"], "rounds")])
def test_what_cannot_be_measured_is_refused(flags, words, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        peers.main([str(tmp_path / "out"), *flags])
    assert ended.value.code == 2
    assert f"--{words}" in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="there is no /proc")
def test_the_time_of_children_is_counted():
    code = "import time\nwhile time.process_time() < 0.3: pass\nprint(flush=True)\ninput()"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as child:
        assert child.stdout is not None and child.stdin is not None
        child.stdout.readline()
        found = children_ms(os.getpid())
        child.stdin.close()
    assert found >= 250.0
    begin = time.process_time()
    while time.process_time() < begin + 0.2:
        pass
    # Its own time is none of theirs.
    assert children_ms(os.getpid()) < 100.0


SCRIPT = """
import json, sys
import numpy as np
from benchmarks.peer_room import make_room
from benchmarks.peer_vtk import Vtk
peer = Vtk(make_room((64, 36), 0.3))
depth, seen = peer.depth(), peer.visibility("VTK SSAO-16 + blur")
print(json.dumps([depth.min(), depth[18, 32], seen.min(), seen.max()]))
"""


@pytest.mark.skipif(importlib.util.find_spec("vtk") is None, reason="VTK is not installed")
def test_vtk_sees_the_room_and_its_occlusion():
    # In a process of its own: a window of VTK ends EGL for all.
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    nearest, middle, darkest, brightest = json.loads(done.stdout.splitlines()[-1])
    # The middle of the picture shows the front of the short block, some 1.5 from the eye.
    assert 0.1 < nearest < middle and 1.2 < middle < 1.8
    assert darkest < 0.7 and brightest == 1.0

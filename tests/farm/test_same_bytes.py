"""Films, batches and benches on workers have the bytes of one process."""

from __future__ import annotations

import os
import platform
import signal
from pathlib import Path

import numpy as np
import pytest
from farm.film_of_five import FILM, contents

from ssdo_gl.bench import references
from ssdo_gl.bench.bench_workers import Measurer, spread
from ssdo_gl.bench.estimators import estimator_views
from ssdo_gl.bench.estimators.estimator_views import (
    QUANTITIES,
    RADII_PX,
    TablePlan,
    errors_in,
    points_of,
)
from ssdo_gl.bench.measure import BenchRenderer, Point, Reference
from ssdo_gl.bench.run import BenchPlan, BenchRun
from ssdo_gl.cli import main
from ssdo_gl.farm.scenes import CapturedWork
from ssdo_gl.gpu.warm_device import WarmDevice
from ssdo_gl.options.flags import CommandLine
from ssdo_gl.progress import StageProgress
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
pytest.importorskip("cloudpickle")

# Dask's own threads and sockets end when it likes, after a test.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

POINTS = [
    Point("radiance", "march", "bounce", "march", 16, 8, 1.0, "none"),
    Point("visibility", "march", "ssao", "march", 16, 8, 1.0, "none"),
    Point("visibility", "rays", "reference-ao", spp=4),
]
PLAN = BenchPlan(1, 2, 2, 600.0, 16, flips=())


def bench_errors(
    folder: Path, scheduler: str | None, progress: StageProgress
) -> tuple[dict[str, bytes], dict[str, Reference], list[str]]:
    """Return files of errors, references and notes of a bench, which measures no times."""
    outdir = folder / str(scheduler is None)
    outdir.mkdir()
    base = Settings(size=(40, 30), radius=0.3, exposure=0.0)
    with Renderer(load_scene("corner"), base) as renderer:
        run = BenchRun(
            BenchRenderer(renderer),
            base,
            POINTS,
            PLAN,
            False,
            outdir,
            progress,
            scheduler=scheduler,
        )
        mask = run._mask()
        with run._renderers() as spread:
            references, _ = run._judged(spread, {}, mask)
    return contents(outdir / "errors"), references.by_panel, run.notes


def test_errors_of_a_bench_are_those_of_one_process(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of the workers is killed on the way."""
    # So that references end by their goal, and not by the clock.
    monkeypatch.setattr(references, "REFERENCE_RATIO", 1.0)
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "here"))
    here, known, notes = bench_errors(tmp_path, None, StageProgress(None, None))
    assert notes == []
    monkeypatch.setenv("SSDO_GL_CACHE", str(tmp_path / "there"))
    with distributed.Client(address) as client:
        pids = list(client.run(os.getpid).values())

    class Killing(StageProgress):
        def share(self, stage: str, text: str, share: float) -> None:
            if pids and stage.startswith("reference"):
                os.kill(pids.pop(), signal.SIGKILL)
                pids.clear()

    there, found, notes = bench_errors(tmp_path, address, Killing(None, None))
    assert not pids
    assert there == here and len(here) == len(POINTS)
    for name, reference in known.items():
        assert found[name].batches == reference.batches
        for image, pixels in reference.images.items():
            np.testing.assert_array_equal(found[name].images[image], pixels)
    assert len(notes) == 1 and f"on {platform.node()}" in notes[0]


def test_a_bench_takes_no_worker_with_another_opengl() -> None:
    scene = load_scene("corner")
    with pytest.raises(RuntimeError, match=r"a worker draws with .*, this machine with Other GPU"):
        Measurer((scene, Settings(size=(16, 16)), "auto", "Other GPU"))


def test_errors_of_estimators_are_those_of_one_process(
    address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(estimator_views, "REFERENCE_SPP", 1)
    monkeypatch.setattr(estimator_views, "REFERENCE_ERROR", 1.0)
    plan = TablePlan(budgets=(8,), steps=(2,), seeds=2)
    some = points_of(plan, QUANTITIES[0])[:3]
    monkeypatch.setattr(estimator_views, "points_of", lambda *_: some)
    base = Settings(size=(24, 18), radius=0.3)
    found, said = [], []
    with distributed.Client(address) as client:
        client.wait_for_workers(2)  # one that died in a test before may still be starting
    with Renderer(load_scene("corner"), base) as renderer:
        for name in (None, address):
            with spread(BenchRenderer(renderer), name) as (maker, sentence):
                said.append(sentence)
                found.append(errors_in(maker, base, RADII_PX[0], plan))
    here, there = ([(p, vars(j.blocks), vars(j.scalars)) for p, j in e.items()] for e in found)
    np.testing.assert_equal(there, here)
    assert len(here) == 3 and said[0] == "" and "made by workers (2 on" in said[1]


@pytest.mark.parametrize("out", ["turn", "turn%d.npz", "turn.gif"])
def test_films_have_the_bytes_of_one_process(address: str, tmp_path: Path, out: str) -> None:
    for folder in ("here", "there"):
        (tmp_path / folder).mkdir()
    assert main(["stairs", "--film", str(tmp_path / "here" / out), *FILM]) == 0
    flags = [*FILM, "--scheduler", address]
    assert main(["stairs", "--film", str(tmp_path / "there" / out), *flags]) == 0
    here, there = (tmp_path / name for name in ("here", "there"))
    if out == "turn":
        here, there = here / out, there / out
    assert contents(here) == contents(there)
    assert len(contents(here)) == (1 if out == "turn.gif" else 5)


def test_resume_renders_the_missing_frames(address: str, tmp_path: Path) -> None:
    words = ["stairs", "--film", str(tmp_path / "turn"), *FILM]
    assert main(words) == 0
    whole = contents(tmp_path / "turn")
    (tmp_path / "turn" / "frame_0002.png").unlink()
    (tmp_path / "turn" / "frame_0003.png").write_bytes(b"kept")
    assert main([*words, "--resume", "--scheduler", address]) == 0
    assert contents(tmp_path / "turn") == whole | {"frame_0003.png": b"kept"}


def test_several_scenes_are_as_without_workers(
    address: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    flags = ["--size", "48x27", "--method", "direct"]
    told = []
    for folder, more in (("here", []), ("there", ["--scheduler", address])):
        Path(folder).mkdir()
        out = ["--snapshot", f"{folder}/{{name}}.png"]
        assert main(["corner", "nosuch.glb", "stairs", *out, *flags, *more]) == 2
        said = capsys.readouterr()
        assert said.err == "ssdo-gl: nosuch.glb: no such file\n"
        names = [line for line in said.out.splitlines() if line.endswith(":")]
        told.append((names, said.out.count("passes: ")))
    assert told[0] == told[1] == (["corner:", "nosuch.glb:", "stairs:"], 2)
    assert contents(tmp_path / "here") == contents(tmp_path / "there")
    assert len(contents(tmp_path / "here")) == 2


def test_a_batch_has_the_bytes_of_one_process(
    address: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.glb").write_text("junk")
    words = ["--batch", "corner", "*.glb", "stairs", "--size", "48x27", "--method", "direct"]
    assert main([*words, "--out", "here"]) == 2
    said = capsys.readouterr()
    assert main([*words, "--out", "there", "--scheduler", address]) == 2
    assert capsys.readouterr().err == said.err != ""
    whole = contents(tmp_path / "here")
    assert contents(tmp_path / "there") == whole and len(whole) == 2
    (tmp_path / "there" / "stairs.png").unlink()
    (tmp_path / "there" / "corner.png").write_bytes(b"kept")
    assert main([*words, "--out", "there", "--scheduler", address, "--resume"]) == 2
    assert contents(tmp_path / "there") == whole | {"corner.png": b"kept"}


def test_a_worker_draws_a_batch_on_one_device(tmp_path: Path) -> None:
    """Its shaders stay compiled, until a scene leaves it in an unknown state."""
    codes = iter([0, 4, 2, 0])
    seen = []

    def work(command: CommandLine, warm: WarmDevice) -> int:
        seen.append(warm.made("auto")[0])
        return next(codes)

    maker = CapturedWork((work, Path.cwd()))
    assert [maker.make(CommandLine(("x",))).code for _ in range(4)] == [0, 4, 2, 0]
    maker.close()
    assert seen[0] is seen[1] is seen[2] is not seen[3]

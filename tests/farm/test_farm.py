"""Work on workers: the bytes of a run without them, whatever happens to one of them."""

from __future__ import annotations

import logging
import os
import platform
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

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
from ssdo_gl.farm import kept_maker, scheduler
from ssdo_gl.farm.scenes import CapturedWork
from ssdo_gl.farm.scheduler import FarmError, check_scheduler, connected, mapped
from ssdo_gl.gpu.warm_device import WarmDevice
from ssdo_gl.headless.progress import StageProgress
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import SceneError
from ssdo_gl.settings import Settings
from ssdo_gl.settings.flags import CommandLine

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
cloudpickle = pytest.importorskip("cloudpickle")

# Dask's own threads and sockets end when it likes, after a test.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

FILM = ["--turntable", "--frames-range", "0:5", "--size", "48x27", "--method", "direct", "--quiet"]


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """Two workers, as ``dask worker`` starts them."""
    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        # After 15 s a cluster ends what restarts a worker; under load that takes longer.
        dask.config.set({"distributed.deploy.lost-worker-timeout": "1 day"}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit=None
        ) as cluster,
    ):
        yield cluster.scheduler_address
    cloudpickle.unregister_pickle_by_value(sys.modules[__name__])


class Squares:
    """Squares numbers; the first process that meets `deadly` dies of it."""

    def __init__(self, task: tuple[Path, int | None]) -> None:
        self.folder, self.deadly = task
        (self.folder / f"opened-{os.getpid()}").touch()

    def make(self, item: int) -> int:
        if item == self.deadly:
            try:
                (self.folder / "died").touch(exist_ok=False)
            except FileExistsError:
                return item**2
            os._exit(1)
        return item**2

    def close(self) -> None:
        pass


class Broken(Squares):
    def make(self, item: int) -> int:
        raise SceneError(f"item {item}: as it is")


class Deadly(Squares):
    def make(self, item: int) -> int:
        os._exit(1)


class Fatal(Squares):
    def make(self, item: int) -> int:
        return os._exit(1) if item == self.deadly else item**2


class Held(Squares):
    """Makes the first items at once, and others a second after it may."""

    FREE = 6

    def make(self, item: int) -> int:
        (self.folder / f"begun-{item}").touch()
        if item >= self.FREE:
            wait_for((self.folder / "go").exists)
            time.sleep(1.0)
        (self.folder / f"ended-{item}").touch()
        return item


def wait_for(told: Callable[[], object]) -> None:
    end = time.monotonic() + 60.0
    while not told():
        assert time.monotonic() < end, "waited for in vain"
        time.sleep(0.02)


def ready(dask_worker: distributed.Worker) -> int:
    """Return how many tasks a worker would begin next."""
    return sum(task.state == "ready" for task in dask_worker.state.tasks.values())


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_results_come_in_order_from_makers_that_stay_open(address: str, tmp_path: Path) -> None:
    made = list(mapped(address, Squares, (tmp_path, None), range(100)))
    assert made == [n**2 for n in range(100)]
    assert 1 <= len(contents(tmp_path)) <= 2


def test_a_worker_that_dies_loses_nothing(address: str, tmp_path: Path) -> None:
    made = list(mapped(address, Squares, (tmp_path, 41), range(100)))
    assert made == [n**2 for n in range(100)]
    assert "died" in contents(tmp_path)


def test_faults_come_as_they_are(address: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="item 0: as it is"):
        list(mapped(address, Broken, (tmp_path, None), range(9)))
    with pytest.raises(FarmError, match="has ended several workers"):
        list(mapped(address, Deadly, (tmp_path, None), range(2)))


class Chosen(Squares):
    def make(self, item: int) -> int:
        time.sleep(0.1)
        super().make(item)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN, "Ctrl-C is the command's"
        assert signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, []), "from the start"
        return int(os.environ.get("GLCONTEXT_DEVICE_INDEX", "-1"))


@pytest.mark.parametrize(("gpus", "chosen", "seen"), [([3, 5], None, {3, 5}), ([3, 5], "0", {0})])
def test_local_workers_share_out_the_gpus_and_come_back(
    gpus: list[int],
    chosen: str | None,
    seen: set[int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(scheduler, "gpu_numbers", lambda: gpus)
    monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
    if chosen:
        monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", chosen)
    name = "local" if len(seen) > 1 else "local:1"
    deadly = 7 if chosen else None
    # A worker takes longer to start than that.
    with dask.config.set({"distributed.deploy.lost-worker-timeout": "0.1s"}):
        assert set(mapped(name, Chosen, (tmp_path, deadly), range(20))) == seen


def test_workers_that_end_late_hide_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Under load Dask gives up waiting for them: an interrupt stays one, and so does a result."""
    close = distributed.SpecCluster.close

    def closed_late(cluster: object) -> None:
        close(cluster)
        raise TimeoutError

    monkeypatch.setattr(distributed.SpecCluster, "close", closed_late)
    with pytest.raises(KeyboardInterrupt), connected("local:1"):
        raise KeyboardInterrupt


def test_an_item_that_ends_workers_costs_no_other(address: str, tmp_path: Path) -> None:
    made = list(mapped(address, Fatal, (tmp_path, 5), range(48), lambda item: -item))
    assert made == [-5 if n == 5 else n**2 for n in range(48)]


def test_workers_are_at_rest_before_times_are_measured(address: str, tmp_path: Path) -> None:
    with connected(address) as farm, distributed.Client(address) as client:
        made = farm.job(Held, (tmp_path, None)).results(range(1_000_000), chunk=1)
        # An item that waits may stand in the way of an earlier one, where a worker that other
        # tests have ended is not back yet: no free one is left when the others begin.
        assert [next(made) for _ in range(Held.FREE)] == list(range(Held.FREE))
        wait_for(lambda: any(client.run(ready).values()))
        made.close()
        wait_for(lambda: not any(client.run(ready).values()))
        (tmp_path / "go").touch()
        farm.settle()
        names = contents(tmp_path)
    begun = {name[6:] for name in names if name.startswith("begun-")}
    assert begun == {name[6:] for name in names if name.startswith("ended-")}
    assert Held.FREE < len(begun) <= Held.FREE + 2, "what was not begun is left"


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


def test_workers_of_another_version_are_refused(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scheduler, "__version__", "0.0.1")
    with pytest.raises(FarmError, match=r"a worker has ssdo_gl .*, this command is 0\.0\.1"):
        list(mapped(address, Squares, (tmp_path, None), range(2)))


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


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scheduler", "local:0"], "--scheduler 'local:0': expected local, local:N (workers) or"),
        (["--scheduler", "host:8786"], "expected local, local:N (workers) or tcp://HOST:PORT"),
        (["--scheduler", "ucx://127.0.0.1:9"], "expected local, local:N (workers) or tcp://HOST"),
        (["--scheduler", "tcp://127.0.0.1:9"], "tcp://127.0.0.1:9: no scheduler answers"),
    ],
)
def test_schedulers_that_are_none_are_refused_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    words: list[str],
    said: str,
) -> None:
    monkeypatch.setattr(scheduler, "CONNECT_S", 0.2)
    log = logging.getLogger("distributed")
    monkeypatch.setattr(log, "level", logging.INFO)
    assert main(["corner", "--film", str(tmp_path / "turn"), *FILM, *words]) == 2
    assert "answers" not in said or log.level == logging.CRITICAL, "Dask would say it, too"
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and said in lines[0]
    assert list(tmp_path.iterdir()) == []


def test_a_scheduler_without_workers_is_said_to_have_none(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scheduler, "WORKERS_S", 0.2)
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=":0") as cluster,
        pytest.raises(FarmError, match=r"no worker within 0\.2 s; start some: dask worker"),
    ):
        list(mapped(cluster.scheduler_address, Squares, (tmp_path, None), [1]))


def test_workers_that_do_not_come_back_are_waited_for_no_longer_than_said(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(scheduler, "LOOK_S", 0.05)
    monkeypatch.setattr(scheduler, "ABSENT_S", 0.3)
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as cluster:
        made = mapped(cluster.scheduler_address, Held, (tmp_path, None), range(9))
        assert [next(made) for _ in range(Held.FREE)] == list(range(Held.FREE))
        cluster.scale(0)
        (tmp_path / "go").touch()
        with pytest.raises(FarmError, match=r"^no worker is left, for 0\.3 s now$"):
            list(made)


def test_a_scheduler_that_is_gone_is_said_to_be(tmp_path: Path) -> None:
    with distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=":0") as cluster:
        made = mapped(cluster.scheduler_address, Held, (tmp_path, None), range(9))
        assert [next(made) for _ in range(Held.FREE)] == list(range(Held.FREE))
        (tmp_path / "go").touch()
    with pytest.raises(FarmError, match=r"^the scheduler answers no more$"):
        list(made)


def test_standard_input_and_output_stay_here(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["corner", "--snapshot", "-", "--scheduler", "local"]) == 2
    assert "workers have no standard input or output" in capsys.readouterr().err


def test_without_dask_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(FarmError, match=r"pip install 'ssdo_gl\[farm\]'"):
        check_scheduler("local")


def test_a_worker_keeps_the_maker_of_one_job(tmp_path: Path) -> None:
    import pickle

    closed = []

    class Closing(Squares):
        def close(self) -> None:
            closed.append(self.folder)

    version = kept_maker.__version__
    for job in ("a", "a", "b"):
        task = pickle.dumps((tmp_path / job, None))
        (tmp_path / job).mkdir(exist_ok=True)
        assert kept_maker.results(job, version, Closing, task, [3]) == [9]
    assert closed == [tmp_path / "a"]

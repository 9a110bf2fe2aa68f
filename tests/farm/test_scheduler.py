"""Work on workers: results in order, whatever happens to one of them."""

from __future__ import annotations

import logging
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from farm.film_of_five import FILM, contents

from ssdo_gl.cli import main
from ssdo_gl.farm import kept_maker, scheduler
from ssdo_gl.farm.scheduler import FarmError, check_scheduler, connected, mapped
from ssdo_gl.scene.scene_error import SceneError

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
pytest.importorskip("cloudpickle")

# Dask's own threads and sockets end when it likes, after a test.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


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


def test_workers_of_another_version_are_refused(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scheduler, "__version__", "0.0.1")
    with pytest.raises(FarmError, match=r"a worker has ssdo_gl .*, this command is 0\.0\.1"):
        list(mapped(address, Squares, (tmp_path, None), range(2)))


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

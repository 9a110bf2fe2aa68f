"""Frames of this tree against those of a commit: ratios, bad input, and nothing that stays."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time

import pytest

from benchmarks import against_commit
from benchmarks.against_commit import Ratio, cell_of, compare
from benchmarks.checkout import ROOT, CommitError, checked_out, full_name

try:
    full_name("HEAD")
except CommitError:
    pytest.skip("not a repository", allow_module_level=True)

TINY = ["--size", "48x27", "--rounds", "3", "--frames", "2"]


@pytest.fixture
def trees(tmp_path, monkeypatch):
    """Return what tells which work trees the test has made."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))

    def listed() -> list[str]:
        done = subprocess.run(["git", "worktree", "list"], cwd=ROOT, capture_output=True, text=True)
        found = [line.split()[0] for line in done.stdout.splitlines() if str(tmp_path) in line]
        return found + [str(path) for path in tmp_path.glob("ssdo-gl-commit-*")]

    return listed


class Scripted:
    """A side whose frames take what a list says."""

    def __init__(self, name, times, log):
        self.name, self._times, self._log = name, iter(times), log

    def warm(self, case):
        return 12

    def frames_ms(self, case, first, count):
        self._log.append((self.name, first, count))
        return next(self._times)


def test_a_ratio_is_the_median_of_rounds_in_which_sides_take_turns():
    log: list[tuple[str, int, int]] = []
    sides = [Scripted("a", (2.0, 30.0, 9.0), log), Scripted("b", (1.0, 10.0, 9.0), log)]
    (found,) = compare("still", "corner", sides, 3, 4)
    assert found.ratios == (2.0, 3.0, 1.0) and found.median == 2.0
    assert (found.ms, found.other_ms) == (9.0, 9.0)
    assert found.spread == pytest.approx(0.25)
    assert [name for name, _, _ in log] == ["b", "a", "a", "b", "b", "a"]
    assert [first for _, first, _ in log] == [12, 12, 16, 16, 20, 20]


def test_a_cell_shows_this_tree_first_and_the_commit_in_brackets():
    found = [Ratio("corner", "still", "x", 1.0, 1.0, (ratio,)) for ratio in (1.184, 0.866)]
    assert cell_of(found) == "1.18 (.87)"
    assert cell_of("has no lamp") == "has no lamp"


def test_frames_of_a_commit_are_held_to_those_of_this_tree(trees, tmp_path, capsys):
    file = tmp_path / "found.csv"
    arguments = ["HEAD", "corner", "--method", "direct", "--other-method", "direct"]
    arguments += ["--size", "128x72", "--output", str(file)]
    assert against_commit.main(arguments) == 0
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert [row["case"] for row in rows] == ["still", "camera", "lamps"]
    for row in rows:
        assert 0.0 < float(row["lowest"]) <= float(row["ratio"]) <= float(row["highest"])
    out = capsys.readouterr().out
    assert "nothing moves" in out and "corner" in out and "quartile" not in out
    assert trees() == []


def test_a_slower_method_is_slower_than_that_of_both_trees(tmp_path, capsys):
    file = tmp_path / "found.json"
    arguments = ["HEAD", "courtyard", *TINY, "--other-method", "direct", "--output", str(file)]
    assert against_commit.main([*arguments, "--cases", "camera", "lamps"]) == 0
    found = json.loads(file.read_text())
    assert [row["ratio"] > 1.5 for row in found["rows"]] == [True, True]
    assert [row["case"] for row in found["rows"]] == ["camera", "camera"]
    assert "has no lamp" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["no-such-commit"], "'no-such-commit': there is no such commit here"),
        (["HEAD:README.md"], "'HEAD:README.md': there is no such commit here"),
        (["HEAD", "corners"], "no built-in scene is called 'corners'"),
        (["HEAD", "corner", "--method", "gl"], "this tree: method = 'gl'"),
        (["HEAD", "corner", "--size", "1"], "size = '1'"),
        (["HEAD", "corner", "corners"], "no built-in scene is called 'corners'"),
        (
            ["HEAD", "corner", "--output", "no/such.csv"],
            "no/such.csv: the folder no does not exist",
        ),
        (["HEAD", "corner", "--output", "x.txt"], "x.txt: the suffix must be one of .json, .csv"),
    ],
)
def test_bad_input_is_one_line(arguments, line, trees, capsys):
    assert against_commit.main(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"against_commit: {line}") and said.count("\n") == 1
    assert trees() == []


def test_without_a_repository_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.checkout.ROOT", tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    with pytest.raises(CommitError, match="not a git repository"), checked_out("HEAD"):
        pass
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CommitError, match="no such command"):
        full_name("HEAD")


@pytest.mark.skipif(sys.platform == "win32", reason="sends signals")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_comparison_leaves_nothing(number, code, trees):
    command = [sys.executable, "-m", "benchmarks.against_commit", "HEAD", "corner"]
    command += ["--size", "64x36", "--rounds", "900"]
    process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    assert process.stderr.readline() == "corner: nothing moves ...\n"
    tree, _ = trees()
    time.sleep(0.5)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == code and "Traceback" not in said
    assert trees() == []
    processes = subprocess.run(["ps", "-eo", "args"], capture_output=True, text=True).stdout
    assert tree not in processes

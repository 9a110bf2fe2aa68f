"""Every benchmark is called in the same way and says what it is for."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent.parent / "benchmarks"
SCRIPTS = sorted(p.stem for p in FOLDER.glob("*.py") if "__main__" in p.read_text())
MAKEFILE = (FOLDER.parent / "Makefile").read_text()


def test_there_are_scripts():
    assert len(SCRIPTS) >= 6


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_explains_itself(name, capsys):
    module = importlib.import_module(f"benchmarks.{name}")
    with pytest.raises(SystemExit) as ended:
        module.main(["--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert f"python -m benchmarks.{name}" in text
    targets = re.findall(r"``make ([a-z-]+)``", text)
    assert bool(targets) == (f"benchmarks.{name}" in MAKEFILE)
    for target in targets:
        assert re.search(rf"^{target}:", MAKEFILE, re.MULTILINE), target


# What each of the scripts is asked that it cannot do; FILE is one where a folder would be made.
FAULTS = [
    "against_commit no-such-commit",
    "against_commit HEAD corner corners",
    "all_estimators FILE --quick",
    "all_light corner corners",
    "all_light corner nosuch.glb",
    "all_light room-1 --size 0 9",
    "far_field_cost corner corners",
    "far_field_cost corner --size 1",
    "gpu FILE",
    "gpu OUT --only ray",
    "gpu OUT --only images --compare nosuch",
    "input_latency corners",
    "input_latency corner --size wide",
    "large 0",
    "large many",
    "motion_equal_time --cases still",
    "motion_equal_time --size 0 9",
    "motion_equal_time --spp 0",
    "motion_errors --cases still",
    "pass_times corners",
    "pass_times corner --rounds 0",
    "peers FILE",
    "peers OUT --size 9",
    "peers OUT --three nosuch",
    "planning_gain corner corners",
    "planning_gain corner --method gl",
    "planning_gain corner --rounds 0",
    "promises corner corners",
    "python_time corners",
    "python_time corner --frames 0",
    "ray_speed corner corners",
    "render_fidelity nosuch.glb",
    "render_fidelity --spp 0",
    "rungs FILE corner",
    "rungs OUT corner corners",
    "rungs OUT corner --size wide",
    "walk_errors corner corners",
    "walk_errors corner --spp 0",
    "walk_errors corner --size 0 9",
]


def test_faults_of_all_scripts_are_tried():
    assert {fault.split()[0] for fault in FAULTS} == set(SCRIPTS)


@pytest.mark.parametrize("fault", FAULTS)
def test_what_cannot_be_done_is_one_line(fault, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("FILE").touch()
    name, *words = fault.split()
    module = importlib.import_module(f"benchmarks.{name}")
    try:
        code = module.main(words)
    except SystemExit as ended:
        code = ended.code
    said = capsys.readouterr()
    assert code == 2
    assert said.err.count("\n") == 1 and name in said.err.split(":")[0]
    # Nothing was measured before.
    assert not re.search(r"\| [\d.-]", said.out)

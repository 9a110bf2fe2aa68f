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
    assert bool(targets) == (f"benchmarks.{name}" in MAKEFILE or name == "report_table")
    for target in targets:
        assert re.search(rf"^{target}:", MAKEFILE, re.MULTILINE), target

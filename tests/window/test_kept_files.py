"""What a window keeps, where there is a place for it and where there is none."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from ssdo_gl.window.kept_files import Recent, keep, kept, usual_file

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="folders of another system")


@pytest.fixture
def homeless(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("HOME", "XDG_STATE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)


def test_a_value_lasts(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    file = usual_file("x.json")
    assert file == tmp_path / ".local" / "state" / "ssdo_gl" / "x.json"
    assert kept(file) is None
    keep(file, [1, 2])
    assert kept(file) == [1, 2]


@pytest.mark.usefixtures("homeless")
def test_a_user_without_a_home_does_without(tmp_path: Path) -> None:
    assert usual_file("x.json") is None
    keep(None, 1)
    assert kept(None) is None
    recent = Recent()
    recent.add(str(tmp_path))
    assert recent.paths() == []


@pytest.mark.usefixtures("homeless")
def test_a_folder_that_is_named_needs_no_home(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    recent = Recent()
    recent.add(str(tmp_path))
    assert recent.paths() == [str(tmp_path.resolve())]

"""The driver's cache: left alone where the disk cannot hold it."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from ssdo_gl.gpu.context import create_context

DISABLE = "MESA_SHADER_CACHE_DISABLE"


@pytest.mark.parametrize(
    ("variable", "beneath"),
    [("MESA_SHADER_CACHE_DIR", "a/b"), ("XDG_CACHE_HOME", ""), ("HOME", "")],
)
@pytest.mark.parametrize(("free", "disabled"), [(40_000, "true"), (1 << 30, None)])
def test_a_full_disk_gets_no_cache(
    monkeypatch, tmp_path: Path, variable: str, beneath: str, free: int, disabled: str | None
) -> None:
    asked = []

    def disk_usage(folder: Path) -> SimpleNamespace:
        asked.append(folder)
        return SimpleNamespace(free=free)

    # Set and taken away: what the call sets is taken back at the end.
    monkeypatch.setenv(DISABLE, "")
    for name in (DISABLE, "MESA_SHADER_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(variable, str(tmp_path / beneath))
    monkeypatch.setattr(shutil, "disk_usage", disk_usage)
    create_context().release()
    assert os.environ.get(DISABLE) == disabled
    assert asked == [tmp_path]


def test_what_somebody_has_chosen_stays(monkeypatch) -> None:
    monkeypatch.setenv(DISABLE, "false")
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=0))
    create_context().release()
    assert os.environ[DISABLE] == "false"

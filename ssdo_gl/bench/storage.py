"""Files of a bench: written whole or not at all; caches where the system keeps them."""

from __future__ import annotations

import csv
import errno
import hashlib
import io
import json
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.process import home_folder
from ssdo_gl.user_error import UserError
from ssdo_gl.whole_files import replace_whole

# Says that a folder is a bench's, and of which bench: no other file is proof of that.
MARKER = "ssdo_gl-bench.json"
ERRORS = "errors"
ROUNDS = "rounds.csv"
# What a bench writes into its folder besides the marker.
BENCH_FILES = (
    ERRORS, ROUNDS, "points.csv", "bench.json", "pareto.png", "pareto.svg", "report.html",
    "estimators.csv", "estimators.md", "estimators.png",
)  # fmt: skip


class BenchError(UserError, ValueError):
    """A bench that cannot run: one line naming the path or setting and the cure."""


def claim_folder(folder: Path) -> None:
    """Make `folder` the folder of a bench.

    Raises
    ------
    BenchError
        If it cannot be written, or holds files of a bench's names that no bench made:
        nothing of anybody else's is ever overwritten or removed.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except FileExistsError:
        raise BenchError(f"{folder} is a file: name a folder") from None
    except OSError as error:
        raise BenchError(f"{folder}: cannot be written: {error.strerror}") from None
    marker = folder / MARKER
    is_ours = marker.is_file() and not marker.is_symlink()
    foreign = [
        name
        for name in (MARKER, *BENCH_FILES)
        if (os.path.lexists(folder / name) and not (is_ours or name == MARKER))
        or (folder / name).is_symlink()
        or ((folder / name).exists() and (folder / name).is_dir() != (name == ERRORS))
    ]
    if foreign:
        raise BenchError(
            f"{folder}: holds {', '.join(foreign)}, which no bench made;"
            " name another folder, or move them away"
        )
    if not is_ours:
        replace_json(marker, {})


@contextmanager
def claimed_folder(folder: Path) -> Iterator[None]:
    """Claim `folder` for a bench, which leaves it as it was if it ends with nothing to keep.

    Raises
    ------
    BenchError
        As `claim_folder` does.
    """
    was_there = folder.exists()
    claim_folder(folder)
    try:
        yield
    except BaseException:
        if not holds_bench(folder):
            (folder / MARKER).unlink(missing_ok=True)
            with suppress(OSError):  # it holds something of the user's
                if not was_there:
                    folder.rmdir()
        raise


def holds_bench(folder: Path) -> bool:
    """Return whether a bench's folder has anything of it besides the marker."""
    return any((folder / name).exists() for name in BENCH_FILES)


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; None if there is none or it is damaged."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def save_arrays(path: Path, meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Replace `path` by an ``.npz`` of `arrays` and `meta` (JSON), with a hash at its end."""
    buffer = io.BytesIO()
    content: dict[str, Any] = {**arrays, "meta": np.array(json.dumps(meta))}
    np.savez_compressed(buffer, **content)
    data = buffer.getvalue()
    replace_file(path, data + hashlib.sha256(data).digest())


def load_arrays(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]] | None:
    """Return what `save_arrays` wrote as (meta, arrays); None if not a byte of it is sure.

    Nothing in the file can run code: pickled objects are refused.
    """
    size = hashlib.sha256().digest_size
    try:
        stored = path.read_bytes()
        data, digest = stored[:-size], stored[-size:]
        if hashlib.sha256(data).digest() != digest:
            return None
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("meta"))), arrays
    except (OSError, ValueError, KeyError):
        return None


def cache_folder(kind: str) -> Path:
    """Return the user's cache folder for `kind`, created if need be.

    ``SSDO_GL_CACHE`` names another place; else the convention of the system holds.
    """
    chosen = os.environ.get("SSDO_GL_CACHE")
    variable, *usual = {
        "win32": ("LOCALAPPDATA",),
        "darwin": ("", "Library", "Caches"),
    }.get(sys.platform, ("XDG_CACHE_HOME", ".cache"))
    of_system, home = os.environ.get(variable), home_folder()
    if not (chosen or of_system) and home is None:
        raise BenchError("the user has no home folder: set SSDO_GL_CACHE to one for the cache")
    base = Path(of_system) if of_system else Path(home or "", *usual)
    folder = (Path(chosen) if chosen else base / "ssdo_gl") / kind
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchError(
            f"{folder}: cannot be created ({error.strerror}); set SSDO_GL_CACHE to another folder"
        ) from None
    return folder


def usual_folder(kind: str, what: str) -> Path | None:
    """Return `cache_folder`, or None where there is none, and say that `what` is not kept."""
    try:
        return cache_folder(kind)
    except BenchError as error:
        say_not_kept(what, error)
        return None


def say_not_kept(what: str, error: BenchError) -> None:
    """Say that `what` has to be measured again next time."""
    print(f"ssdo-gl: {what} are not kept: {error}", file=sys.stderr)


def replace_file(path: Path, data: bytes) -> None:
    """Replace `path` by `data` in one step; a failure leaves the old file untouched."""
    try:
        replace_whole(path, data)
    except OSError as error:
        raise BenchError(f"{path}: cannot be written: {error.strerror}") from None


def replace_json(path: Path, content: Any) -> None:
    """Replace `path` by `content` as indented JSON."""
    replace_file(path, json_bytes(content))


def json_bytes(content: Any) -> bytes:
    """Return `content` as a file of indented JSON."""
    return (json.dumps(content, indent=1, sort_keys=True) + "\n").encode()


def csv_bytes(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return rows as a CSV file; a cell is empty where a row lacks what another one has."""
    names = dict.fromkeys(name for row in rows for name in row)
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(names), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue().encode()


def append_line(path: Path, line: str) -> None:
    """Append one line in a single write, so that a killed run loses at most that line.

    Raises
    ------
    BenchError
        Nothing of the line is then left in the file.
    """
    data = line.encode() + b"\n"
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o666)
        try:
            size = os.fstat(handle).st_size
            # Of a disk that has room for a part of it, a write takes that part.
            if os.write(handle, data) < len(data):
                os.ftruncate(handle, size)
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        finally:
            os.close(handle)
    except OSError as error:
        raise BenchError(f"{path}: cannot be written: {error.strerror}") from None


def whole_lines(path: Path) -> list[str]:
    """Return the lines of `path`; one that a killed run left unfinished is cut off.

    The cut is made in the file, too, so that the next line does not continue it.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return []
    except OSError as error:
        raise BenchError(f"{path}: cannot be read: {error.strerror}") from None
    end = data.rfind(b"\n") + 1
    if end != len(data):
        replace_file(path, data[:end])
    return data[:end].decode(errors="replace").splitlines()

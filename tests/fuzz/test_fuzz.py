"""Damaged files by the thousand: a scene, or one line that refuses them.

make fuzz FUZZ_SEED=7 FUZZ_COUNT=5000
"""

from __future__ import annotations

import random
import shutil
import time
import traceback
from pathlib import Path

import numpy as np
import pytest
from fuzz.damage import damaged
from fuzz.originals import KINDS, of_kind
from fuzz.watch import HangError, address_space, peak_bytes, watched

from ssdo_gl.bench.presets import load_preset
from ssdo_gl.scene.animate import scene_at
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.scene.scene_error import SceneError
from ssdo_gl.settings.fields import SettingError

pytestmark = pytest.mark.fuzz

LONGEST_SECONDS = 10.0
# What reading one of these files, none larger than a megabyte, may add to the peak.
MOST_BYTES = 1 << 30
LONGEST_LINE = 600
SHOWN = 12


def not_finite(scene: Scene) -> str:
    """Return what single precision does not hold of a scene, or an empty string."""
    for mesh in scene.meshes:
        for name in ("positions", "normals", "uvs", "colors"):
            values = getattr(mesh, name)
            if values is not None and not np.isfinite(values.astype(np.float32)).all():
                return f"{name} of mesh {mesh.name!r}"
    for material in scene.materials:
        for name in ("albedo", "emission", "specular_color", "roughness", "metallic", "ior"):
            if not np.isfinite(np.float32(getattr(material, name))).all():
                return f"{name} of material {material.name!r}"
    for item in scene.objects:
        if not np.isfinite(item.world_from_object.astype(np.float32)).all():
            return f"matrices of object {item.name!r}"
    camera = scene.camera
    if not np.isfinite(np.float32([*camera.position, *camera.target])).all():
        return "the camera"
    return ""


def attempt(kind: str, path: Path, valid: bool = False) -> str:
    """Open a file; return what is wrong with how that went, or an empty string.

    A file that is not `valid` may be refused.
    """
    try:
        if kind == "presets":
            load_preset(str(path))
            return ""
        scene = load_scene(path)
        return not_finite(scene) or not_finite(scene_at(scene, 0.3))
    except (SceneError, SettingError) as error:
        message = str(error).replace(str(path), path.name)
        if valid:
            return f"refused: {message}"
        if "\n" in message or len(message) > LONGEST_LINE:
            return f"a message of {len(message)} characters: {message[:80]!r}"
        return ""
    except (Exception, HangError) as error:
        place = [f for f in traceback.extract_tb(error.__traceback__) if "ssdo_gl" in f.filename]
        where = f"{Path(place[-1].filename).name}:{place[-1].lineno}" if place else "?"
        return (
            f"{type(error).__name__} at {where}: {str(error).replace(str(path.parent), '')[:100]}"
        )


@pytest.mark.parametrize("kind", KINDS)
def test_damaged_files_are_refused_in_one_line(
    kind: str, tmp_path: Path, pytestconfig: pytest.Config, capfd: pytest.CaptureFixture[str]
) -> None:
    seed, count = pytestconfig.getoption("fuzz_seed"), pytestconfig.getoption("fuzz_count")
    originals = of_kind(kind, tmp_path)
    if kind == "compressed":
        count //= 10  # each starts a process
    for name in ("secret.png", "secret.obj", "secret.mtl"):
        (tmp_path / name).write_bytes(b"secret")
    faults: dict[str, str] = {}
    for number, files in enumerate(originals):  # so that each is worth damaging
        folder = tmp_path / f"original{number}"
        written(folder, files)
        path = folder / next(iter(files))
        if fault := attempt(kind, path, valid=True):
            faults[fault] = str(path)
    for number in range(count):
        rng = random.Random(f"{seed}/{kind}/{number}")
        files = damaged(rng.choice(originals), rng)
        folder = tmp_path / f"case{number}"
        written(folder, files)
        path = folder / next(iter(files))
        peak, start = peak_bytes(), time.monotonic()
        with address_space(4 * MOST_BYTES), watched(folder, LONGEST_SECONDS) as seen:
            fault = attempt(kind, path)
        fault = "; ".join([*([fault] if fault else []), *seen])
        if time.monotonic() - start > LONGEST_SECONDS:
            fault += f" took {time.monotonic() - start:.0f} s"
        if peak_bytes() - peak > MOST_BYTES:
            fault += f" took {(peak_bytes() - peak) >> 20} MiB"
        output = capfd.readouterr()
        if output.out or output.err:
            fault += f" printed {(output.out + output.err)[:80]!r}"
        if fault and fault not in faults:
            faults[fault] = str(path)
        elif not fault:
            shutil.rmtree(folder)
    shown = [f"{path}: {fault}" for fault, path in list(faults.items())[:SHOWN]]
    assert not faults, f"{len(faults)} kinds of fault:\n" + "\n".join(shown)


def written(folder: Path, files: dict[str, bytes]) -> None:
    folder.mkdir()
    for name, content in files.items():
        (folder / name).write_bytes(content)

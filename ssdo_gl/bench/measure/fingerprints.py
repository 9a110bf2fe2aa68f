"""Hashes plain data - scenes, settings, shader files - so that results can be cached."""

from __future__ import annotations

import dataclasses
import hashlib
import re
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

import numpy as np

from ssdo_gl import resources
from ssdo_gl.gpu.shader import read_shader
from ssdo_gl.scene.scene import Scene

# Names are relative to the shader folder wherever they are written.
_CHOSEN = re.compile(r"^\s*#\s*include\s+<(\w+)>", re.MULTILINE)
_INCLUDED = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def fingerprint(*values: Any) -> str:
    """Return a hash (32 hex digits) of nested plain data.

    Two values have the same hash exactly when they hold the same types, names, numbers
    and arrays; the order of a mapping's keys does not count.

    Raises
    ------
    TypeError
        For anything that is not plain data, whose hash would be an accident.
    """
    digest = hashlib.sha256()
    for value in values:
        _feed(digest, value)
    return digest.hexdigest()[:32]


def _feed(digest: Any, value: Any) -> None:
    """Add one value; every item is preceded by its kind and length, so that no two
    different structures give the same bytes."""
    if value is None or isinstance(value, (bool, int, float, str, bytes, PurePath)):
        text = value if isinstance(value, bytes) else repr(value).encode()
        digest.update(f"{type(value).__name__}:{len(text)}:".encode() + text)
    elif isinstance(value, (np.ndarray, np.generic)):
        array = np.ascontiguousarray(value)
        digest.update(f"array:{array.dtype.str}:{array.shape}:".encode())
        digest.update(array.tobytes())
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        digest.update(f"data:{type(value).__name__}:{len(fields)}:".encode())
        for field in fields:
            _feed(digest, field.name)
            _feed(digest, getattr(value, field.name))
    elif isinstance(value, Mapping):
        digest.update(f"map:{len(value)}:".encode())
        for key in sorted(value, key=repr):
            _feed(digest, key)
            _feed(digest, value[key])
    elif isinstance(value, frozenset):
        digest.update(f"set:{len(value)}:".encode())
        for item in sorted(value, key=repr):
            _feed(digest, item)
    elif isinstance(value, (tuple, list)):
        digest.update(f"list:{len(value)}:".encode())
        for item in value:
            _feed(digest, item)
    else:
        raise TypeError(f"{type(value).__name__} is not plain data and cannot be hashed")


def scene_fingerprint(scene: Scene) -> str:
    """Return the hash of what a scene looks like at rest.

    Its title, notes and settings do not count.
    """
    return fingerprint(
        [dataclasses.replace(mesh, pose=None) for mesh in scene.meshes],
        scene.materials,
        [dataclasses.replace(item, motion=None) for item in scene.objects],
        scene.camera,
        [dataclasses.replace(light, motion=None) for light in scene.lights],
        scene.environment,
    )


def shader_fingerprint(prefixes: tuple[str, ...]) -> str:
    """Return the hash of the shaders whose names start with one of `prefixes`, in any folder.

    What they include counts, too, and nothing else.
    """
    root = resources.folder("shaders")
    folders = [("", root), *((f"{item.name}/", item) for item in root.iterdir() if item.is_dir())]
    waiting = [
        f"{path}{item.name}"
        for path, folder in folders
        for item in folder.iterdir()
        if item.is_file() and item.name.startswith(prefixes)
    ]
    texts: dict[str, str] = {}
    while waiting:
        name = waiting.pop()
        if name not in texts:
            texts[name] = read_shader(root, name)
            waiting += _INCLUDED.findall(texts[name])
            # One of several files that define the same, all in a folder named after it.
            waiting += [
                f"{choice}s/{item.name}"
                for choice in _CHOSEN.findall(texts[name])
                for item in root.joinpath(f"{choice}s").iterdir()
            ]
    return fingerprint(texts)

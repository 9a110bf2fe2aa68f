"""What a format is, to those who look for one that reads a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings.loading import LoadOptions

ModelReader = Callable[[Path, str], Model]
SceneReader = Callable[[Path, str, LoadOptions], Scene]


@dataclass(frozen=True)
class SceneFormat:
    """A kind of file that shows something.

    Attributes
    ----------
    title : str
        What errors and texts call it.
    suffixes : tuple of str
        With the dot, in lower case.
    read_model, read_scene : callable or None
        Exactly one of them. Given the path and what errors call the file, it returns
        its contents, which scenes may place; or, if the format describes whole scenes,
        that scene, completed by the options. It raises SceneError for what cannot be read.
    scan_up : "y", "z" or None
        Of formats of scans, smooth unless files have normals: the axis that usually points
        up. None: the format says +y.
    may_lie : bool
        Whether files exist whose up is not what the format says.
    """

    title: str
    suffixes: tuple[str, ...]
    read_model: ModelReader | None = None
    read_scene: SceneReader | None = None
    scan_up: str | None = None
    may_lie: bool = False


def lazily(module: str, function: str) -> Callable[..., Any]:
    """Return a reader of `module`, which is imported when it is first called."""

    def read(*arguments: Any, **named: Any) -> Any:
        return getattr(import_module(module), function)(*arguments, **named)

    return read

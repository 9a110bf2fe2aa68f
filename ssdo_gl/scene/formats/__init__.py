"""File formats: a module or folder each, found by suffix."""

from __future__ import annotations

from ssdo_gl.scene.formats.format_registry import (
    FORMATS,
    format_of,
    model_suffixes,
    read_model,
    scene_suffixes,
)
from ssdo_gl.scene.formats.model import Model
from ssdo_gl.scene.formats.scene_format import SceneFormat
from ssdo_gl.scene.formats.toml import read_description

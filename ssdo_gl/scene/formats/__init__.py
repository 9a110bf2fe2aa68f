"""File formats: a folder each, and one row in the registry that finds them by suffix."""

from ssdo_gl.scene.formats.format_registry import (
    FORMATS,
    SceneFormat,
    format_of,
    model_suffixes,
    read_description,
    read_model,
    scene_suffixes,
)
from ssdo_gl.scene.formats.model import Model

__all__ = [
    "FORMATS",
    "Model",
    "SceneFormat",
    "format_of",
    "model_suffixes",
    "read_description",
    "read_model",
    "scene_suffixes",
]

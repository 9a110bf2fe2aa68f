"""Named settings that come out of measured Pareto fronts.

``ladder.toml`` holds the rungs of the front, from fast to accurate, with the error that
was measured and the presets' names. ``make bench-presets`` prints it, and nobody writes it.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from ssdo_gl.options.preset_files import read_preset
from ssdo_gl.settings import Settings
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.fields import SettingError, shown
from ssdo_gl.settings.methods import METHODS
from ssdo_gl.wording import suggestion

# What a rung decides; everything else is the user's.
FIELDS = ("estimator", "samples", "steps", "resolution_scale", "filter")
NAMES = ("fast", "balanced", "fine", "reference")
# All light by paths, until its standard error is one percent of the mean: about
# where an error can no longer be seen beside the reference.
REFERENCE = {"method": "reference-gi", "max_error": 0.01}


@dataclass(frozen=True)
class PresetRung:
    """One setting of the ladder.

    Attributes
    ----------
    relative_time : float
        Frame time over that of the paper's SSDO with 8 samples and naive blur; geometric
        mean over the benched scenes.
    error : float
        RMSE over the mean of the near-field reference; mean over the benched scenes.
    """

    estimator: str
    samples: int
    steps: int
    resolution_scale: float
    filter: str
    relative_time: float
    error: float

    @property
    def label(self) -> str:
        """What a person reads."""
        count = ESTIMATORS[self.estimator].count_label(self.samples, self.steps)
        scale = "half" if self.resolution_scale == 0.5 else "full"
        return f"{self.estimator} {count} {scale} {self.filter}"

    def fields(self) -> dict[str, Any]:
        """Return the fields of `Settings` that this rung decides."""
        return {name: getattr(self, name) for name in FIELDS}

    def applied(self, settings: Settings) -> Settings:
        """Return `settings` at this rung."""
        return dataclasses.replace(settings, **fitting(self.fields(), settings.method)).checked()


def fitting(fields: Mapping[str, Any], method: str) -> dict[str, Any]:
    """Return `fields` without an estimator that `method` does not have."""
    known = fields.get("estimator") in METHODS[method].estimators
    return {name: value for name, value in fields.items() if name != "estimator" or known}


@dataclass(frozen=True)
class Ladder:
    """The measured front, from fast to accurate."""

    rungs: tuple[PresetRung, ...]
    presets: dict[str, int]
    source: dict[str, Any]


def read_ladder(text: str | None = None) -> Ladder:
    """Return the shipped ladder, or the one that `text` holds."""
    if text is None:
        text = files("ssdo_gl.bench").joinpath("ladder.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    rungs = tuple(PresetRung(**row) for row in data["rung"])
    return Ladder(rungs, dict(data["presets"]), dict(data["source"]))


def load_preset(name_or_file: str, method: str | None = None) -> dict[str, Any]:
    """Return the fields of `Settings` that a preset sets; flags win over them.

    Parameters
    ----------
    name_or_file : str
        ``fast``, ``balanced``, ``fine``, ``reference``, or a file that `read_preset` reads.
    method : str or None
        The method in force, if the user chose one: an estimator it lacks is left out.

    Raises
    ------
    SettingError
    """
    if name_or_file == "reference":
        return dict(REFERENCE) if method is None else {"max_error": REFERENCE["max_error"]}
    ladder = read_ladder()
    if name_or_file in ladder.presets:
        fields = ladder.rungs[ladder.presets[name_or_file]].fields()
        return fitting(fields, method or Settings().method)
    path = Path(name_or_file)
    if path.suffix.lower() != ".toml":
        hint = suggestion(name_or_file, NAMES)
        raise SettingError(f"--preset {shown(name_or_file)}: expected a name or a .toml file{hint}")
    return read_preset(path)

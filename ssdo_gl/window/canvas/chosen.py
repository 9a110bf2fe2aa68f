"""What a person has chosen to see: method, image, presets, settings. Needs no device."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from ssdo_gl.settings import Settings
from ssdo_gl.settings.pass_settings import overrides_from_table
from ssdo_gl.window.views import View, settings_of


class Chosen:
    """Settings and view, and the presets that change them.

    Parameters
    ----------
    presets : mapping of name to fields of Settings

    Attributes
    ----------
    settings : Settings
        The method is that of `view`.
    read_preset : callable or None
        Returns the fields of Settings in a file.
    """

    def __init__(self, settings: Settings, presets: Mapping[str, Mapping[str, Any]]) -> None:
        self.settings = settings
        self.view = View(method=settings.method)
        self.presets = presets
        self.read_preset: Callable[[str], Mapping[str, Any]] | None = None

    def choose_preset(self, name: str) -> None:
        """Take over what a preset sets; the method stays, unless the preset is one.

        Raises
        ------
        SettingError
            If a value is out of range; the settings then stay as they are.
        """
        self.settings = self._with_preset(self.presets[name])
        self.view = dataclasses.replace(self.view, method=self.settings.method)

    def add_preset(self, name: str, fields: Mapping[str, Any]) -> None:
        """Offer a preset and take it over; raises SettingError as `choose_preset` does."""
        self._with_preset(fields)
        self.presets = {**self.presets, name: fields}
        self.choose_preset(name)

    def _with_preset(self, fields: Mapping[str, Any]) -> Settings:
        method = fields.get("method", self.view.method)
        overrides_from_table(fields.get("overrides", {}))
        return settings_of(dataclasses.replace(self.settings, **fields), method).checked()

    def choose_method(self, method: str) -> None:
        """Show another method; an estimator that it does not know is dropped."""
        self.view = dataclasses.replace(self.view, method=method)
        self.settings = settings_of(self.settings, method)

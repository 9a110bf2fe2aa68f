"""How a file becomes a scene: what a user may choose before anything is drawn."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import PurePath
from types import NoneType
from typing import Any

from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import (
    SettingError,
    check,
    describe,
    documented,
    info_of,
    plain,
    setting,
    shown,
)
from ssdo_gl.settings.settings import LOOK
from ssdo_gl.wording import suggestion

# The value of --camera that frames the whole scene.
FIT = "fit"
SKY = "sky"
LIGHTS = ("auto", "file", "studio", SKY)
# Of --light sky: the afternoon, when shadows show what is round.
SKY_HOUR = 15.0
MAP_SUFFIXES = (".hdr", ".exr")
_look = partial(setting, group=LOOK, modes=modes.ALL)
# Of model files alone: scene files say it for each object.
_model = partial(_look, in_scene=False)


@dataclass(frozen=True)
class LoadOptions:
    """Choices for loading a scene; what is not given is decided by the file.

    Attributes
    ----------
    camera : str, int or None
        Which camera of a model file the scene is seen from: its name, or its number from 0 on.
        None: the first; ``fit``, among choices by name: as `frames_all`.
    frames_all : bool
        Whether the whole scene is framed even if the file has a camera.
    is_bare : bool
        Whether nothing is laid under a model whatever `ground` says: only what the file holds is
        asked for.
    """

    light: str = _look(
        "auto",
        "auto adds what the picture needs to the light of the file; file adds nothing;"
        " studio, a clear day at an hour (15 if none is given), or an .hdr or .exr map take the"
        " place of lamps and sky",
        metavar="file|auto|studio|sky[:HOUR]|PATH.hdr",
    )
    no_default_light: bool = _look(False, "add no light: as light file")
    normals: str | None = _model(
        None,
        "shading of models: smooth but for creases, flat, or as the file has them; by default"
        " smooth for scans (PLY, STL, OFF) without normals",
        choices=("smooth", "flat", "file"),
    )
    crease_angle: float = _model(
        45.0,
        "where triangles lean by more, smooth normals show an edge",
        unit="degrees",
        low=0.0,
        high=180.0,
        metavar="DEGREES",
    )
    up: str | None = _model(
        None,
        "axis of a model that points up; by default y, for scans guessed and said",
        choices=("y", "z"),
    )
    ground: str = _model(
        "auto",
        "auto lays a floor under a lone model in light that was added, for its shadow;"
        " none under a transparent picture",
        choices=("auto", "off"),
    )
    two_sided: bool = _look(False, "draw backs that a glTF file says to leave out")
    camera: str | int | None = None
    frames_all: bool = False
    is_bare: bool = False

    @property
    def map_path(self) -> str | None:
        """The environment map that lights the scene, if one was chosen."""
        chosen = self.light in LIGHTS or self.sky_hour is not None
        return None if chosen else self.light

    @property
    def sky_hour(self) -> float | None:
        """The solar time of the day that lights the scene, if one was chosen."""
        if self.light == SKY:
            return SKY_HOUR
        name, _, hour = self.light.partition(":")
        if name != SKY:
            return None
        try:
            value = float(hour)
        except ValueError:
            return None
        return value if 0.0 <= value <= 24.0 else None

    @property
    def lays_ground(self) -> bool:
        """Whether a ground may be laid under a model."""
        return self.ground == "auto" and not self.is_bare

    @property
    def adds_light(self) -> bool:
        """Whether light may be added to what the file brings."""
        return self.light == "auto" and not self.no_default_light

    @property
    def replaces_light(self) -> bool:
        """Whether other light takes the place of lamps and sky of the file."""
        return self.light not in ("auto", "file")

    def elsewhere(self, *, is_scene: bool) -> LoadOptions:
        """Return the choices for another file, or scene: of cameras it has its own, and an up."""
        infos = describe(LoadOptions).items()
        of_models = [name for name, info in infos if not info.in_scene]
        names = ["camera", *(of_models if is_scene else ["up"])]
        return dataclasses.replace(self, **{name: getattr(USUAL, name) for name in names})

    def checked(self) -> LoadOptions:
        """Return self after checking every field, or raise SettingError."""
        check(self)
        if not isinstance(self.camera, (str, int, NoneType)) or isinstance(self.camera, bool):
            raise SettingError(
                f"camera = {shown(self.camera)}: expected the name or number of one of the file's"
            )
        if self.no_default_light and self.replaces_light:
            raise SettingError(
                f"no_default_light belongs to light auto: {shown(self.light)} replaces all light"
            )
        suffix = PurePath(self.light).suffix.lower()
        if self.map_path is not None and suffix not in MAP_SUFFIXES:
            hint = suggestion(self.light, LIGHTS, lists=False)
            raise SettingError(
                f"light = {shown(self.light)}: expected {', '.join(LIGHTS)}, sky:HOUR (0 to 24) or"
                f" the path of a "
                f"{' or '.join(MAP_SUFFIXES)} map{hint}"
            )
        return self

    def check_scene(self, source: str) -> None:
        """Raise SettingError if anything was chosen that scene files say themselves."""
        if self.camera is not None:
            hint = suggestion(str(self.camera), [FIT], lists=False)
            raise SettingError(
                f"camera {shown(self.camera)}: {source} is a scene, which has one camera{hint}"
            )
        for name in self.given():
            info = describe(LoadOptions)[name]
            if not info.in_scene:
                raise SettingError(f"{name} belongs to model files: {source} is a scene")

    def given(self) -> dict[str, Any]:
        """Return the choices that differ from the defaults, by name."""
        values = {name: getattr(self, name) for name in describe(LoadOptions)}
        return {name: value for name, value in values.items() if value != getattr(USUAL, name)}


def named_camera(text: str | None) -> str | None:
    """Return what ``--camera`` says if that is the name or number of a camera in the file."""
    if text is None or text == FIT:
        return None
    if text.isdecimal():
        return text
    try:
        float(text.partition(",")[0])
    except ValueError:
        return text if re.search(r"[^\W\d_]", text) else None
    return None


documented(LoadOptions)
USUAL = LoadOptions()


def load_options(given: Mapping[str, Any]) -> LoadOptions:
    """Return checked options; raises SettingError for a name or value that is none."""
    for name in given:
        if name not in {field.name for field in dataclasses.fields(LoadOptions)}:
            info_of(LoadOptions, name, "option")
    if given.get("camera") == FIT:  # as of the flag
        given = {**given, "camera": None, "frames_all": True}
    return LoadOptions(**{name: plain(value) for name, value in given.items()}).checked()

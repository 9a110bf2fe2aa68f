"""What a command says of a film: its frames, and how the camera moves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import setting

FILM = "films"
FRAMES_PER_SECOND = 30.0
_film = partial(setting, group=FILM, modes=frozenset({modes.FILM}))


@dataclass(frozen=True)
class FilmOptions:
    """Frames, camera path and rate of a film."""

    path: str | None = _film(
        None,
        "the camera follows the path that a window has recorded",
        metavar="VIEWS.json",
    )
    turntable: float | None = _film(
        None,
        "the camera turns by this much about its target; without a number, once round",
        unit="degrees",
        low=-1e6,
        high=1e6,
        metavar="DEGREES",
        bare="360",
    )
    frames_range: str | None = _film(
        None,
        "render frames A to B - 1, of a film of B frames or of LENGTH; by default the whole path,"
        " or eight seconds of turntable",
        metavar="A:B[/LENGTH]",
    )
    fps: float = _film(
        FRAMES_PER_SECOND,
        "frames per second",
        low=1e-3,
        high=1000.0,
        metavar="N",
    )

"""What a command says of the fly-through in a browser: where it listens, whose camera it is."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import setting

BROWSER = "in a browser"
_serve = partial(setting, group=BROWSER, modes=frozenset({modes.SERVE}))


@dataclass(frozen=True)
class ServeOptions:
    """Address of the page, and whether those who look share a camera."""

    host: str | None = _serve(
        None,
        "listen at this address or name of the machine, 0.0.0.0 for all, and ask for a token; by"
        " default only programs of the same machine reach the page",
        metavar="ADDRESS",
    )
    port: int = _serve(
        8765, "listen at this port; 0: any that is free", low=0, high=65535, metavar="N"
    )
    viewers: str = _serve(
        "own",
        "cameras with which pages begin: one for each, or one for all; the panel changes it",
        choices=("own", "shared"),
    )

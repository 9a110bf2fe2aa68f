"""A picture of any size and method, rendered by a process of its own while the window goes on."""

from __future__ import annotations

import dataclasses
import shlex
import subprocess
import sys
from dataclasses import dataclass

from ssdo_gl.images.files import OutputError
from ssdo_gl.settings.backgrounds import TRANSPARENT
from ssdo_gl.window.saving.saved_view import save_scene, settings_shown, view_command
from ssdo_gl.window.saving.screenshot import free_stem
from ssdo_gl.window.viewer import Viewer
from ssdo_gl.window.views import settings_of

_KEY = "picture"


@dataclass(frozen=True)
class PictureRequest:
    """What picture is to be saved.

    Attributes
    ----------
    size : (int, int)
        Pixels.
    is_transparent : bool
        Whether there is nothing (alpha) where no surface is.
    name : str
        Of a file in the folder of the window; its suffix says what kind.
    """

    size: tuple[int, int]
    method: str
    is_transparent: bool
    name: str


class PictureJob:
    """At most one picture in the making, of the left side of `viewer`."""

    def __init__(self, viewer: Viewer) -> None:
        self._viewer = viewer
        self._process: subprocess.Popen[str] | None = None
        self._name = ""

    def usual_request(self) -> PictureRequest:
        """Return what the window shows, with a name that does not exist yet."""
        viewer = self._viewer
        name = free_stem(viewer.folder, "picture", ".png").name
        return PictureRequest(viewer.picture_size, viewer.view.method, False, name)

    def start(self, request: PictureRequest) -> None:
        """Begin; what goes wrong becomes a message."""
        viewer, path = self._viewer, self._viewer.folder / request.name
        if self._process is not None or path.exists():
            busy = f"wait for {self._name}" if self._process is not None else f"{path} exists"
            viewer.say(busy, is_fault=True, key=_KEY)
            return
        settings = dataclasses.replace(
            settings_of(settings_shown(viewer), request.method),
            size=request.size,
            background=TRANSPARENT if request.is_transparent else viewer.settings.background,
        )
        try:
            scene = save_scene(viewer) if viewer.is_edited else None
        except OutputError as error:
            viewer.say(str(error), is_fault=True, key=_KEY)
            return
        command = view_command(viewer, scene, str(path.resolve()), settings)
        words = [sys.executable, "-m", "ssdo_gl", *shlex.split(command)[1:], "--quiet"]
        self._name = request.name
        # A line at most: nobody has to read it meanwhile.
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=pipe, text=True)
        viewer.say(f"{request.name} is being rendered", key=_KEY)

    def poll(self) -> bool:
        """Tell how it has ended; return whether it has."""
        if self._process is None or self._process.poll() is None:
            return False
        _, faults = self._process.communicate()
        code, self._process = self._process.returncode, None
        said = faults.strip().splitlines()
        fault = said[-1] if said else f"the process ended with code {code}"
        text = f"{self._name}: {fault.removeprefix('ssdo-gl: ')}" if code else f"wrote {self._name}"
        self._viewer.say(text, is_fault=bool(code), key=_KEY)
        return True

    def give_up(self) -> None:
        """End the process, if there is one; nothing is written then."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self.poll()

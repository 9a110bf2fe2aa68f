"""What commands may ask of the window around the viewer."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ssdo_gl.scene.load import builtin_names
from ssdo_gl.window.actions import Host
from ssdo_gl.window.film import FilmExport
from ssdo_gl.window.glfw_window import GlfwWindow
from ssdo_gl.window.input import Command, InputMap
from ssdo_gl.window.opening import FileDialog, FileWatch, open_file, reload_file
from ssdo_gl.window.saving import PictureJob, PictureRequest
from ssdo_gl.window.viewer import Viewer

if TYPE_CHECKING:
    from ssdo_gl.window.overlay import Overlay

NO_PANEL = "there is no panel without imgui-bundle: pip install 'ssdo_gl[window]'"


class WindowHost(Host):
    """The window.

    Attributes
    ----------
    overlay : Overlay or None
        The panel and all else that is drawn over the picture; None: there is none.
    title : str
        Of the window.
    reload : callable
        Compiles shaders that have changed.
    """

    def __init__(
        self, window: GlfwWindow, viewer: Viewer, input_map: InputMap, film: FilmExport, title: str
    ) -> None:
        super().__init__()
        self.overlay: Overlay | None = None
        self._dialog = FileDialog()
        self._picture = PictureJob(viewer)
        self._scene_watch = FileWatch()
        self.title = title
        self.reload: Callable[[], None] = lambda: None
        self._window = window
        self._viewer = viewer
        self._input = input_map
        self._film = film
        self._waits = True
        self.commands = {
            Command.TOGGLE_PANEL: partial(self._toggle, "shows_panel"),
            Command.TOGGLE_HELP: partial(self._toggle, "shows_help"),
            Command.RELEASE: self._let_go,
            Command.RELOAD: lambda: self.reload(),
            Command.OPEN: self._ask_for_file,
            Command.SAVE_PICTURE: self._ask_for_picture,
            Command.EXPORT: film.toggle,
            Command.VSYNC: self._toggle_vsync,
            Command.FULLSCREEN: window.toggle_fullscreen,
            Command.QUIT: window.ask_to_close,
        }

    def open(self, path: str) -> None:
        """Show, between two frames, the model, scene or preset at `path`, or a built-in scene."""
        self.defer(partial(self._open, path))

    def _open(self, path: str) -> None:
        if open_file(path, self._viewer):
            if path not in builtin_names():
                self.recent.add(path)
            self.title = f"{Path(path).name} - ssdo_gl"
            self._window.set_title(self.title)

    def _ask_for_file(self) -> None:
        """Let the user choose a file, by the system's dialog or by its path."""
        if self.overlay is None:
            self._viewer.say("drop a file on the window to open it")
        elif FileDialog.exists():
            self._dialog.show(Path(self._viewer.source).parent)
        else:
            self.overlay.path_prompt.show()

    def _ask_for_picture(self) -> None:
        """Let the user say which picture is to be saved."""
        if self.overlay is None:
            self._viewer.say(NO_PANEL)
        else:
            self.overlay.picture_prompt.request = self._picture.usual_request()

    def save_picture(self, request: PictureRequest) -> None:
        """Render a picture in another process."""
        self.defer(partial(self._picture.start, request))

    def release(self) -> None:
        """Give up what is in the making elsewhere."""
        self._picture.give_up()

    def look_at_files(self) -> bool:
        """Open what a dialog has answered; read a scene again that has changed; tell of a picture.

        Returns whether there was any of it.
        """
        if self._picture.poll():
            return True
        path = self._dialog.answer()
        if path is not None:
            self._open(path)
            return True
        if self._scene_watch.poll(self._viewer.source):
            reload_file(self._viewer)
            return True
        return False

    def cursor_uv(self) -> tuple[float, float]:
        """Return the cursor's place in the picture; its middle while it is hidden."""
        (x, y), (width, height) = self._input.cursor_px, self._window.size
        return (0.5, 0.5) if self._input.is_looking else (x / max(1, width), y / max(1, height))

    def set_clipboard(self, text: str) -> None:
        self._window.set_clipboard(text)

    def _toggle_vsync(self) -> None:
        self._waits = not self._waits
        self._window.set_vsync(self._waits)
        self._viewer.say(f"{'waits' if self._waits else 'does not wait'} for the display")

    def _toggle(self, part: str) -> None:
        if self.overlay is None:
            self._viewer.say(NO_PANEL)
        else:
            setattr(self.overlay, part, not getattr(self.overlay, part))

    def _let_go(self) -> None:
        """Hide the list of keys and a light's handle; give up a film."""
        if self.overlay is not None:
            self.overlay.shows_help = False
            self.overlay.light_handle.hide()
        self._film.give_up()

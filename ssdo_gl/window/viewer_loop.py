"""What events ask of a viewer, done between frames, and the frames: in a window or far away."""

from __future__ import annotations

import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Callable

from ssdo_gl.gpu.shader import ShaderError
from ssdo_gl.window.camera import Controls
from ssdo_gl.window.events import Events
from ssdo_gl.window.film import Interrupted
from ssdo_gl.window.input import InputMap
from ssdo_gl.window.opening import fault_text
from ssdo_gl.window.viewer import Viewer

# The first frame after sleep, and after one that was given up, shows the camera this much
# later, when it will be seen.
# Without it a key would be answered by a picture of where the camera was.
AHEAD_SECONDS = 1.0 / 60.0


class ViewerLoop(ABC):
    """A viewer and its events; somebody else says when to look and where pictures go.

    Parameters
    ----------
    clock : callable
        Returns seconds: when an event is.
    """

    _events: Events

    def __init__(self, viewer: Viewer, clock: Callable[[], float] = time.perf_counter) -> None:
        self._viewer = viewer
        self._input = InputMap(clock)
        self._is_broken = False

    def _perform_pending(self, *, draws: bool) -> None:
        """Do what events have asked for, once there is a picture that it may be about.

        After a frame that was given up there is none; the next one is coarse, and comes
        whatever happens. `draws`: whether a next one comes at all.
        """
        if draws and not self._is_broken and not self._viewer.has_drawing:
            self._viewer.touch()
            return
        self._events.perform(waits=draws)

    def _render(self, controls: Controls, seconds: float, size: tuple[int, int]) -> bool:
        """Let the viewer draw; return whether there is another picture."""
        if self._is_broken:
            return False
        try:
            return self._viewer.frame(controls, seconds, size, self._between_slices)
        except Interrupted:
            return False
        except ShaderError as error:
            # A variant that was never compiled has no last good version.
            self._is_broken = True
            self._show_broken(error)
            return False
        # What a file, a preset or a flight has led to: go back to where it worked.
        except Exception as error:
            if not self._viewer.step_back():
                raise
            text = f"cannot be drawn: {fault_text(error)}"
            self._viewer.say(text, is_fault=True)
            print(f"ssdo-gl: {text}", file=sys.stderr)
            return False

    @abstractmethod
    def _between_slices(self, what: str, done: int, total: int) -> None:
        """Hear of events while a frame is in the making; raise `Interrupted` for a better one."""

    @abstractmethod
    def _show_broken(self, error: ShaderError) -> None:
        """Say why nothing can be drawn any more."""

"""Pictures and scene files of what a window shows."""

from __future__ import annotations

from ssdo_gl.window.saving.picture_job import PictureJob, PictureRequest
from ssdo_gl.window.saving.saved_view import (
    light_elsewhere,
    picture_meta,
    save_scene,
    view_command,
)
from ssdo_gl.window.saving.screenshot import free_stem, save_screenshot

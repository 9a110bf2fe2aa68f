"""Files that are opened in a window, and read again when they change."""

from __future__ import annotations

from ssdo_gl.window.opening.file_dialog import FileDialog
from ssdo_gl.window.opening.hot_reload import FileWatch, ShaderWatch, shader_folder
from ssdo_gl.window.opening.opened import fault_text, open_file, reload_file

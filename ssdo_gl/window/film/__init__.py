"""A recorded camera path rendered to a file."""

from __future__ import annotations

from ssdo_gl.window.film.export import FilmExport, Interrupted

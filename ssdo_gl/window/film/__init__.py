"""A recorded camera path rendered to a file."""

from __future__ import annotations

from ssdo_gl.window.film.export import FilmExport, Interrupted
from ssdo_gl.window.film.writers import FILM_SUFFIXES

__all__ = ["FILM_SUFFIXES", "FilmExport", "Interrupted"]

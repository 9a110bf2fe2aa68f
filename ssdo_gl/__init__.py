"""A deferred renderer with near-field global illumination that knows its own error."""

__version__ = "0.1.0"

"""What a user may choose: declared once, read, checked and written here."""

from ssdo_gl.settings.settings import AOVS, ESTIMATORS, METHODS, Combine, Settings

__all__ = ["AOVS", "ESTIMATORS", "METHODS", "Combine", "Settings"]

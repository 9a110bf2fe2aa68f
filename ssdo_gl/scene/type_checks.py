"""Refuses what is of another type than is needed."""

from __future__ import annotations

from ssdo_gl.scene.scene import SceneError
from ssdo_gl.wording import with_article


def check_type(
    where: str, item: object, types: type | tuple[type, ...], wanted: str | None = None
) -> None:
    """Raise SceneError unless `item` is of `types`; `wanted` is how messages call these."""
    if not isinstance(item, types):
        name = wanted or types.__name__  # type: ignore[union-attr]
        raise SceneError(f"{where}: expected {with_article(name)}, got {a_type(item)}")


def a_type(item: object) -> str:
    """Return the name of the type of `item` with its article."""
    return with_article(type(item).__name__)

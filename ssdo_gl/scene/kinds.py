"""Refuses what is of another kind than is needed."""

from __future__ import annotations

from ssdo_gl.scene.scene import SceneError
from ssdo_gl.short_repr import with_article


def check_kind(
    where: str, item: object, kinds: type | tuple[type, ...], wanted: str | None = None
) -> None:
    """Raise SceneError unless `item` is of `kinds`; `wanted` is how messages call them."""
    if not isinstance(item, kinds):
        name = wanted or kinds.__name__  # type: ignore[union-attr]
        raise SceneError(f"{where}: expected {with_article(name)}, got {a_kind(item)}")


def a_kind(item: object) -> str:
    """Return the name of the kind of `item` with its article."""
    return with_article(type(item).__name__)

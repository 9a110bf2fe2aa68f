"""A scene that cannot be used; what is of another type than is needed makes one."""

from __future__ import annotations

from ssdo_gl.user_error import UserError
from ssdo_gl.wording import with_article


class SceneError(UserError, ValueError):
    """A scene that cannot be used: one line naming the file, the key and the cure."""


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

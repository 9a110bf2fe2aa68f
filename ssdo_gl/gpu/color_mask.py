"""Keeps draws from attachments that their shaders do not write."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl


@contextmanager
def last_kept(target: moderngl.Framebuffer) -> Iterator[None]:
    """Leave the last of several attachments as it is while inside."""
    masks = target.color_mask
    assert isinstance(masks[0], tuple), "a single attachment is what the draw is for"
    target.color_mask = (*masks[:-1], (False,) * 4)
    try:
        yield
    finally:
        target.color_mask = masks

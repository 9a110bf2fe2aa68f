"""Textures that nobody borrows are freed, also by who was interrupted at it."""

from __future__ import annotations

import moderngl
import pytest

from ssdo_gl.gpu.texture_pool import TexturePool


def test_a_trim_that_is_interrupted_can_be_repeated(gl: moderngl.Context, monkeypatch) -> None:
    """Ctrl-C there was a KeyError of the release that followed."""
    pool = TexturePool(gl)
    for texture in [pool.borrow((4, 4), 1, "f4") for _ in range(3)]:
        pool.give_back(texture)

    def interrupted(_texture: moderngl.Texture) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as once:
        once.setattr(moderngl.Texture, "release", interrupted)
        with pytest.raises(KeyboardInterrupt):
            pool.trim()
    pool.trim()
    assert pool.texture_count == 0

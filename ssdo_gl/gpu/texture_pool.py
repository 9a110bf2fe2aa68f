"""Lends textures and framebuffers, and takes them back for the next borrower."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from ssdo_gl.gpu.texture import FrameSizeError, make_framebuffer, make_texture

# Size, channels and dtype of a texture.
Format = tuple[tuple[int, int], int, str]


class TexturePool:
    """Textures of equal size and format stand in for each other.

    The last one given back is lent first, so that a sequence of borrowings that is
    repeated every frame meets the same textures, and the same framebuffers.
    """

    def __init__(self, gl: moderngl.Context) -> None:
        self._gl = gl
        self._free: dict[Format, list[moderngl.Texture]] = {}
        self._all: dict[int, moderngl.Texture] = {}
        self._targets: dict[tuple[tuple[int, ...], bool], moderngl.Framebuffer] = {}

    @property
    def texture_count(self) -> int:
        """Number of textures that exist, lent or not."""
        return len(self._all)

    def borrow(self, size: tuple[int, int], components: int, dtype: str) -> moderngl.Texture:
        """Return a texture with arbitrary content."""
        free = self._free.get((size, components, dtype))
        if free:
            return free.pop()
        texture = make_texture(self._gl, size, components, dtype)
        self._all[texture.glo] = texture
        return texture

    def give_back(self, texture: moderngl.Texture) -> None:
        """Let others have `texture`, which `borrow` returned."""
        key = (texture.size, texture.components, texture.dtype)
        self._free.setdefault(key, []).append(texture)

    def target(
        self, textures: Sequence[moderngl.Texture], *, depth: bool
    ) -> moderngl.Framebuffer | None:
        """Return a framebuffer over `textures`, None if there are none.

        Raises
        ------
        FrameSizeError
            If OpenGL could not make the textures: it says so only where they are drawn into.
        """
        if not textures:
            return None
        key = (tuple(texture.glo for texture in textures), depth)
        if key not in self._targets:
            try:
                self._targets[key] = make_framebuffer(self._gl, list(textures), depth)
            except (moderngl.Error, FrameSizeError):
                width, height = textures[0].size
                renderer = self._gl.info["GL_RENDERER"]
                raise FrameSizeError(
                    f"size = {width}x{height}: {renderer} makes no images so large"
                ) from None
        return self._targets[key]

    def trim(self) -> None:
        """Free every texture that is not lent, and the framebuffers over it."""
        gone = {texture.glo for free in self._free.values() for texture in free}
        for key in [key for key in self._targets if gone.intersection(key[0])]:
            target = self._targets.pop(key)
            depth = target.depth_attachment
            target.release()
            if depth is not None:
                depth.release()
        # One by one: whoever is interrupted in between trims again when everything is released.
        for free in self._free.values():
            while free:
                texture = free.pop()
                self._all.pop(texture.glo, None)
                texture.release()
        self._free.clear()

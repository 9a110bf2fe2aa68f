"""What a pass writes: the description of a texture, without OpenGL."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

# moderngl's names: f4 = 32-bit float, f2 = 16-bit float, nu1/nu2 = 8/16-bit unorm,
# u4, i4 = 32-bit integers (own textures only).
Dtype = Literal["f4", "f2", "nu1", "nu2", "u4", "i4"]


@dataclass(frozen=True)
class TextureSpec:
    """A two-dimensional texture that a pass writes.

    Attributes
    ----------
    components : int
        Channels, 1 to 4.
    scale : float
        Size relative to the frame, rounded up; 1 or 0.5.
    own : bool
        The pass makes the texture itself and returns it from ``execute``, because
        its size does not follow the frame's (shadow atlas, light table, environment).
    """

    components: int
    dtype: Dtype = "f4"
    scale: float = 1.0
    own: bool = False
    transient: bool = False

    def size(self, frame_size: tuple[int, int]) -> tuple[int, int]:
        """Return (width, height) in pixels for a frame of `frame_size`."""
        width, height = (max(1, -int(-n * self.scale // 1)) for n in frame_size)
        return width, height

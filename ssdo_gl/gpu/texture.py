"""Textures and framebuffers with the project's fixed sampling state, and reading them back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ssdo_gl.user_error import UserError

# How each dtype of a texture is laid out in memory, and what a stored integer is
# divided by to become the value that a shader reads.
_STORAGE: dict[str, tuple[type[np.generic], float]] = {
    "f4": (np.float32, 1.0),
    "f2": (np.float16, 1.0),
    "nu1": (np.uint8, 255.0),
    "nu2": (np.uint16, 65535.0),
    "u4": (np.uint32, 1.0),
    "i4": (np.int32, 1.0),
}


# moderngl names no sRGB format but takes the number of one. The hardware then decodes before it
# filters, which decoding in the shader could not.
_GL_SRGB8_ALPHA8 = 0x8C43


class FrameSizeError(UserError, ValueError):
    """A size of frames that OpenGL here makes no images of."""


def make_texture(
    gl: moderngl.Context,
    size: tuple[int, int],
    components: int,
    dtype: str,
    data: ArrayLike | bytes | None = None,
) -> moderngl.Texture:
    """Return a texture that is read texel by texel: NEAREST, clamped to its edge.

    Parameters
    ----------
    size : (int, int)
        Width and height, texels.
    components : int
        Channels, 1 to 4.
    dtype : str
        ``f4``, ``f2`` (floats), ``nu1``, ``nu2`` (8 and 16 bit, [0, 1]), ``u4``, ``i4``.
    data : array_like of (height, width, components) values, bytes, or None
        In OpenGL's order: **row 0 at the bottom**. Values are what a shader reads, so
        those of ``nu1`` and ``nu2`` lie in [0, 1]. None: the contents are undefined.
    """
    if data is not None and not isinstance(data, bytes):
        data = pack(data, (size[1], size[0], components), dtype)
    texture = gl.texture(size, components, data, alignment=1, dtype=dtype)
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    texture.repeat_x = False
    texture.repeat_y = False
    return texture


def image_texture(gl: moderngl.Context, pixels: NDArray[Any], *, is_data: bool) -> moderngl.Texture:
    """Return an image of a material, (height, width, 4), as a texture; row 0 is at v = 0.

    Of 8 bits it is sRGB, unless it is data; else float32.
    """
    is_short = pixels.dtype == np.uint8
    more = {"internal_format": _GL_SRGB8_ALPHA8} if is_short and not is_data else {}
    data, dtype = np.ascontiguousarray(pixels).tobytes(), "f1" if is_short else "f4"
    return gl.texture((pixels.shape[1], pixels.shape[0]), 4, data, dtype=dtype, **more)


def make_framebuffer(
    gl: moderngl.Context, textures: Sequence[moderngl.Texture], depth: bool = False
) -> moderngl.Framebuffer:
    """Return a framebuffer that draws into `textures`, in order of output location.

    `depth` adds a 24-bit depth attachment; it serves the depth test only, positions
    are never rebuilt from it.

    Raises
    ------
    FrameSizeError
        If there was no memory for `textures`: OpenGL says so only where they are drawn into.
    """
    attachment = gl.depth_renderbuffer(textures[0].size) if depth else None
    # moderngl binds what was bound before once it has made a framebuffer, and binding
    # one that was released meanwhile is an error.
    if gl.fbo is not None and isinstance(gl.fbo.mglo, moderngl.InvalidObject):
        gl.detect_framebuffer(0).use()
    try:
        return gl.framebuffer(list(textures), attachment)
    except moderngl.Error:
        if gl.error != "GL_OUT_OF_MEMORY":
            raise
        width, height = textures[0].size
        renderer = gl.info["GL_RENDERER"]
        raise FrameSizeError(
            f"not enough memory: {renderer} makes no more images of {width}x{height}"
        ) from None


@contextmanager
def bound(gl: moderngl.Context, target: moderngl.Framebuffer) -> Iterator[moderngl.Framebuffer]:
    """Bind `target` for a while; afterwards what was bound before is bound."""
    before = gl.fbo
    target.use()
    try:
        yield target
    finally:
        # A framebuffer that is released while bound makes the next one an OpenGL error.
        if before is not None and not isinstance(before.mglo, moderngl.InvalidObject):
            before.use()


@contextmanager
def drawing_into(
    gl: moderngl.Context, *textures: moderngl.Texture, depth: bool = False
) -> Iterator[moderngl.Framebuffer]:
    """Lend a framebuffer of `make_framebuffer`; afterwards what was bound before is bound."""
    target = make_framebuffer(gl, textures, depth)
    try:
        with bound(gl, target):
            yield target
    finally:
        if target.depth_attachment is not None:
            target.depth_attachment.release()
        target.release()


def pack(values: ArrayLike, shape: tuple[int, int, int], dtype: str) -> bytes:
    """Return `values`, as a shader reads them, in the memory layout of `dtype`."""
    storage, unit = _STORAGE[dtype]
    array = np.asarray(values)
    if unit != 1.0:
        array = np.rint(np.clip(array.astype(np.float64), 0.0, 1.0) * unit)
    return np.ascontiguousarray(array.reshape(shape), dtype=storage).tobytes()


def unpack(data: bytes, shape: tuple[int, int, int], dtype: str) -> NDArray[np.generic]:
    """Return what a shader would read from `data`; float32 unless `dtype` is an integer."""
    storage, unit = _STORAGE[dtype]
    array = np.frombuffer(data, dtype=storage).reshape(shape)
    if dtype in ("u4", "i4"):
        return array
    return array.astype(np.float32) if unit == 1.0 else (array / unit).astype(np.float32)


def read_texture(texture: moderngl.Texture) -> NDArray[np.float32]:
    """Return the texture as float32, shape (height, width, channels), row 0 at the top.

    Nothing else flips rows. Normalised integers come back in [0, 1]. Waits until it is drawn.
    """
    shape = (texture.height, texture.width, texture.components)
    rows = unpack(texture.read(alignment=1), shape, texture.dtype)
    return np.ascontiguousarray(rows[::-1], dtype=np.float32)

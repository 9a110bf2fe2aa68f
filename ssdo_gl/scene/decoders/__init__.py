"""Compressed meshes and textures, decoded by libraries of the extra `compression`.

They are native code fed with other people's files, so they run in a process of their own
whose memory and time are limited: whatever happens there, here it is one line.
"""

from __future__ import annotations

from ssdo_gl.scene.decoders.client import (
    DecoderError,
    MissingDecoderError,
    decoded_basis,
    decoded_draco,
    decoded_meshopt,
    release,
)

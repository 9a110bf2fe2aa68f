"""Renders the room by every method through one backend, in a process of its own.

Two backends in one process would disturb each other: Mesa keeps one current context for
each of its libraries.
"""

from __future__ import annotations

import sys

import numpy as np
from hard_cases.hard_scene import room
from hard_cases.methods import METHODS, label, render

from ssdo_gl.gpu.context import create_context
from ssdo_gl.gpu.shader import ShaderLibrary


def draw(device, shaders):
    """Return the images as ``METHOD/NAME``, and the driver's name."""
    arrays = {"renderer": np.array(device.renderer)}
    for method in METHODS:
        images = render(device, shaders, room(), method, size=(32, 24), spp=2, shadow_rays=2)
        arrays |= {f"{label(method)}/{name}": image for name, image in images.items()}
    return arrays


def main(backend, path):
    """Draw through `backend` and write the images into an .npz at `path`."""
    device = create_context(backend)
    np.savez(path, **draw(device, ShaderLibrary(device.gl)))
    device.release()


if __name__ == "__main__":
    main(*sys.argv[1:])

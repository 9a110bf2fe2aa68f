"""How far the picture of `gi` steps where the camera stops: ``python -m benchmarks.stop_steps``.

A view rests, the camera walks sideways for ten frames, by .002 of its distance to its target in
each, and stops. Printed are the largest change of the picture's mean from one frame to the next,
and the largest RMS change, over the mean, from the last frame in motion to the first one that
stands for itself; and the same within the walk.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import answering, check_scenes, command, size_of
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.settings import Settings

SCENES = ("courtyard", "cornell_meso", "stairs", "corner", "coloured_lights")
WALK, STEP = 10, 0.002
# Offsets over which a window averages a view at rest.
OFFSETS = 16

Images = list[NDArray[np.float32]]


def aside(camera: Camera, steps: int) -> Camera:
    """Return the camera so many steps to the right."""
    eye, target = np.array(camera.position), np.array(camera.target)
    right = np.cross(target - eye, camera.up)
    move = steps * STEP * np.linalg.norm(target - eye) * right / np.linalg.norm(right)
    place: dict[str, Any] = {"position": tuple(eye + move), "target": tuple(target + move)}
    return dataclasses.replace(camera, **place)


def frames(device: Device, name: str, size: tuple[int, int]) -> tuple[Images, Images]:
    """Return the frames of a walk, and from its last one on to the first that is settled."""
    scene = load_scene(name)
    settings = Settings("gi", size=size, exposure=0.0)
    with Renderer(scene, settings, device=device) as renderer:

        def shown(steps: int) -> tuple[NDArray[np.float32], bool]:
            camera = aside(scene.camera, steps)
            drawn = renderer.draw(["display", "beauty"], camera=camera, count=OFFSETS)
            # What is brighter than the screen is no step that anybody sees.
            return np.minimum(drawn.planes["beauty"].read()[..., :3], 1.0), drawn.is_settled

        def until_settled(steps: int) -> Iterator[NDArray[np.float32]]:
            is_settled = False
            while not is_settled:
                image, is_settled = shown(steps)
                yield image

        list(until_settled(0))
        walk = [shown(steps)[0] for steps in range(1, WALK + 1)]
        return walk, [walk[-1], *until_settled(WALK)]


def largest_steps(images: Images) -> tuple[float, float]:
    """Return the largest change of the mean, and RMS change, from image to image, over the mean."""
    stack = np.stack(images).astype(np.float64)
    mean = float(stack[-1].mean())
    of_mean = np.abs(np.diff(stack.mean(axis=(1, 2, 3)))).max() / mean
    rms = np.sqrt((np.diff(stack, axis=0) ** 2).mean(axis=(1, 2, 3))).max() / mean
    return float(of_mean), float(rms)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("stop_steps", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--size", type=size_of, default=(160, 90), metavar="WxH")
    chosen = parser.parse_args(argv)
    names = chosen.scenes or SCENES
    check_scenes(names)
    device = create_context("auto")
    try:
        print("| scene | change of the mean | RMS | within the walk | RMS |")
        print("|---|--:|--:|--:|--:|")
        for name in names:
            walk, stop = frames(device, name, chosen.size)
            cells = (f"{number:.2%}" for part in (stop, walk) for number in largest_steps(part))
            print(f"| {name} | {' | '.join(cells)} |", flush=True)
    finally:
        device.release()
    return 0


if __name__ == "__main__":
    sys.exit(main())

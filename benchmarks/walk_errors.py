"""The temporal error of `gi` and `bounce` against all light, along a walk and in an animation.

``make bench-walk`` runs ``python -m benchmarks.walk_errors``. The camera walks for ten seconds
of 30 frames, a fifth of the way to its target and back, and looks to either side by 15
degrees meanwhile; a scene that moves stands before a camera at rest. Five stretches of seven frames
are drawn as a window draws them, after ten frames that are not judged, and compared with
`reference-gi` of the same views. What is printed, over the mean radiance:

- *temporal error*: mean absolute change of the error from frame to frame. The paths' own, known
  from two independent references, is subtracted in squares;
- *RMS*: the root of the mean product of the changes of its errors against either reference, in
  which their noise is no part;
- *error*: RMSE, without the paths' noise in the same way.

References take most of the time; with ``--keep FOLDER`` they are drawn once.
"""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import answering, check_scenes, command, positive
from benchmarks.motion_errors import rendered, shifted
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.images.error import root
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

Images = NDArray[np.float32]
SCENES = ("cornell_meso", "courtyard", "stairs", "carousel")
METHODS = ("bounce", "gi")
FRAMES, FRAMES_PER_SECOND = 300, 30.0
STRETCHES, STRETCH, LEAD = 5, 7, 10
DEGREES, AHEAD = 15.0, 0.2


@dataclass(frozen=True)
class Extent:
    """How much is drawn."""

    size: tuple[int, int]
    spp: int
    stretches: int = STRETCHES

    def frames(self) -> list[range]:
        """Return the numbers of the frames that are judged, stretch by stretch."""
        starts = (FRAMES * (2 * k + 1) // (2 * self.stretches) for k in range(self.stretches))
        return [range(start, start + STRETCH) for start in starts]


def turned(camera: Camera, degrees: float) -> Camera:
    """Return the camera, looking to the side from where it is."""
    back = dataclasses.replace(camera, position=camera.target, target=camera.position)
    back = back.orbit(degrees)
    return dataclasses.replace(camera, target=back.position)


def place(scene: Scene, number: int) -> tuple[Camera, float]:
    """Return the camera of a frame, and its time of an animation."""
    if scene.moves:
        return scene.camera, number / FRAMES_PER_SECOND
    angle = 2.0 * np.pi * number / FRAMES
    ahead = shifted(scene.camera, 0.0, 0.5 * AHEAD * (1.0 - float(np.cos(angle))), 1)
    return turned(ahead, DEGREES * float(np.sin(angle))), 0.0


def references(device: Device, scene: Scene, extent: Extent, seed: int) -> Images:
    """Return pictures (stretches, frames, height, width, 3) by paths.

    The same random numbers in every frame: what changes from one to the next is less noisy.
    """
    settings = Settings("reference-gi", size=extent.size, spp=extent.spp, seed=seed, exposure=0.0)
    numbers = (number for stretch in extent.frames() for number in stretch)
    views = ((scene, *place(scene, number)) for number in numbers)
    images = rendered(device, scene, settings, views)["beauty"]
    return images.reshape(extent.stretches, STRETCH, *extent.size[::-1], 3)


def live(device: Device, scene: Scene, settings: Settings, extent: Extent) -> Images:
    """Return the pictures of a window, as `references` does."""
    images = []
    for stretch in extent.frames():
        with Renderer(scene, settings, device=device) as renderer:
            for number in range(stretch[0] - LEAD, stretch[-1] + 1):
                camera, seconds = place(scene, number)
                drawn = renderer.draw(["display", "beauty"], camera=camera, seconds=seconds)
                if number in stretch:
                    images.append(drawn.planes["beauty"].read()[..., :3])
    return np.stack(images).reshape(extent.stretches, STRETCH, *extent.size[::-1], 3)


@dataclass(frozen=True)
class Errors:
    """What is printed of a method."""

    temporal: float
    rms: float
    error: float

    def __str__(self) -> str:
        return f"{self.temporal:.4f} | {self.rms:.4f} | {self.error:.4f}"


def errors(found: Images, first: Images, second: Images) -> Errors:
    """Return the errors of pictures (stretches, frames, height, width, 3), against two others."""
    a, b, noise = (x.astype(np.float64) for x in (found - first, found - second, first - second))
    mean = float(0.5 * (first.mean() + second.mean()))
    a_step, b_step, noise_step = (np.diff(x, axis=1) for x in (a, b, noise))
    own = 0.5 * np.abs(noise_step).mean()
    return Errors(
        root(np.abs(0.5 * (a_step + b_step)).mean() ** 2 - own**2) / mean,
        root((a_step * b_step).mean()) / mean,
        root((a * b).mean()) / mean,
    )


def rows(
    device: Device, name: str, variants: Sequence[Settings], extent: Extent, keep: Path | None
) -> Iterator[str]:
    """Yield the rows of a scene's table."""
    scene = load_scene(name)
    pair = []
    for seed in (1, 2):
        width, height = extent.size
        label = f"{name}-{width}x{height}-{extent.spp}-{extent.stretches}-{seed}.npy"
        file = None if keep is None else keep / label
        if file is not None and file.exists():
            pair.append(np.load(file))
            continue
        pair.append(references(device, scene, extent, seed))
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
            np.save(file, pair[-1])
    for settings in variants:
        found = live(device, scene, settings, extent)
        yield f"| {name} | {settings.method} | {errors(found, *pair)} |"


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("walk_errors", __doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS)
    parser.add_argument("--size", type=int, nargs=2, default=(160, 90), metavar=("W", "H"))
    parser.add_argument("--spp", type=positive, default=96, help="paths of either reference")
    parser.add_argument("--stretches", type=positive, default=STRETCHES)
    parser.add_argument("--shadows", choices=("map", "traced"), help="instead of the method's own")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where references are kept")
    options = parser.parse_args(argv)
    check_scenes(options.scenes)
    extent = Extent(Settings(size=tuple(options.size)).size, options.spp, options.stretches)
    device = create_context()
    variants = [
        Settings(method, size=extent.size, exposure=0.0, shadows=options.shadows)
        for method in options.methods
    ]
    print("| motion | method | temporal error | RMS | error |")
    print("|---|---|--:|--:|--:|")
    for name in options.scenes or SCENES:
        for row in rows(device, name, variants, extent, options.keep):
            print(row, flush=True)
    device.release()
    return 0


if __name__ == "__main__":
    sys.exit(main())

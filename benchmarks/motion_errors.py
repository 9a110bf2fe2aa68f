"""What averaging over frames brings in motion: errors against each frame's own reference.

``make bench-motion`` runs ``python -m benchmarks.motion_errors``. Each case is drawn as a window
draws it, frame after frame, with and without averaging and with two numbers of samples, and each
frame is compared with the near field by rays. What is printed, over the mean of the reference:

- *error*: RMSE;
- *temporal error*: mean change of the error from frame to frame;
- *change*: mean change of the image from frame to frame, and that of the reference;
- *lag*: by how many frames the image follows the reference, by least squares over blocks of 8 x 8
  pixels, while the camera stands still;
- after a lamp went out, what is left of its light, in the first frame, the fifth and the eighth.

Time is processor time of whole frames as a multiple of single frames with 64 samples.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.common import answering, command
from ssdo_gl.gpu.context import Device, create_context
from ssdo_gl.gpu.texture import read_texture
from ssdo_gl.renderer import Renderer
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings

Images = NDArray[np.float64]
IMAGES = ("bounce", "directional")
SAMPLES = (64, 16)
# The frames until averages are as long as they get are not judged.
LEAD = 10
BLOCK = 8
# After a lamp went out.
GHOST_FRAMES = 8


@dataclass(frozen=True)
class Extent:
    """How much is measured."""

    cases: Sequence[str]
    size: tuple[int, int] = (96, 54)
    frames: int = 60
    spp: int = 128


@dataclass(frozen=True)
class Case:
    """A motion: the scene at frame `i`, its camera and its time.

    Attributes
    ----------
    at : callable
        Returns the scene, the camera and the time of an animation.
    is_still : bool
        The camera stands still, so that the lag can be told.
    """

    scene: str
    at: Callable[[Scene, int, int], tuple[Scene, Camera, float]]
    is_still: bool = False


def shifted(camera: Camera, right_px: float, ahead: float, height: int) -> Camera:
    """Return the camera, moved by pixels at its target, and by a part of the way there."""
    to_target = np.subtract(camera.target, camera.position)
    right = np.cross(to_target, camera.up)
    footprint = 2.0 * np.tan(np.radians(camera.fov_y) / 2.0) * np.linalg.norm(to_target) / height
    step = right_px * footprint * right / np.linalg.norm(right) + ahead * to_target
    position, target = (tuple(np.add(p, step)) for p in (camera.position, camera.target))
    return dataclasses.replace(camera, position=position, target=target)


def pan(pixels: float) -> Callable[[Scene, int, int], tuple[Scene, Camera, float]]:
    """Return a motion to the right, so many pixels a frame."""
    return lambda scene, i, height: (scene, shifted(scene.camera, pixels * i, 0.0, height), 0.0)


def with_moving_lamp(scene: Scene, i: int, height: int) -> tuple[Scene, Camera, float]:
    """Return the scene, its lamps moved to the right by a hundredth of the scene a frame."""
    low, high = scene.bounds()
    step = 0.01 * i * float(np.max(np.subtract(high, low))) * np.array([1.0, 0.0, 0.0])
    matrix = np.eye(4)
    matrix[:3, 3] = step
    lights = tuple(light.moved(matrix) for light in scene.lights)
    return dataclasses.replace(scene, lights=lights), scene.camera, 0.0


@cache
def with_resting_lamps(scene: Scene) -> Scene:
    """Return an animated scene of which only bodies move."""
    lights = tuple(dataclasses.replace(light, motion=None) for light in scene.lights)
    return dataclasses.replace(scene, lights=lights)


CASES: Mapping[str, Case] = {
    "pan, 1/8 px": Case("cornell_meso", pan(0.125)),
    "pan, 2 px": Case("stairs", pan(2.0)),
    "dolly": Case(
        "courtyard", lambda s, i, height: (s, shifted(s.camera, 0.0, 0.005 * i, height), 0.0)
    ),
    "disocclusion": Case("courtyard", lambda s, i, _: (s, s.camera.orbit(0.5 * i), 0.0)),
    "moving lamp": Case("coloured_lights", with_moving_lamp, is_still=True),
    "carousel": Case("carousel", lambda s, i, _: (s, s.camera, i / 30.0), is_still=True),
    "carousel, lamps at rest": Case(
        "carousel", lambda s, i, _: (with_resting_lamps(s), s.camera, i / 30.0), is_still=True
    ),
}


@dataclass(frozen=True)
class Ghost:
    """A lamp that goes out: whose light of which image is looked at."""

    scene: str
    method: str
    image: str
    pan: float = 0.0


GHOSTS = (
    Ghost("cornell_meso", "bounce", "bounce", 0.125),
    Ghost("cornell_meso", "gi", "beauty"),
    Ghost("stairs", "gi", "beauty"),
)
QUICK = Extent(("pan, 1/8 px",), (64, 48), 14, 32)


def rendered(
    device: Device,
    scene: Scene,
    settings: Settings,
    views: Iterable[tuple[Scene, Camera, float]],
    names: Sequence[str] = ("beauty",),
) -> dict[str, NDArray[np.float32]]:
    """Return pictures (frames, height, width, 3): scene, camera and seconds are of each view."""
    frames: dict[str, list[NDArray[np.float32]]] = {name: [] for name in names}
    with Renderer(scene, settings, device=device) as renderer:
        for moved, camera, seconds in views:
            renderer.use_scene(moved)
            images = renderer.render(names, camera=camera, seconds=seconds).images
            for name in names:
                frames[name].append(images[name][..., :3])
    return {name: np.stack(images) for name, images in frames.items()}


def reference(device: Device, case: Case, extent: Extent) -> dict[str, Images]:
    """Return the frames by rays."""
    scene = load_scene(case.scene)
    settings = Settings(size=extent.size, method="reference-near", spp=extent.spp)
    views = (case.at(scene, i, extent.size[1]) for i in range(extent.frames))
    found = rendered(device, scene, settings, views, IMAGES)
    return {name: images.astype(np.float64) for name, images in found.items()}


def live(
    device: Device,
    case: Case,
    extent: Extent,
    samples: int,
    temporal: str,
    method: str = "bounce",
    names: Sequence[str] = IMAGES,
) -> tuple[dict[str, Images], float]:
    """Return the frames of a window, row 0 at the top, and the seconds that one takes."""
    scene = load_scene(case.scene)
    settings = Settings(method=method, size=extent.size, samples=samples, temporal=temporal)
    frames: dict[str, list[Images]] = {name: [] for name in names}
    spent = []
    with Renderer(scene, settings, device=device) as renderer:
        for i in range(extent.frames):
            moved, camera, seconds = case.at(scene, i, extent.size[1])
            renderer.use_scene(moved)
            start = time.process_time()
            planes = renderer.draw(["display", *names], camera=camera, seconds=seconds).planes
            spent.append(time.process_time() - start)
            for name in names:
                texture = planes[name].texture
                shape = (*extent.size[::-1], 3)
                image = np.zeros(shape) if texture is None else read_texture(texture)[..., :3]
                frames[name].append(image.astype(np.float64))
    stacked = {name: np.stack(images) for name, images in frames.items()}
    return stacked, float(np.median(spent[LEAD:]))


def blocks(images: Images) -> Images:
    """Return the means over blocks of pixels."""
    count, height, width, channels = images.shape
    rows, columns = height // BLOCK, width // BLOCK
    cut = images[:, : rows * BLOCK, : columns * BLOCK]
    return np.asarray(cut.reshape(count, rows, BLOCK, columns, BLOCK, channels).mean((2, 4)))


def lag(found: Images, true: Images) -> float:
    """Return by how many frames `found` follows."""
    found, true = blocks(found), blocks(true)
    step = true[:-1] - true[1:]
    # What a method always gets wrong is no lag.
    error = found[1:] - true[1:]
    error = error - error.mean(0)
    return float(np.sum(error * (step - step.mean(0))) / np.sum((step - step.mean(0)) ** 2))


def rows_of(device: Device, name: str, extent: Extent) -> Iterator[str]:
    """Yield the rows of the table of one case."""
    case = CASES[name]
    true, unit = reference(device, case, extent), 0.0
    for samples in SAMPLES:
        for temporal in ("off", "on"):
            found, seconds = live(device, case, extent, samples, temporal)
            unit = unit or seconds
            for image in IMAGES:
                x, t = found[image][LEAD:], true[image][LEAD:]
                mean = t.mean()
                if mean == 0.0:
                    continue
                error = np.sqrt(np.mean((x - t) ** 2)) / mean
                temporal_error, change, own = (
                    np.abs(np.diff(images, axis=0)).mean() / mean for images in (x - t, x, t)
                )
                behind = f"{lag(x, t):+.1f}" if case.is_still else ""
                yield (
                    f"| {name} | {image} | {samples} | {temporal} | {seconds / unit:.2f} "
                    f"| {error:.3f} | {temporal_error:.4f} | {change:.4f} | {own:.4f} | {behind} |"
                )


def ghosts(device: Device, extent: Extent, ghost: Ghost) -> list[float]:
    """Return what is left of the brightest lamp's light, frame after frame without it."""
    scene = load_scene(ghost.scene)
    brightest = max(range(len(scene.lights)), key=lambda i: scene.lights[i].power)
    dark = scene.with_light(brightest, scene.lights[brightest].with_emitted((0.0, 0.0, 0.0)))

    def frames(before: Scene) -> Images:
        case = Case(
            ghost.scene,
            lambda _, i, height: (
                before if i < LEAD else dark,
                shifted(scene.camera, ghost.pan * i, 0.0, height),
                0.0,
            ),
        )
        short = dataclasses.replace(extent, frames=LEAD + GHOST_FRAMES)
        images = live(device, case, short, SAMPLES[0], "on", ghost.method, (ghost.image,))[0]
        return blocks(images[ghost.image])

    after, never = frames(scene), frames(dark)
    lit = after[LEAD - 1] - never[LEAD - 1]
    # How much of what the lamp brought, so that noise does not count.
    return [
        float(np.sum((x - y) * lit) / np.sum(lit * lit))
        for x, y in zip(after[LEAD:], never[LEAD:], strict=True)
    ]


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Measure and print."""
    parser = command("motion_errors", __doc__)
    parser.add_argument("--quick", action="store_true", help="one short pan: some seconds")
    parser.add_argument("--cases", nargs="+", choices=CASES, default=tuple(CASES))
    options = parser.parse_args(argv)
    extent = QUICK if options.quick else Extent(options.cases)
    device = create_context()
    print("| case | image | samples | averaged | time | error | temporal error", end=" ")
    print("| change | of the reference | lag |")
    print("|---|---|--:|---|--:|--:|--:|--:|--:|--:|")
    for name in extent.cases:
        for row in rows_of(device, name, extent):
            print(row, flush=True)
    print()
    for ghost in GHOSTS[: 1 if options.quick else None]:
        left = ghosts(device, extent, ghost)
        told = ", ".join(f"{left[i]:.1%}" for i in (0, 4, 7))
        print(f"left of a lamp's light in frames 1, 5, 8 ({ghost.scene}, {ghost.method}): {told}")
    width, height = extent.size
    print(f"{width}x{height}, {extent.frames} frames, {extent.spp} rays; {device.renderer}")
    device.release()
    return 0


if __name__ == "__main__":
    sys.exit(main())

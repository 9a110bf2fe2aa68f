"""How far pictures of materials are from path tracing, model by model.

``make bench-fidelity`` draws 24 small scenes of its own: metal and plastic of four
roughnesses in three kinds of light. ``MODELS="a.glb b.glb"`` draws files as they are.

The number is that of model-viewer's render-fidelity tests: 10 log10(sqrt(mean(d^2)) / 35215),
d the squared difference of two pixels in YIQ, weighted as pixelmatch does, over the pixels
that show a surface; 35215 is the largest d. FLIP (Andersson et al. 2020) stands beside it.

    python -m benchmarks.render_fidelity [FILE ...] [--spp N] [--pictures FOLDER] [--methods M ...]
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from rich.console import Console
from rich.table import Table

from benchmarks.common import answering, check_scenes, command, positive
from ssdo_gl.bench.statistics.metrics import flip_ldr, srgb_of
from ssdo_gl.renderer import render
from ssdo_gl.scene.formats.toml import read_description
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene

SIZE = (192, 144)
LARGEST_DIFFERENCE = 35215.0
AIM_DB = -22.0

SCENE = """
[camera]
position = [0, 1.5, 4.2]
target = [0, 0.5, 0]
fov_y = 36
exposure = {exposure}
[render]
radius = 0.8
[materials.floor]
albedo = [0.5, 0.5, 0.5]
[materials.body]
albedo = {albedo}
metallic = {metallic}
roughness = {roughness}
{light}
[[object]]
shape = "quad"
corner = [-4, 0, 4]
edge_u = [8, 0, 0]
edge_v = [0, 0, -8]
material = "floor"
[[object]]
shape = "sphere"
center = [-1, 0.55, 0]
radius = 0.55
material = "body"
[[object]]
shape = "torus"
center = [0.25, 0.2, 0.5]
axis = [0, 1, 0]
radius = 0.4
thickness = 0.2
material = "body"
[[object]]
shape = "box"
min = [0.7, 0, -0.7]
max = [1.6, 0.9, 0.2]
material = "body"
transform = {{ rotate = [0, 20, 0] }}
"""
LIGHTS = {
    "sky": """
[environment]
kind = "gradient"
zenith = [0.35, 0.55, 1.0]
horizon = [0.9, 0.85, 0.8]
ground = [0.2, 0.17, 0.14]
""",
    "sky and lamp": """
[environment]
kind = "gradient"
zenith = [0.2, 0.25, 0.35]
horizon = [0.3, 0.3, 0.3]
ground = [0.1, 0.1, 0.1]
[[light]]
kind = "area"
corner = [-1, 2.6, 0]
edge_u = [2, 0, 0]
edge_v = [0, 0, 1.2]
radiance = [5, 4.5, 4]
""",
    "sky and points": """
[environment]
kind = "constant"
radiance = [0.35, 0.35, 0.4]
[[light]]
kind = "point"
position = [2, 3, 2.5]
intensity = [12, 11, 10]
[[light]]
kind = "directional"
direction = [1, -1.5, -0.7]
irradiance = [0.8, 0.9, 1.0]
angle = 4
""",
}
ROUGHNESSES = (0.0, 0.25, 0.5, 1.0)
KINDS = {"gold": ([1.0, 0.77, 0.34], 1.0), "plastic": ([0.6, 0.1, 0.08], 0.0)}


def own_scenes() -> Iterator[tuple[str, Scene]]:
    """Yield 24 scenes: every kind, roughness and light."""
    for light, text in LIGHTS.items():
        for kind, (albedo, metallic) in KINDS.items():
            for roughness in ROUGHNESSES:
                description = SCENE.format(
                    albedo=albedo, metallic=metallic, roughness=roughness, light=text, exposure=0.0
                )
                name = f"{kind}, roughness {roughness:g}, {light}"
                yield name, read_description(description, "fidelity.toml")


def fidelity_db(a: NDArray[np.float32], b: NDArray[np.float32], mask: NDArray[np.bool_]) -> float:
    """Return the difference of two sRGB images (height, width, 3) in [0, 1], dB.

    -inf where they are the same; over the pixels of `mask`.
    """
    levels = [np.rint(255.0 * image[mask].astype(np.float64)) for image in (a, b)]
    r, g, b_ = np.moveaxis(levels[0] - levels[1], -1, 0)
    y = 0.29889531 * r + 0.58662247 * g + 0.11448223 * b_
    i = 0.59597799 * r - 0.27417610 * g - 0.32180189 * b_
    q = 0.21147017 * r - 0.52261711 * g + 0.31114694 * b_
    d = 0.5053 * y * y + 0.299 * i * i + 0.1957 * q * q
    mean = math.sqrt(float(np.mean(d * d)))
    return 10.0 * math.log10(mean / LARGEST_DIFFERENCE) if mean > 0.0 else -math.inf


@dataclasses.dataclass(frozen=True)
class Fidelity:
    """How far a picture of one scene by one method is from paths."""

    db: float
    flip: float
    mean_error: float

    @property
    def cells(self) -> tuple[str, str, str]:
        """What the table shows of it."""
        return f"{self.db:.1f}", f"{self.flip:.3f}", f"{self.mean_error:+.1%}"


def measure(
    scene: Scene, methods: Sequence[str], spp: int
) -> tuple[list[Fidelity], NDArray[np.float32]]:
    """Draw `scene` by each method and by paths; exposure is the camera's.

    Returns
    -------
    found : list of Fidelity
        One for each method.
    pictures : ndarray, shape (height, width * (methods + 1), 3)
        sRGB, the path tracer's last.
    """

    def drawn(method: str, **options: Any) -> NDArray[np.float32]:
        return np.asarray(render(scene, size=SIZE, method=method, **options), np.float32)

    def shown(image: NDArray[np.float32]) -> NDArray[np.float32]:
        return srgb_of(image[..., :3], scene.camera.exposure or 0.0)

    mask = drawn("direct", aov="depth")[..., 0] > 0.0
    reference = drawn("reference-gi", spp=spp)
    found, pictures = [], []
    for method in methods:
        image = drawn(method)
        pictures.append(shown(image))
        flip = flip_ldr(pictures[-1], shown(reference), mask).mean
        error = float(image[mask][:, :3].mean() / reference[mask][:, :3].mean()) - 1.0
        found.append(Fidelity(fidelity_db(pictures[-1], shown(reference), mask), flip, error))
    return found, np.concatenate([*pictures, shown(reference)], axis=1)


@answering
def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; write pictures side by side, that of paths on the right, where asked to."""
    parser = command("render_fidelity", __doc__)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--spp", type=positive, default=128, help="paths a pixel of the reference")
    parser.add_argument("--methods", nargs="+", default=["bounce", "gi"])
    parser.add_argument("--pictures", type=Path, default=None)
    arguments = parser.parse_args(argv)
    check_scenes(map(str, arguments.files))
    scenes = (
        ((f.name, load_scene(str(f))) for f in arguments.files) if arguments.files else own_scenes()
    )
    columns = [f"{m}: {c}" for m in arguments.methods for c in ("dB", "FLIP", "mean error")]
    table = Table("scene", *columns, title=f"against {arguments.spp} paths")
    missed: dict[str, list[str]] = {method: [] for method in arguments.methods}
    for number, (name, scene) in enumerate(scenes):
        found, pictures = measure(scene, arguments.methods, arguments.spp)
        table.add_row(name, *(cell for one in found for cell in one.cells))
        for method, one in zip(arguments.methods, found, strict=True):
            missed[method] += [name] if one.db > AIM_DB else []
        if arguments.pictures is not None:
            arguments.pictures.mkdir(parents=True, exist_ok=True)
            levels = np.rint(255.0 * np.clip(pictures, 0.0, 1.0)).astype(np.uint8)
            Image.fromarray(levels).save(arguments.pictures / f"{number:02d}.png")
    Console(width=140).print(table)
    for method, names in missed.items():
        count = f"{method}: {len(names)} of {len(table.rows)} above {AIM_DB:g} dB"
        print(": ".join([count, "; ".join(names)] if names else [count]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Draws the pictures of README and docs/ anew: ``make pictures``.

Each tile is what one ``ssdo-gl --snapshot`` command draws; here they are only put side by
side and labelled. ``make_pictures.py bench/cornell_meso`` takes over the plot of a bench.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from ssdo_gl import cli
from ssdo_gl.film.bookmarks import Views, save_views
from ssdo_gl.film.camera_path import CameraPath, key_of
from ssdo_gl.scene.camera import Camera

FOLDER = Path(__file__).parent
TILE = 240
LABEL_HEIGHT = 18
# JPEG loses the noise of few paths below this quality, which is what one is to see.
QUALITY = 88
FRONT_WIDTH = 2000
WALK_FRAMES, WALK_FPS = 60, 15

VIEWS = {
    "the room": "0,0,3.6 0,0,0 32",
    "blue boxes": "0.1,-0.5,1.5 0.74,-0.86,0.2 34",
    "red boxes": "-0.1,-0.45,1.3 -0.62,-0.9,0.3 34",
}
METHODS = {
    "1 path": ["--method", "reference-gi", "--spp", "1"],
    "16 paths": ["--method", "reference-gi", "--spp", "16"],
    "256 paths": ["--method", "reference-gi", "--spp", "256"],
    "near field, 64 rays": ["--method", "reference-near", "--spp", "64"],
    "SSDO and bounce": ["--method", "bounce"],
}


# What each method adds, in one scene and one view; four jittered frames of each.
STRIP = {
    "direct": ["--method", "direct"],
    "SSAO": ["--method", "ssao"],
    "SSDO": ["--method", "ssdo"],
    "SSDO and bounce": ["--method", "bounce"],
    "SSDO, all light": ["--method", "gi"],
    "path traced": ["--method", "reference-gi", "--spp", "256"],
}


def tile(folder: Path, view: str, arguments: list[str]) -> Image.Image:
    """Return the built-in room from `view`, drawn by the command."""
    path = folder / "tile.png"
    size = f"{TILE}x{TILE}"
    # One frame: with several, one path would be several.
    common = ["--snapshot", str(path), "--size", size, "--antialias", "1", "--quiet"]
    code = cli.main(["cornell_meso", "--camera", view, *common, *arguments])
    if code:
        raise SystemExit(code)
    with Image.open(path) as image:
        return image.convert("RGB")


def draw_paths(folder: Path) -> None:
    """Draw path tracing with 1, 16 and 256 paths beside SSDO, the room and two details."""
    width = TILE * len(METHODS)
    sheet = Image.new("RGB", (width, LABEL_HEIGHT + TILE * len(VIEWS)), "white")
    draw = ImageDraw.Draw(sheet)
    font = ImageFont.load_default()
    for column, (label, arguments) in enumerate(METHODS.items()):
        draw.text((column * TILE + 6, 3), label, fill="black", font=font)
        for row, view in enumerate(VIEWS.values()):
            place = (column * TILE, LABEL_HEIGHT + row * TILE)
            sheet.paste(tile(folder, view, arguments), place)
    sheet.save(FOLDER / "paths.jpg", quality=QUALITY)


def draw_strip(folder: Path) -> None:
    """Draw the methods side by side."""
    strip = Image.new("RGB", (TILE * len(STRIP), LABEL_HEIGHT + TILE), "white")
    draw = ImageDraw.Draw(strip)
    font = ImageFont.load_default()
    for column, (label, arguments) in enumerate(STRIP.items()):
        draw.text((column * TILE + 6, 3), label, fill="black", font=font)
        picture = tile(folder, VIEWS["the room"], [*arguments, "--antialias", "4"])
        strip.paste(picture, (column * TILE, LABEL_HEIGHT))
    strip.save(FOLDER / "methods.jpg", quality=QUALITY)


def draw_lead(folder: Path) -> None:
    """Draw the README's first picture."""
    path = folder / "lead.png"
    code = cli.main(["cornell_meso", "--snapshot", str(path), "--size", "960x720", "--quiet"])
    if code:
        raise SystemExit(code)
    with Image.open(path) as image:
        image.convert("RGB").save(FOLDER / "cornell_meso.jpg", quality=QUALITY)


def draw_walk(folder: Path) -> None:
    """Draw a film of a walk that ends where it begins."""
    keys = []
    for number in range(WALK_FRAMES):
        angle = 2.0 * math.pi * number / WALK_FRAMES
        x, y = math.cos(angle), math.sin(angle)
        place, target = (0.3 * x, 0.2 - 0.15 * y, 1.2 - 0.2 * y), (-0.1 - 0.3 * x, -0.3, -0.4)
        camera = Camera(place, target, fov_y=60.0)
        keys.append(key_of(number / WALK_FPS, camera))
    path = folder / "walk.views.json"
    save_views(path, Views(path=CameraPath(tuple(keys))))
    film = ["--film", str(FOLDER / "walk.webp"), "--path", str(path), "--fps", str(WALK_FPS)]
    frames = ["--frames-range", f"0:{WALK_FRAMES}", "--size", "480x270", "--quiet"]
    code = cli.main(["cornell_meso", *film, *frames])
    if code:
        raise SystemExit(code)


def draw_front(bench: Path) -> None:
    """Draw error against time as ``ssdo-gl cornell_meso --bench`` has plotted it in a folder."""
    with Image.open(bench / "pareto.png") as image:
        height = round(image.height * FRONT_WIDTH / image.width)
        front = image.convert("RGB").resize((FRONT_WIDTH, height), Image.Resampling.LANCZOS)
        front.save(FOLDER / "pareto.webp", quality=QUALITY)


def main(benches: Sequence[str]) -> int:
    """Draw all of them; with the folder of a bench, its plot alone."""
    for bench in benches:
        draw_front(Path(bench))
    if benches:
        return 0
    with tempfile.TemporaryDirectory() as name:
        draw_lead(Path(name))
        draw_strip(Path(name))
        draw_paths(Path(name))
        draw_walk(Path(name))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

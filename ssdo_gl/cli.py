"""The command `ssdo-gl`: parses arguments and calls the application. No rendering here."""

from __future__ import annotations

import argparse
import dataclasses
import os
import shlex
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from ssdo_gl import __version__
from ssdo_gl.bench.files import BenchError
from ssdo_gl.bench.metrics import MissingLibraryError
from ssdo_gl.gpu.context import BACKENDS, ContextError
from ssdo_gl.images.files import OutputError, check_output
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.load import load_scene
from ssdo_gl.scene.scene import Scene, SceneError
from ssdo_gl.settings import AOVS, ESTIMATORS, METHODS, Settings
from ssdo_gl.settings.fields import SettingError
from ssdo_gl.settings.resolve import camera_from_text, settings_for, size_from_text

EXIT_OK, EXIT_USER, EXIT_NO_OPENGL, EXIT_INTERRUPTED = 0, 2, 3, 130
DEFAULT_SCENE = "cornell_meso"
# Flags that are fields of Settings under the same name.
SETTING_FLAGS = (
    "method",
    "estimator",
    "samples",
    "steps",
    "spp",
    "bounces",
    "shadow_rays",
    "radius",
    "seed",
    "shadows",
    "combine",
    "filter",
    "effects",
    "exposure",
    "antialias",
    "resolution_scale",
    "max_error",
)


class UsageError(ValueError):
    """Arguments that contradict each other or cannot be read."""


class _Parser(argparse.ArgumentParser):
    """argparse that reports one line instead of a usage block."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see ssdo-gl --help)")


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = _Parser(
        prog="ssdo-gl",
        description="Render a scene with near-field global illumination (SSDO).",
        allow_abbrev=False,
    )
    parser.add_argument(
        "scene",
        nargs="?",
        default=DEFAULT_SCENE,
        metavar="SCENE",
        help="a .toml scene, a model (.glb .gltf .obj .ply .stl .off) or a built-in name "
        f"(default: {DEFAULT_SCENE})",
    )
    _add_modes(parser)
    _add_look(parser)
    _add_quality(parser)
    _add_running(parser)
    return parser


def _add_modes(parser: argparse.ArgumentParser) -> None:
    modes = parser.add_argument_group("what to do (none: fly-through window)")
    modes.add_argument(
        "--snapshot", metavar="OUT", type=Path, help="render to OUT (.png, .exr or .npz), headless"
    )
    modes.add_argument(
        "--explain", action="store_true", help="say which passes run and why, which do not and why"
    )
    modes.add_argument(
        "--bench", metavar="OUTDIR", type=Path, help="measure error against time, into OUTDIR"
    )
    modes.add_argument("--quick", action="store_true", help="a bench of about two minutes")
    modes.add_argument("--version", action="version", version=f"ssdo-gl {__version__}")


def _add_look(parser: argparse.ArgumentParser) -> None:
    look = parser.add_argument_group("what to show")
    look.add_argument("--method", choices=METHODS, help="default: bounce")
    look.add_argument("--size", metavar="WxH", help="pixels; default 1280x720")
    look.add_argument("--camera", metavar='"px,py,pz tx,ty,tz [fov]"', help="fov in degrees")
    look.add_argument("--exposure", type=float, metavar="EV")
    look.add_argument("--aov", metavar="NAME,...", help=f"all, or of {', '.join(AOVS)}")
    look.add_argument("--combine", choices=("ambient", "multiply", "report"))
    look.add_argument("--time", type=float, default=0.0, metavar="S", help="animation time, s")


def _add_quality(parser: argparse.ArgumentParser) -> None:
    names = sorted({name for group in ESTIMATORS.values() for name in group})
    quality = parser.add_argument_group("accuracy against time")
    quality.add_argument("--estimator", choices=names)
    quality.add_argument("--radius", type=float, metavar="R", help="near-field reach, scene units")
    quality.add_argument("--samples", type=int, metavar="N", help="depth reads per pixel")
    quality.add_argument("--steps", type=int, metavar="M", help="of them along each direction")
    quality.add_argument("--spp", type=int, metavar="N", help="rays or paths per pixel")
    quality.add_argument("--bounces", type=int, metavar="B", help="indirect bounces, reference-gi")
    quality.add_argument("--shadow-rays", type=int, metavar="N")
    quality.add_argument("--shadows", choices=("map", "traced", "none"))
    quality.add_argument("--filter", choices=("edge", "naive", "none"))
    quality.add_argument("--resolution-scale", type=float, metavar="0.5|1")
    quality.add_argument("--antialias", type=int, metavar="N", help="default 4 for .png, else 1")
    quality.add_argument("--effects", choices=("auto", "full"))
    quality.add_argument("--seed", type=int)
    quality.add_argument("--preset", metavar="NAME|FILE", help="fast balanced fine reference")
    quality.add_argument(
        "--budget-ms", type=float, metavar="T", help="the most accurate setting that fits a frame"
    )
    quality.add_argument(
        "--max-error",
        type=float,
        metavar="E",
        help="the cheapest setting within this relative error; references stop there",
    )
    quality.add_argument(
        "--set", action="append", default=[], metavar="PASS.FIELD=VALUE", dest="overrides"
    )


def _add_running(parser: argparse.ArgumentParser) -> None:
    running = parser.add_argument_group("running")
    running.add_argument("--frames", type=int, default=1, metavar="K", help="time K frames")
    running.add_argument("--stats", type=Path, metavar="FILE.json")
    running.add_argument("--backend", choices=BACKENDS, default="auto")
    running.add_argument("--quiet", action="store_true")


def _wanted_aovs(text: str | None) -> tuple[str, ...]:
    if text is None:
        return ("beauty",)
    if text == "all":
        return AOVS
    names = tuple(dict.fromkeys(part.strip() for part in text.split(",")))
    unknown = [name for name in names if name not in AOVS]
    if unknown:
        raise UsageError(f"--aov {unknown[0]!r}: choose all or of {', '.join(AOVS)}")
    return names


def _apply_preset(options: argparse.Namespace, flags: dict[str, Any]) -> None:
    """Fill in what the preset sets and no flag does."""
    if options.preset is None:
        return
    from ssdo_gl.bench.presets import load_preset

    fields = load_preset(options.preset, flags["method"])
    overrides = fields.pop("overrides", {})
    options.overrides[:0] = [f"{name}={value}" for name, value in overrides.items()]
    for name, value in fields.items():
        if flags.get(name) is None:
            flags[name] = value


def _tuned(
    options: argparse.Namespace, scene: Scene, settings: Settings, camera: Camera | None
) -> Settings:
    """Return `settings`, or what a budget or an error bound makes of them."""
    wants_error = settings.max_error is not None and not settings.is_reference
    if options.budget_ms is None and not wants_error:
        return settings
    if options.budget_ms is not None and wants_error:
        raise UsageError("--budget-ms and --max-error: give one of them")
    from ssdo_gl.bench.tune import choose_for_budget, choose_for_error

    if options.budget_ms is not None:
        choice = choose_for_budget(
            scene, settings, options.budget_ms, camera=camera, backend=options.backend
        )
    else:
        assert settings.max_error is not None
        choice = choose_for_error(
            scene,
            settings,
            settings.max_error,
            camera=camera,
            backend=options.backend,
            allow_rays=options.snapshot is not None,
        )
    if not choice.holds:
        print(f"ssdo-gl: {choice.sentence}", file=sys.stderr)
    elif not options.quiet:
        print(choice.sentence)
    return choice.settings


def command_text(arguments: Sequence[str] | None) -> str:
    """Return the command line as one types it."""
    return shlex.join(["ssdo-gl", *(sys.argv[1:] if arguments is None else arguments)])


def _check_modes(options: argparse.Namespace) -> None:
    """Refuse flags that contradict each other and outputs that cannot be written."""
    if options.frames < 1:
        raise UsageError(f"--frames {options.frames}: must be at least 1")
    if options.quick and options.bench is None:
        raise UsageError("--quick belongs to --bench OUTDIR")
    if options.bench is not None and (options.snapshot is not None or options.explain):
        raise UsageError("--bench renders what it needs itself; leave out --snapshot and --explain")
    if options.snapshot is not None:
        check_output(options.snapshot)
    if options.stats is not None:
        check_output(options.stats, (".json",))


def _flags(options: argparse.Namespace) -> dict[str, Any]:
    """Return the given settings by name, None where a flag was not given."""
    flags = {name: getattr(options, name) for name in SETTING_FLAGS}
    if options.size is not None:
        flags["size"] = size_from_text(options.size)
    elif options.bench is not None:
        from ssdo_gl.bench.run import bench_size

        flags["size"] = bench_size(options.quick)
    if options.snapshot is not None and flags["antialias"] is None:
        flags["antialias"] = 4 if options.snapshot.suffix.lower() == ".png" else 1
    _apply_preset(options, flags)
    return flags


def run(arguments: Sequence[str] | None = None) -> int:
    """Carry out one command line; raises the user-facing errors."""
    options = build_parser().parse_args(arguments)
    _check_modes(options)
    wanted = _wanted_aovs(options.aov)
    flags = _flags(options)
    view = camera_from_text(options.camera) if options.camera is not None else None
    # Flags are checked before the scene is read, so that a typo costs no waiting.
    settings_for({}, flags, options.overrides)
    scene = load_scene(options.scene)
    settings = settings_for(scene.render, flags, options.overrides)
    camera = None if view is None else dataclasses.replace(scene.camera, **view)
    if options.bench is not None:
        from ssdo_gl.bench.run import run_bench

        run_bench(
            options.scene,
            settings,
            options.bench,
            quick=options.quick,
            scene=scene,
            camera=camera,
            backend=options.backend,
            command=command_text(arguments),
            quiet=options.quiet,
        )
        return EXIT_OK
    settings = _tuned(options, scene, settings, camera)
    if options.snapshot is not None or options.explain:
        return _snapshot(options, scene, settings, camera, wanted)
    from ssdo_gl.bench.presets import NAMES, load_preset, read_ladder
    from ssdo_gl.window.window import open_window

    # The window goes on measuring and gives way where a frame turns out dearer.
    budget = {} if options.budget_ms is None else {"budget_ms": options.budget_ms}
    open_window(
        scene,
        settings,
        camera=camera,
        source=options.scene,
        # As if no method had been chosen: one of the presets is a method.
        presets={name: load_preset(name) for name in NAMES},
        measured=[
            {**dataclasses.asdict(rung), "label": rung.label} for rung in read_ladder().rungs
        ],
        read_preset=load_preset,
        **budget,
    )
    return EXIT_OK


def _snapshot(
    options: argparse.Namespace,
    scene: Scene,
    settings: Settings,
    camera: Camera | None,
    wanted: tuple[str, ...],
) -> int:
    from ssdo_gl.headless.snapshot import SnapshotRequest, take_snapshot

    result = take_snapshot(
        SnapshotRequest(
            scene=scene,
            settings=settings,
            wanted=wanted,
            out=options.snapshot,
            camera=camera,
            frames=options.frames,
            seconds=options.time,
            stats=options.stats,
            backend=options.backend,
            explain=options.explain,
            quiet=options.quiet,
        )
    )
    return EXIT_INTERRUPTED if result.partial else EXIT_OK


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code (0, 2, 3, or 130 after Ctrl-C)."""
    try:
        return run(arguments)
    except (SceneError, SettingError, OutputError, UsageError, BenchError) as error:
        message, code = str(error), EXIT_USER
    except MissingLibraryError as error:
        message, code = str(error), EXIT_USER
    except ContextError as error:
        message, code = str(error), EXIT_NO_OPENGL
    except KeyboardInterrupt as error:
        message, code = str(error) or "interrupted; nothing was written", EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader of our output has left; Python would complain again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    print(f"ssdo-gl: {' '.join(message.split())}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())

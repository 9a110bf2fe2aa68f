"""Carries out a checked command with one scene: a picture, a film, a flight or a bench."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ssdo_gl.headless.reading import read_scene
from ssdo_gl.images.files import is_picture
from ssdo_gl.options.flags import STREAM, CommandLine, UsageError, flag_infos
from ssdo_gl.options.idle import check_used
from ssdo_gl.options.resolve import chosen_camera, for_pictures, settings_for
from ssdo_gl.options.run_options import RunOptions
from ssdo_gl.process import EXIT_INTERRUPTED, EXIT_MISSED, EXIT_OK, notes_at_once
from ssdo_gl.scene.camera import Camera
from ssdo_gl.scene.scene import Scene
from ssdo_gl.settings import Settings, modes
from ssdo_gl.settings.loading import FIT

if TYPE_CHECKING:
    from ssdo_gl.film.shots import Shots
    from ssdo_gl.gpu.warm_device import WarmDevice

_EXPLAINED_SPP = 4  # rays per pixel of a reference that is only explained


def carry_out(
    command: CommandLine,
    given: Mapping[str, Any],
    wanted: tuple[str, ...],
    text: str = "",
    shots: Shots | None = None,
    warm: WarmDevice | None = None,
) -> int:
    """Carry out a command with one scene.

    Parameters
    ----------
    given : mapping
        Fields of Settings, by flag or preset.
    text : str
        The command as one types it, for the report of a bench.
    shots : Shots or None
        The frames of a film.
    warm : WarmDevice or None
        Draws a snapshot.
    """
    options = command.run
    place = None if options.camera in (FIT, command.loading.camera) else options.camera
    scene = read_scene(command.scene, command.loading, quiet=options.quiet)
    settings = _mode_defaults(options, settings_for(scene.render, given), scene)
    if "method" in given or (warm is None and settings.max_error is None):
        # Of several scenes, another one's method may use what this one's cannot; a bound on
        # the error may choose another method.
        check_flags_used(command, settings, wanted, is_scene_read=True)
    camera = chosen_camera(scene, place, options.projection, options.time)
    if options.bench is not None:
        from ssdo_gl.bench.estimators import run_estimators
        from ssdo_gl.bench.run import run_bench

        measure: Callable[..., object] = run_estimators if options.estimators else run_bench
        measure(
            command.scene,
            settings,
            Path(options.bench),
            quick=options.quick,
            scene=scene,
            camera=camera,
            backend=options.backend,
            scheduler=options.scheduler,
            command=text,
            quiet=options.quiet,
        )
        return EXIT_OK
    settings = _tuned(command, scene, settings, camera)
    if options.active & modes.LIVE:
        _fly_through(command, scene, settings, camera, wanted[0])
        return EXIT_OK
    with notes_at_once(quiet=options.quiet):
        if shots is not None:
            return _film(command, scene, settings, camera, wanted, shots)
        return _snapshot(options, scene, settings, camera, wanted, warm)


def check_flags_used(
    command: CommandLine, settings: Settings, wanted: tuple[str, ...], *, is_scene_read: bool
) -> None:
    """Refuse flags without effect on pictures; in a window, method and image may change."""
    if command.run.active & modes.FRAMES:
        check_used(settings, command.settings, wanted, is_scene_read=is_scene_read)


def _mode_defaults(run: RunOptions, settings: Settings, scene: Scene) -> Settings:
    """Return `settings` with defaults that depend on what is made of them."""
    if run.bench is not None and not settings.gives("size"):
        from ssdo_gl.bench.run import bench_size

        return dataclasses.replace(settings, size=bench_size(run.quick))
    only_explains = run.explain and (run.snapshot, settings.max_error) == (None, None)
    if only_explains and not settings.gives("spp"):
        # No picture is kept: which passes run, and their times, take no converged reference.
        return dataclasses.replace(settings, spp=_EXPLAINED_SPP)
    if run.film is not None:
        from ssdo_gl.headless.film_frames import shows_pictures

        makes_picture = shows_pictures(Path(run.film))
    else:
        makes_picture = run.snapshot is not None and is_picture(Path(run.snapshot))
    return for_pictures(settings, scene) if makes_picture else settings


def _tuned(
    command: CommandLine, scene: Scene, settings: Settings, camera: Camera | None
) -> Settings:
    """Return `settings`, or what a budget or an error bound makes of them."""
    run = command.run
    wants_error = settings.max_error is not None and not settings.is_reference
    if run.error_reference is not None and not wants_error:
        raise UsageError("--truth belongs to --max-error E of a method that is no reference")
    if run.budget_ms is None and not wants_error:
        return settings
    if run.budget_ms is not None and wants_error:
        raise UsageError("--budget-ms and --max-error: give one of them")
    from ssdo_gl.bench.presets import FIELDS
    from ssdo_gl.bench.tuning import choose_for_budget, choose_for_error

    for name in FIELDS:
        if name in command.settings:
            flag = flag_infos()[name][1].flag
            raise UsageError(
                f"{flag} has no effect with --budget-ms or --max-error: they choose it"
            )
    if modes.WINDOW in run.active:
        from ssdo_gl.window.glfw_window import check_display

        check_display()
    if run.budget_ms is not None:
        choice = choose_for_budget(
            scene, settings, run.budget_ms, camera=camera, backend=run.backend
        )
    else:
        assert settings.max_error is not None
        choice = choose_for_error(
            scene,
            settings,
            settings.max_error,
            against=run.error_reference,
            camera=camera,
            backend=run.backend,
            allow_rays=run.snapshot is not None,
        )
    if not choice.holds:
        print(f"ssdo-gl: {choice.sentence}", file=sys.stderr)
    elif not run.quiet:
        print(choice.sentence, file=sys.stderr if run.snapshot == STREAM else sys.stdout)
    return choice.settings


def _film(
    command: CommandLine,
    scene: Scene,
    settings: Settings,
    camera: Camera | None,
    wanted: tuple[str, ...],
    shots: Shots,
) -> int:
    from ssdo_gl.headless.film import make_film
    from ssdo_gl.headless.film_frames import FilmRequest

    options = command.run
    assert options.film is not None
    outcome = make_film(
        FilmRequest(
            scene=scene,
            settings=settings,
            out=Path(options.film),
            shots=shots,
            wanted=wanted,
            camera=camera,
            backend=options.backend,
            resume=options.resume,
            scheduler=options.scheduler,
            quiet=options.quiet,
        )
    )
    return EXIT_MISSED if outcome.missed_count else EXIT_OK


def _fly_through(
    command: CommandLine, scene: Scene, settings: Settings, camera: Camera | None, aov: str
) -> None:
    from ssdo_gl.bench.presets import NAMES, load_preset, read_ladder

    options: dict[str, Any] = {
        "camera": camera,
        "source": command.scene,
        "aov": aov,
        "seconds": command.run.time,
        # As if no method had been chosen: one of the presets is a method.
        "presets": {name: load_preset(name) for name in NAMES},
        "measured": [
            {**dataclasses.asdict(rung), "label": rung.label} for rung in read_ladder().rungs
        ],
        "read_preset": load_preset,
    }
    # A viewer goes on measuring and gives way where a frame turns out dearer.
    if command.run.budget_ms is not None:
        options["budget_ms"] = command.run.budget_ms
    if command.run.serve:
        from ssdo_gl.serve.serving import serve_scene

        serve_scene(scene, settings, command.serving, backend=command.run.backend, **options)
    else:
        from ssdo_gl.window.window import open_window

        open_window(scene, settings, **options)


def _snapshot(
    options: RunOptions,
    scene: Scene,
    settings: Settings,
    camera: Camera | None,
    wanted: tuple[str, ...],
    warm: WarmDevice | None,
) -> int:
    from ssdo_gl.headless.snapshot import SnapshotRequest, missed_bounds, take_snapshot

    result = take_snapshot(
        SnapshotRequest(
            scene=scene,
            settings=settings,
            wanted=wanted,
            out=None if options.snapshot is None else Path(options.snapshot),
            camera=camera,
            frames=options.frames,
            seconds=options.time,
            stats=None if options.stats is None else Path(options.stats),
            backend=options.backend,
            explain=options.explain,
            keeps_partial=not options.batch,
            warm=warm,
            quiet=options.quiet,
        )
    )
    if result.partial:
        return EXIT_INTERRUPTED
    return EXIT_MISSED if missed_bounds(result) else EXIT_OK

"""What a command says beyond `Settings`: what to do, with what, and where to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ssdo_gl.gpu.context import BACKENDS
from ssdo_gl.scene.camera import PROJECTIONS
from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import LOOK, QUALITY

MODE, RUNNING = "what to do (none: fly-through window)", "running"
FILM, BROWSER = "films", "in a browser"
FRAMES_PER_SECOND = 30.0

_mode = partial(setting, group=MODE)
_bench = partial(_mode, modes=frozenset({modes.BENCH}))
_look = partial(setting, group=LOOK, modes=modes.ALL)
_quality = partial(setting, group=QUALITY, modes=modes.ONE)
_running = partial(setting, group=RUNNING, modes=modes.ALL)
_film = partial(setting, group=FILM, modes=frozenset({modes.FILM}))
_serve = partial(setting, group=BROWSER, modes=frozenset({modes.SERVE}))


@dataclass(frozen=True)
class RunOptions:
    """What to do, with what, and where to."""

    snapshot: str | None = _mode(
        None,
        "render to OUT (.png, .jpg, .webp, .exr or .npz; - for a PNG on standard output), headless",
        metavar="OUT",
        modes=modes.HEADLESS,
    )
    explain: bool = _mode(
        False, "say which passes run, which do not, and why", modes=modes.HEADLESS
    )
    batch: bool = _mode(
        False,
        "render each SCENE, several names or quoted patterns such as 'models/*.glb', to a picture"
        " of its own, headless",
        modes=frozenset({modes.BATCH}),
    )
    out: str | None = _mode(
        None,
        "the folder of a batch, which is made if need be; or names such as DIR/{name}.exr",
        metavar="DIR",
        modes=frozenset({modes.BATCH}),
    )
    film: str | None = _mode(
        None,
        "render a film to OUT, headless: .mp4, .webm, .webp or .gif, a folder of pictures, or"
        " numbered files such as frame_%04d.exr",
        metavar="OUT",
        modes=frozenset({modes.FILM}),
    )
    serve: bool = _mode(
        False,
        "fly through the scene in a browser, from a machine without a display",
        modes=frozenset({modes.SERVE}),
    )
    bench: str | None = _bench(None, "measure error against time, into OUTDIR", metavar="OUTDIR")
    estimators: bool = _bench(False, "bench every estimator instead")
    quick: bool = _bench(False, "a bench of two minutes; of half a million triangles of five")
    camera: str | None = _look(
        None,
        "where to look from and at (scene units), and the vertical field of view (degrees) or,"
        " of parallel rays, the height of what is seen (scene units); fit: frame the whole"
        " scene, whatever camera the file has; NAME: that camera of a model file, or its number"
        " from 0 on",
        metavar='fit|NAME|"px,py,pz tx,ty,tz [fov]"',
    )
    projection: str | None = _look(
        None,
        "rays through one point, or parallel ones (ortho is short); by default the scene's",
        choices=PROJECTIONS,
    )
    aov: str | None = _look(
        None,
        "images to make, or all; a window or a page begins with the one named",
        metavar="NAME,...",
        modes=modes.ONE,
    )
    time: float = _look(
        0.0,
        "time of an animated scene; a window or a page begins there",
        unit="s",
        low=-1e9,
        high=1e9,
        metavar="S",
        modes=modes.ONE,
    )
    preset: str | None = _quality(
        None,
        "fast, balanced, fine, reference, or a file of settings; flags win over it",
        metavar="NAME|FILE",
    )
    budget_ms: float | None = _quality(
        None,
        "the most accurate setting that fits a frame",
        unit="ms",
        low=1e-3,
        high=1e9,
        metavar="T",
    )
    error_reference: str | None = _quality(
        None,
        "what --max-error is measured against: the near field, or all light; by default by method",
        choices=("near", "gi"),
        flag_name="truth",
    )
    frames: int = _running(
        1, "frames to time after a warm-up", low=1, high=1_000_000, metavar="K", modes=modes.STILLS
    )
    stats: str | None = _running(
        None, "write times, passes and settings to a file", metavar="FILE.json", modes=modes.STILLS
    )
    backend: str = _running("auto", "where OpenGL comes from", choices=BACKENDS)
    scheduler: str | None = _running(
        None,
        "workers that render, each a process of its own: N here, or those of a Dask scheduler; of"
        " a bench, all but times",
        metavar="local[:N]|tcp://HOST:PORT",
        modes=frozenset({modes.BATCH, modes.BENCH, modes.FILM, modes.SNAPSHOT}),
    )
    resume: bool = _running(
        False,
        "render only the frames, or pictures of a batch, whose files are missing or empty",
        modes=frozenset({modes.BATCH, modes.FILM}),
    )
    quiet: bool = _running(False, "say nothing but faults")

    @property
    def active(self) -> frozenset[str]:
        """The modes that were asked for."""
        asked = {
            modes.SNAPSHOT: self.snapshot is not None,
            modes.EXPLAIN: self.explain,
            modes.BENCH: self.bench is not None,
            modes.BATCH: self.batch,
            modes.FILM: self.film is not None,
            modes.SERVE: self.serve,
        }
        named = [name for name, is_on in asked.items() if is_on]
        return frozenset(named or [modes.WINDOW])


@dataclass(frozen=True)
class FilmOptions:
    """Frames, camera path and rate of a film."""

    path: str | None = _film(
        None,
        "the camera follows the path that a window has recorded",
        metavar="VIEWS.json",
    )
    turntable: float | None = _film(
        None,
        "the camera turns by this much about its target; without a number, once round",
        unit="degrees",
        low=-1e6,
        high=1e6,
        metavar="DEGREES",
        bare="360",
    )
    frames_range: str | None = _film(
        None,
        "render frames A to B - 1, of a film of B frames or of LENGTH; by default the whole path,"
        " or eight seconds of turntable",
        metavar="A:B[/LENGTH]",
    )
    fps: float = _film(
        FRAMES_PER_SECOND,
        "frames per second",
        low=1e-3,
        high=1000.0,
        metavar="N",
    )


@dataclass(frozen=True)
class ServeOptions:
    """Address of the page, and whether those who look share a camera."""

    host: str | None = _serve(
        None,
        "listen at this address or name of the machine, 0.0.0.0 for all, and ask for a token; by"
        " default only programs of the same machine reach the page",
        metavar="ADDRESS",
    )
    port: int = _serve(
        8765, "listen at this port; 0: any that is free", low=0, high=65535, metavar="N"
    )
    viewers: str = _serve(
        "own",
        "cameras with which pages begin: one for each, or one for all; the panel changes it",
        choices=("own", "shared"),
    )

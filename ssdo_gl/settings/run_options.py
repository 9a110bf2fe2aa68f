"""What a command says beyond `Settings`: what to do, with what, and where to."""

from __future__ import annotations

from dataclasses import dataclass

from ssdo_gl.gpu.context import BACKENDS
from ssdo_gl.scene.camera import PROJECTIONS
from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import setting
from ssdo_gl.settings.settings import LOOK, QUALITY

MODE, RUNNING = "what to do (none: fly-through window)", "running"


@dataclass(frozen=True)
class RunOptions:
    """What to do, with what, and where to."""

    snapshot: str | None = setting(
        None,
        "render to OUT (.png, .jpg, .webp, .exr or .npz; - for a PNG on standard output), headless",
        metavar="OUT",
        group=MODE,
        modes=modes.HEADLESS,
    )
    explain: bool = setting(
        False, "say which passes run, which do not, and why", group=MODE, modes=modes.HEADLESS
    )
    batch: bool = setting(
        False,
        "render each SCENE, several names or quoted patterns such as 'models/*.glb', to a picture"
        " of its own, headless",
        group=MODE,
        modes=frozenset({modes.BATCH}),
    )
    out: str | None = setting(
        None,
        "the folder of a batch, which is made if need be; or names such as DIR/{name}.exr",
        metavar="DIR",
        group=MODE,
        modes=frozenset({modes.BATCH}),
    )
    film: str | None = setting(
        None,
        "render a film to OUT, headless: .mp4, .webm, .webp or .gif, a folder of pictures, or"
        " numbered files such as frame_%04d.exr",
        metavar="OUT",
        group=MODE,
        modes=frozenset({modes.FILM}),
    )
    serve: bool = setting(
        False,
        "fly through the scene in a browser, from a machine without a display",
        group=MODE,
        modes=frozenset({modes.SERVE}),
    )
    bench: str | None = setting(
        None,
        "measure error against time, into OUTDIR",
        metavar="OUTDIR",
        group=MODE,
        modes=frozenset({modes.BENCH}),
    )
    estimators: bool = setting(
        False, "bench every estimator instead", group=MODE, modes=frozenset({modes.BENCH})
    )
    quick: bool = setting(
        False, "a bench of about two minutes", group=MODE, modes=frozenset({modes.BENCH})
    )
    camera: str | None = setting(
        None,
        "where to look from and at (scene units), and the vertical field of view (degrees) or,"
        " of parallel rays, the height of what is seen (scene units); fit: frame the whole"
        " scene, whatever camera the file has",
        metavar='fit|"px,py,pz tx,ty,tz [fov]"',
        group=LOOK,
        modes=modes.ALL,
    )
    projection: str | None = setting(
        None,
        "rays through one point, or parallel ones (ortho is short); by default the scene's",
        choices=PROJECTIONS,
        group=LOOK,
        modes=modes.ALL,
    )
    aov: str | None = setting(
        None,
        "images to make, or all; a window or a page begins with the one named",
        metavar="NAME,...",
        group=LOOK,
        modes=modes.ONE,
    )
    two_sided: bool = setting(
        False, "draw backs that a glTF file says to leave out", group=LOOK, modes=modes.ALL
    )
    time: float = setting(
        0.0,
        "time of an animated scene; a window or a page begins there",
        unit="s",
        low=-1e9,
        high=1e9,
        metavar="S",
        group=LOOK,
        modes=modes.ONE,
    )
    preset: str | None = setting(
        None,
        "fast, balanced, fine, reference, or a file of settings; flags win over it",
        metavar="NAME|FILE",
        group=QUALITY,
        modes=modes.ONE,
    )
    budget_ms: float | None = setting(
        None,
        "the most accurate setting that fits a frame",
        unit="ms",
        low=1e-3,
        high=1e9,
        metavar="T",
        group=QUALITY,
        modes=modes.ONE,
    )
    error_reference: str | None = setting(
        None,
        "what --max-error is measured against: the near field, or all light; by default by method",
        choices=("near", "gi"),
        flag_name="truth",
        group=QUALITY,
        modes=modes.ONE,
    )
    recalibrate: bool = setting(
        False, "measure anew for --budget-ms or --max-error", group=QUALITY, modes=modes.ONE
    )
    frames: int = setting(
        1,
        "frames to time after a warm-up",
        low=1,
        high=1_000_000,
        metavar="K",
        group=RUNNING,
        modes=modes.STILLS,
    )
    stats: str | None = setting(
        None,
        "write times, passes and settings to a file",
        metavar="FILE.json",
        group=RUNNING,
        modes=modes.STILLS,
    )
    backend: str = setting(
        "auto", "where OpenGL comes from", choices=BACKENDS, group=RUNNING, modes=modes.ALL
    )
    scheduler: str | None = setting(
        None,
        "workers that render, each a process of its own: N here, or those of a Dask scheduler; of"
        " a bench, all but times",
        metavar="local[:N]|tcp://HOST:PORT",
        group=RUNNING,
        modes=frozenset({modes.BATCH, modes.BENCH, modes.FILM, modes.SNAPSHOT}),
    )
    resume: bool = setting(
        False,
        "render only the frames, or pictures of a batch, whose files are missing or empty",
        group=RUNNING,
        modes=frozenset({modes.BATCH, modes.FILM}),
    )
    quiet: bool = setting(False, "say nothing but faults", group=RUNNING, modes=modes.ALL)

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

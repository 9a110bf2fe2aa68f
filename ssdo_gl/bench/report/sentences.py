"""The sentences of a bench's report: what was measured, how, and how far to trust it."""

from __future__ import annotations

import math

from ssdo_gl.bench.analysis import ReferenceSummary, percent
from ssdo_gl.bench.bench_data import Bench
from ssdo_gl.bench.measure import CLOCK_NAMES, ErrorPanel
from ssdo_gl.bench.statistics import FLIP_EXPOSURES_EV, FLIP_PIXELS_PER_DEGREE
from ssdo_gl.images.error import REL_MSE_EPSILON

# A reference may be used without a word if its standard error is at most this part of the
# smallest error that is reported against it.
TRUSTED_RATIO = 0.1


def facts(bench: Bench) -> list[tuple[str, str]]:
    """Return the facts a reader needs before any number, as (name, value)."""
    slowest = max(bench.drift, default=1.0)
    return [
        ("picture", f"{bench.base.size[0]} x {bench.base.size[1]} px"),
        ("near field", f"R = {bench.base.radius:.3g} scene units, about {bench.radius_px:.0f} px"),
        ("triangles", f"{bench.triangles:,}"),
        ("settings measured", str(len(bench.results))),
        ("timed by", CLOCK_NAMES[bench.clock]),
        ("rounds", f"{bench.rounds} of {bench.frames} warm frames, interleaved"),
        ("slowest round", f"{slowest:.2f} times the usual (divided out)"),
        ("seeds", str(bench.seeds)),
    ]


def reference_sentence(panel: ErrorPanel, reference: ReferenceSummary | None) -> str:
    """Return what a panel's reference is and what it is worth; empty if it was not measured."""
    if reference is None:
        return ""
    show = percent if panel.relative else lambda value: f"{value:.3g}"
    text = (
        f"{panel.title}: {reference.method}, {reference.spp} samples per pixel in "
        f"{reference.batches} independent batches ({reference.seconds:.0f} s). Its standard "
        f"error is {show(reference.standard_error)}"
    )
    if math.isfinite(reference.ratio):
        text += f", {reference.ratio:.2f} of the smallest error reported"
    text += "; its variance is subtracted from every squared error."
    if reference.ratio > TRUSTED_RATIO:
        text += (
            " That is more than a tenth: the smallest errors are less sure than their "
            "intervals say. A longer run (without --quick) refines the reference."
        )
    if math.isfinite(reference.floor):
        text += (
            f" The march, converged (32 directions of 32 steps), is still {show(reference.floor)} "
            f"away: {panel.lacks}."
        )
    if reference.floor_parts:
        parts = ", ".join(f"{name} {percent(v)}" for name, v in reference.floor_parts.items())
        text += f" By part, relative to each part's own mean: {parts}."
    return text


def method_paragraphs(bench: Bench) -> list[str]:
    """Return how everything was measured."""
    start, stop, count = FLIP_EXPOSURES_EV
    return [
        (
            "Time: every setting is rendered warm; rounds visit all settings in a random order "
            f"(seeded), {bench.frames} frames a visit, each recomputing the whole view. The median "
            "over frames is one measurement; the median over rounds is reported, after each "
            "round's own slowness (the median over all settings) has been divided out. Compilation "
            f"and uploads are in the column 'first frame'. Clock: {CLOCK_NAMES[bench.clock]}; "
            "processor time counts all threads of the process."
        ),
        (
            "Error: over covered pixels that do not themselves emit light, all three channels, "
            "against a ray-traced reference that starts from the same G-buffer; "
            f"{bench.seeds} seeds. Relative errors are root mean squares over the mean of the "
            "reference. The reference's own variance, known from independent batches, is "
            "subtracted. Pixels with NaN or infinity are counted and make the error infinite."
        ),
        (
            "Three faults are told apart. Noise is the scatter between seeds: the estimator and "
            "its own expectation. Own bias is the distance of that expectation from the march's, "
            "converged: what better settings would mend. What even that march lacks is what the "
            "screen does not show (and shadow maps). Systematic is the distance of the expectation "
            "from the reference. total^2 = noise^2 + systematic^2."
        ),
        (
            "Intervals: 95 %, a paired bootstrap over pixel blocks and seeds (errors) and over "
            "rounds (times). How sure a setting is on the front is the share of bootstrap replicas "
            "in which it is. They describe this view of this scene on this machine."
        ),
        (
            f"relMSE adds {REL_MSE_EPSILON} to the squared reference, in display white. SSIM is "
            "computed on sRGB pictures. FLIP assumes "
            f"{FLIP_PIXELS_PER_DEGREE:.0f} pixels per degree; HDR-FLIP uses the fixed exposures "
            f"{start:+.0f} to {stop:+.0f} EV in {count} steps around the camera's."
        ),
    ]


def machine_rows(bench: Bench) -> list[tuple[str, str]]:
    """Return machine, driver, versions and command as (name, value)."""
    machine = bench.machine
    load = machine.get("load")
    rows = [
        ("renderer", machine["renderer"]),
        ("OpenGL", f"{machine['opengl']} ({machine['backend']})"),
        ("processor", f"{machine['processor']}, {machine['cores']} cores"),
        ("load at the start", "unknown" if load is None else f"{load:.2f}"),
        ("system", machine["system"]),
        ("Python", machine["python"]),
        ("ssdo_gl", machine["ssdo_gl"]),
        *machine["versions"].items(),
        ("date", machine["date"]),
        ("command", machine["command"]),
    ]
    return [(str(name), str(value)) for name, value in rows]

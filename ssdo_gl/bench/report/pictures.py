"""The pictures of a report: chosen settings beside their references, with FLIP maps."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ssdo_gl.bench.analysis import Recommendation, Result, front_of
from ssdo_gl.bench.bench_data import Picture
from ssdo_gl.bench.measure import PICTURE, BenchRenderer, ErrorPanel, Reference, color, error_panels
from ssdo_gl.bench.statistics import flip_hdr, flip_ldr, srgb_of
from ssdo_gl.graph.render_pass import ProgressCallback
from ssdo_gl.images.error import Mask
from ssdo_gl.images.files import png_bytes
from ssdo_gl.settings import Settings

# Pictures weigh about 0.1 MB each in the report; more than this of one group and nobody
# clicks through them.
MAX_OF_A_GROUP = 9


def png_of(srgb: NDArray[np.float32]) -> bytes:
    """Return an image in [0, 1] (height, width, 3) as a PNG file."""
    pixels = np.round(255.0 * np.clip(srgb, 0.0, 1.0)).astype(np.uint8)
    return png_bytes(pixels, optimize=True)


def flip_map_png(error: NDArray[np.float32]) -> bytes:
    """Return a FLIP error map in the colours of its authors (magma) as a PNG file."""
    from matplotlib import colormaps

    return png_of(np.asarray(colormaps["magma"](error))[:, :, :3].astype(np.float32))


def shown(panel: ErrorPanel, image: NDArray[np.float32], exposure_ev: float) -> NDArray[np.float32]:
    """Return an AOV as it is displayed: pictures exposed, other images as they are."""
    shades = np.repeat(image, 3, axis=2) if image.shape[2] == 1 else color(image)
    return srgb_of(shades, exposure_ev if panel.is_picture else 0.0)


def _reference_name(panel: ErrorPanel) -> str:
    return f"reference: {panel.method}"


def chosen_results(results: Sequence[Result], recommendation: Recommendation) -> list[Result]:
    """Return the results worth looking at: recommended, front members, and what they beat."""
    chosen: dict[str, Result] = {}
    if recommendation.result is not None:
        chosen[recommendation.result.point.key] = recommendation.result
    for panel in error_panels():
        front = front_of(results, panel.name)
        spread = {round(i * (len(front) - 1) / 3) for i in range(4)} if front else set()
        members = [front[i] for i in sorted(spread)]
        others = [r for r in results if panel.name in r.verdicts]
        seen = {r.point.family for r in members}
        # One of each family, so that what lost can be seen, too.
        for result in others:
            if result.point.family not in seen:
                seen.add(result.point.family)
                members.append(result)
        for result in members[:MAX_OF_A_GROUP]:
            chosen.setdefault(result.point.key, result)
    return list(chosen.values())


def with_hdr_flip(
    renderer: BenchRenderer,
    base: Settings,
    results: Sequence[Result],
    chosen: Sequence[Result],
    references: Mapping[str, Reference],
    mask: Mask,
    report: ProgressCallback | None = None,
) -> list[Result]:
    """Return `results` with the HDR-FLIP of those that are `chosen` filled in."""
    exposure = base.exposure or 0.0
    keys = {result.point.key for result in chosen}
    filled = []
    for done, result in enumerate(results, 1):
        point = result.point
        verdicts = dict(result.verdicts)
        if point.key in keys and point.kind == PICTURE:
            image = color(renderer.images(point.settings(base), ("beauty",))["beauty"])
            for name, verdict in result.verdicts.items():
                target = color(references[name].images["beauty"])
                mean = flip_hdr(image, target, mask, exposure).mean
                scalars = dataclasses.replace(verdict.scalars, flip_hdr=mean)
                verdicts[name] = dataclasses.replace(verdict, scalars=scalars)
        filled.append(dataclasses.replace(result, verdicts=verdicts))
        if report is not None:
            report("HDR-FLIP", done, len(results))
    return filled


def take_pictures(
    renderer: BenchRenderer,
    base: Settings,
    results: Sequence[Result],
    references: Mapping[str, Reference],
    mask: Mask,
    report: ProgressCallback | None = None,
) -> list[Picture]:
    """Return the references, then every result with its FLIP map against its reference."""
    exposure = base.exposure or 0.0
    pictures = []
    targets: dict[str, tuple[ErrorPanel, NDArray[np.float32]]] = {}
    for panel in error_panels():
        if panel.name not in references:
            continue
        target = shown(panel, references[panel.name].images[panel.aov], exposure)
        targets[panel.name] = panel, target
        pictures.append(
            Picture(
                _reference_name(panel),
                png_of(target),
                None,
                panel.kind,
                True,
                f"{panel.method}, {references[panel.name].spp} samples per pixel",
            )
        )
    for done, result in enumerate(results, 1):
        # Of two references that judge a point the first makes its FLIP map: the near-field one.
        judging = [targets[name] for name in result.verdicts if name in targets]
        if not judging:
            continue
        panel, target = judging[0]
        image = renderer.images(result.point.settings(base), (panel.aov,))[panel.aov]
        picture = shown(panel, image, exposure)
        flip = flip_ldr(picture, target, mask)
        caption = (
            f"{result.point.label}: {result.timing.ms.value:.3g} ms, mean FLIP "
            f"{flip.mean:.3f} against {panel.method}"
        )
        pngs = png_of(picture), flip_map_png(flip.error)
        against = _reference_name(panel)
        pictures.append(Picture(result.point.label, *pngs, panel.kind, False, caption, against))
        if report is not None:
            report("pictures", done, len(results))
    return pictures

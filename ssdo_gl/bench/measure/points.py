"""What a sweep measures: points in the space of settings, declared as data.

The grid is a TOML file of families. Each key of a family that names an axis holds one
value or a list; the family stands for the product of its lists. `grid.toml` of the bench
is the default.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from ssdo_gl.effects import registry
from ssdo_gl.settings import Settings
from ssdo_gl.settings.estimators import ESTIMATORS
from ssdo_gl.settings.methods import METHODS, Method

# The kind of points that are judged by their picture; any other kind is an image's name.
PICTURE = "radiance"
_FAMILY_KEYS = ("name", "kind", "quick", "set")


@dataclass(frozen=True)
class Point:
    """One setting to be measured.

    Attributes
    ----------
    kind : str
        ``radiance`` (the picture), or the AOV that is judged, such as ``visibility``.
    family : str
        The grid family it comes from; points of one family share a curve in plots.
    radius_factor : float
        Radius relative to that of the bench.
    spp : int or None
        Rays or paths per pixel; only of the ray-traced methods.
    overrides : tuple of (str, value)
        ``PASS.FIELD`` settings beyond the named ones.
    quick : bool
        Whether ``--quick`` measures it.
    """

    kind: str
    family: str
    method: str
    estimator: str | None = None
    samples: int = 1
    steps: int = 1
    resolution_scale: float = 1.0
    filter: str = "none"
    radius_factor: float = 1.0
    spp: int | None = None
    overrides: tuple[tuple[str, Any], ...] = ()
    quick: bool = False

    @property
    def key(self) -> str:
        """A name that is unique in a grid and stable between runs: fit for a file."""
        parts = [self.kind, self.method]
        if self.estimator:
            parts += [self.estimator, f"n{self.samples}", f"m{self.steps}"]
            parts += [f"s{self.resolution_scale:g}", self.filter]
        if self.spp:
            parts.append(f"spp{self.spp}")
        if self.radius_factor != 1.0:
            parts.append(f"r{self.radius_factor:g}")
        parts += [f"{name}={value}" for name, value in self.overrides]
        return re.sub(r"[^A-Za-z0-9.=+-]", "_", "-".join(parts))

    @property
    def label(self) -> str:
        """What a person reads: ``bounce march 8x8 half edge``."""
        if not self.estimator:
            return f"{self.method} {self.spp} spp" if self.spp else self.method
        count = ESTIMATORS[self.estimator].count_label(self.samples, self.steps)
        parts = [self.method, self.estimator, count]
        parts.append("half" if self.resolution_scale == 0.5 else "full")
        parts.append(self.filter if self.filter != "none" else "unfiltered")
        if self.radius_factor != 1.0:
            parts.append(f"R x{self.radius_factor:g}")
        parts += [f"{name.partition('.')[2]}={value}" for name, value in self.overrides]
        return " ".join(parts)

    @property
    def wanted(self) -> tuple[str, ...]:
        """The image that a user of this point asks for, and that is timed."""
        return ("beauty",) if self.kind == PICTURE else (self.kind,)

    def settings(self, base: Settings, seed_offset: int = 0) -> Settings:
        """Return `base` with this point's settings.

        Parameters
        ----------
        base : Settings
            With a radius; its size, shadows and exposure hold.
        seed_offset : int
            Added to the seed.
        """
        if base.radius is None:
            raise ValueError("the base of a sweep needs a radius")
        fields: dict[str, Any] = {"spp": self.spp} if self.spp else {}
        if self.estimator:
            fields = {
                "samples": self.samples,
                "steps": self.steps,
                "resolution_scale": self.resolution_scale,
                "filter": self.filter,
            }
        return dataclasses.replace(
            base,
            method=self.method,
            estimator=self.estimator,
            radius=base.radius * self.radius_factor,
            seed=base.seed + seed_offset,
            antialias=1,
            max_error=None,
            overrides={**base.overrides, **dict(self.overrides)},
            **fields,
        ).checked()


def read_grid(path: Path | None = None) -> tuple[Point, ...]:
    """Return the points of a grid file; of the shipped one if `path` is None.

    What the shipped file does not name - a method, an estimator of one, an image that an
    effect makes and a reference has - is measured by `further_families`.
    """
    file = path or files("ssdo_gl.bench").joinpath("grid.toml")
    families = tomllib.loads(file.read_text(encoding="utf-8"))["family"]
    if path is None:
        families += further_families(families)
    points: dict[str, Point] = {}
    for family in families:
        for point in _points_of(family):
            # Two families may share a point; it is measured once, for the first.
            kept = points.setdefault(point.key, point)
            if point.quick and not kept.quick:
                points[point.key] = dataclasses.replace(kept, quick=True)
    return tuple(points.values())


def further_families(families: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a small family for whatever the registries know and `families` does not name."""
    named = {(f["method"], f.get("estimator")) for f in families}
    kinds = {f["kind"] for f in families}
    wanted = [
        (PICTURE, method, estimator)
        for method in METHODS.values()
        for estimator in method.estimators or (None,)
        if (method.name, estimator) not in named
    ]
    for image in dict.fromkeys(name for effect in registry.effects() for name in effect.images):
        if image not in kinds:
            method = METHODS[screen_space_method(image)]
            wanted.append((image, method, next(iter(method.estimators), None)))
    return [_small_family(*item) for item in wanted]


def _small_family(kind: str, method: Method, estimator: str | None) -> dict[str, Any]:
    family: dict[str, Any] = {"kind": kind, "method": method.name, "quick": {}}
    if estimator is not None:
        family |= {"estimator": estimator, "samples": [16, 64], "filter": "edge"}
        family |= {"steps": 8 if ESTIMATORS[estimator].takes_steps else 1}
        family |= {"quick": {"samples": 16}}
    elif method.is_reference:
        family |= {"spp": [4, 16]}
    return family | {"name": " ".join(filter(None, (method.name, estimator, kind)))}


def screen_space_method(kind: str, *, all_light: bool = False) -> str:
    """Return the method that shows all that screen space knows of a kind of points.

    Of pictures it is the one with the most terms, of images the first that has it.

    Parameters
    ----------
    all_light : bool
        Whether light from beyond R counts, too.
    """

    def count(name: str) -> tuple[bool, int]:
        members = [e for e in registry.effects() if name in e.methods]
        if kind == PICTURE:
            is_wanted = METHODS[name].is_all_light == all_light
            return is_wanted, sum(len(effect.terms) for effect in members)
        return True, any(kind in effect.images for effect in members)

    return max((n for n, method in METHODS.items() if not method.is_reference), key=count)


def _points_of(family: Mapping[str, Any]) -> Iterator[Point]:
    """Yield the points that one family stands for."""
    overrides = tuple(sorted(family.get("set", {}).items()))
    axes = {key: _as_list(value) for key, value in family.items() if key not in _FAMILY_KEYS}
    for values in itertools.product(*axes.values()):
        row = dict(zip(axes, values, strict=True))
        if row.get("steps", 1) > row.get("samples", row.get("steps", 1)):
            continue
        is_quick = "quick" in family and all(
            row.get(axis) in _as_list(wanted) for axis, wanted in family["quick"].items()
        )
        kind, name = family["kind"], family["name"]
        yield Point(kind, name, overrides=overrides, quick=is_quick, **row)


def _as_list(value: Any) -> list[Any]:
    return list(value) if isinstance(value, list) else [value]

"""Tables of scene files by one call each, for tests that write many."""

from __future__ import annotations

import json
from typing import Any


def table(name: str, **keys: Any) -> str:
    """Return a table; keys whose value is None are left out."""
    given = {key: value for key, value in keys.items() if value is not None}
    return "\n".join([f"[{name}]", *(f"{k} = {json.dumps(v)}" for k, v in given.items()), ""])


def camera(position: Any, target: Any, fov_y: float | None = None, **keys: Any) -> str:
    return table("camera", position=position, target=target, fov_y=fov_y, **keys)


def constant_sky(*radiance: float) -> str:
    return table("environment", kind="constant", radiance=radiance)


def material(name: str, *albedo: float, **keys: Any) -> str:
    return table(f"materials.{name}", albedo=albedo, **keys)


def body(shape: str, material: str | None = None, **keys: Any) -> str:
    return table("[object]", shape=shape, **keys, material=material)


def quad(corner: Any, edge_u: Any, edge_v: Any, material: str | None = None, **keys: Any) -> str:
    return body("quad", material, corner=corner, edge_u=edge_u, edge_v=edge_v, **keys)


def floor(size: float, material: str | None = None) -> str:
    """Return a level square about the origin."""
    return body("plane", material, point=[0, 0, 0], normal=[0, 1, 0], size=size)


def ball(center: Any, radius: float, material: str | None = None, **keys: Any) -> str:
    return body("sphere", material, center=center, radius=radius, **keys)


def box(low: Any, high: Any, material: str | None = None, **keys: Any) -> str:
    return body("box", material, min=low, max=high, **keys)


def light(kind: str, **keys: Any) -> str:
    return table("[light]", kind=kind, **keys)


def lamp(corner: Any, edge_u: Any, edge_v: Any, radiance: Any, **keys: Any) -> str:
    """Return an area light."""
    return light("area", corner=corner, edge_u=edge_u, edge_v=edge_v, radiance=radiance, **keys)

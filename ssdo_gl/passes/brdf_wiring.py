"""What passes read that include ``lib/brdf.glsl`` for the surfaces in view."""

from __future__ import annotations


def brdf_wiring(glossy: bool) -> dict[str, str]:
    """Return the resource behind each sampler; `glossy` is the define GLOSSY."""
    gloss = {"t_gloss": "gloss", "t_finish": "finish"} if glossy else {}
    return {"t_albedo": "albedo", **gloss}

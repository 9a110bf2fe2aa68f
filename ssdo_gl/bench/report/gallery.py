"""The pictures of a page: side by side with their references, and FLIP maps with a scale."""

from __future__ import annotations

import base64
from html import escape

from ssdo_gl.bench.bench_data import Bench, Picture

# Where the scale of the FLIP maps is labelled.
_SCALE = ("0: no visible difference", "0.25", "0.5", "0.75", "1: black beside white")


def data_uri(data: bytes, kind: str) -> str:
    """Return bytes as a ``data:`` URI of a media type."""
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def gallery(bench: Bench) -> str:
    """Return all pictures, and what lets a script put two of them over each other."""
    if not bench.pictures:
        return '<p class="note">No pictures were kept in this run.</p>'
    figures = "".join(_figure(i, picture) for i, picture in enumerate(bench.pictures))
    return (
        f'<div class="with-js">{_compare(bench)}</div>{flip_scale()}'
        f'<details id="gallery" open><summary>All pictures</summary>'
        f'<div class="gallery">{figures}</div></details>'
    )


def _figure(index: int, picture: Picture) -> str:
    flip = ""
    if picture.flip_png is not None:
        uri = data_uri(picture.flip_png, "image/png")
        flip = f'<img id="flip-{index}" alt="its FLIP map" src="{uri}">'
    reference = " data-reference" if picture.is_reference else ""
    return (
        f'<figure data-group="{escape(picture.group)}" '
        f'data-against="{escape(picture.against)}"{reference}>'
        f'<img id="picture-{index}" alt="{escape(picture.name)}" '
        f'src="{data_uri(picture.png, "image/png")}">{flip}'
        f"<figcaption>{escape(picture.caption)}</figcaption></figure>"
    )


def _compare(bench: Bench) -> str:
    reference = next((i for i, p in enumerate(bench.pictures) if p.is_reference), 0)
    group = bench.pictures[reference].group
    others = (i for i, p in enumerate(bench.pictures) if not p.is_reference and p.group == group)

    def options(selected: int) -> str:
        return "".join(
            f'<option value="{i}"{" selected" if i == selected else ""}>'
            f"{escape(picture.name)}</option>"
            for i, picture in enumerate(bench.pictures)
        )

    return (
        '<div class="controls">'
        f'<label>left <select id="left">{options(next(others, 0))}</select></label>'
        f'<label>right <select id="right">{options(reference)}</select></label>'
        '<label><input type="checkbox" id="flip"> FLIP map of the left one</label></div>'
        '<div class="compare" id="compare"><img id="image-under" alt="right picture">'
        '<div class="over" id="over"><img id="image-over" alt="left picture"></div>'
        '<div class="edge" id="edge"></div><span class="name-left" id="name-left"></span>'
        '<span class="name-right" id="name-right"></span></div>'
        '<input type="range" id="edge-slider" min="0" max="1000" value="500" '
        'aria-label="where the two pictures meet"><p class="note" id="caption"></p>'
    )


def flip_scale() -> str:
    """Return the colours of FLIP maps with what they mean."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    stops = ", ".join(to_hex(colormaps["magma"](i / 8.0)) for i in range(9))
    marks = "".join(f"<span>{mark}</span>" for mark in _SCALE)
    return (
        f'<figure class="scale"><figcaption>FLIP, for all maps alike</figcaption>'
        f'<div style="background: linear-gradient(to right, {stops})"></div>'
        f'<p class="note">{marks}</p></figure>'
    )

"""Damage to files: to their bytes, their words, their lines, and the tree of a glTF."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from typing import Any

NUMBERS = (
    "0", "-1", "1", "-0.0", "2", "255", "65536", "2147483647", "4294967295", "4294967296",
    "9223372036854775807", "1e-320", "1e-30", "1e30", "3.5e38", "1e39", "1e300", "-1e300",
    "nan", "inf", "-inf", "1e400", "9" * 5000, "0x10", "1_0", "1.#INF", "1,5",
)  # fmt: skip
WORDS = (
    "", "../secret.png", "../secret.obj", "/etc/passwd", "C:\\secret.png", "..\\secret.mtl",
    "a" * 300, "\x1b[31m", "\u202e", "caf\u00e9", "a.toml", ".", "nul\0l", "%2e%2e/secret.png",
    "file:///etc/passwd", "data:image/png;base64,AAAA", "http://localhost/x.png", "[" * 2000,
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 3, 0.5, -0.0, 2**31, 2**32, 2**53, 2**64, 10**40, 1e39, 1e300,
    float("nan"), float("inf"), "", "x", [], {}, [0], [None] * 3, [1e300] * 3, {"a": 1},
)  # fmt: skip

Change = Callable[[bytes, random.Random], bytes]


def flip(data: bytes, rng: random.Random) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        if out:
            out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def overwrite(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    piece = rng.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\x7f\xff\xff\xff", b"\0\0\xc0\x7f",
                        b"\0\0\x80\x7f", b"\x01\0\0\0", b"\xff", b"\0"))  # fmt: skip
    return data[:at] + piece + data[at + len(piece) :]


def cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data) + 1)]


def remove(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + data[at + rng.choice((1, 2, 4, 17)) :]


def repeat(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    piece = data[at : at + rng.choice((1, 4, 60, 400))]
    return data[:at] + piece * rng.choice((2, 3, 200)) + data[at:]


def number(data: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(rb"[-+]?\d[\d.e+-]*", data))
    if not found:
        return flip(data, rng)
    match = rng.choice(found)
    return data[: match.start()] + rng.choice(NUMBERS).encode() + data[match.end() :]


def word(data: bytes, rng: random.Random) -> bytes:
    found = list(re.finditer(rb"[\w./-]+", data))
    if not found:
        return flip(data, rng)
    match = rng.choice(found)
    other = rng.choice(found)[0] if rng.random() < 0.5 else rng.choice(WORDS).encode()
    return data[: match.start()] + other + data[match.end() :]


def line(data: bytes, rng: random.Random) -> bytes:
    lines = data.split(b"\n")
    at, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    action = rng.randrange(4)
    if action == 0:
        del lines[at]
    elif action == 1:
        lines.insert(other, lines[at])
    elif action == 2:
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines[at] = b"".join(lines[at : at + 2])
    return b"\n".join(lines)


def line_ends(data: bytes, rng: random.Random) -> bytes:
    return data.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b" \n")))


def tree(data: bytes, rng: random.Random) -> bytes:
    """Change one place of a JSON document, that of a .glb included."""
    begin, end = 0, len(data)
    if data[:4] == b"glTF":
        begin, end = 20, 20 + int.from_bytes(data[12:16], "little")
    try:
        document = json.loads(data[begin:end])
    except (ValueError, RecursionError):
        return flip(data, rng)
    places: list[tuple[Any, Any]] = []
    queue = [document]
    while queue:
        node = queue.pop()
        keys = list(node) if isinstance(node, dict) else range(len(node))
        places += [(node, key) for key in keys]
        queue += [node[key] for key in keys if isinstance(node[key], (dict, list))]
    if not places:
        return flip(data, rng)
    node, key = rng.choice(places)
    if rng.random() < 0.2:
        del node[key]
    elif rng.random() < 0.3:
        other, name = rng.choice(places)
        if name in other if isinstance(other, dict) else name < len(other):
            node[key] = json.loads(json.dumps(other[name]))
    elif isinstance(node[key], str):
        node[key] = rng.choice(WORDS)
    else:
        node[key] = rng.choice(VALUES)
    text = json.dumps(document).encode()
    if not begin:
        return text
    text += b" " * (-len(text) % 4)
    rest = data[:12] + len(text).to_bytes(4, "little") + b"JSON" + text + data[end:]
    return rest[:8] + len(rest).to_bytes(4, "little") + rest[12:]


ON_BYTES: tuple[Change, ...] = (flip, overwrite, cut, remove, repeat)
ON_TEXT: tuple[Change, ...] = (*ON_BYTES, number, number, number, word, word, line, line_ends)
ON_TREE: tuple[Change, ...] = (tree, tree, tree, tree, number, word, flip, cut)
TEXTS = (".toml", ".obj", ".mtl", ".ply", ".off", ".stl")


def damaged(files: dict[str, bytes], rng: random.Random) -> dict[str, bytes]:
    """Return the files with one to four changes, most of them to the first file."""
    result = dict(files)
    names = list(files)
    for _ in range(rng.choice((1, 1, 2, 4))):
        name = names[0] if rng.random() < 0.7 else rng.choice(names)
        changes = ON_BYTES
        if name.endswith((".gltf", ".glb")):
            changes = ON_TREE
        elif name.endswith(TEXTS):
            changes = ON_TEXT
        result[name] = rng.choice(changes)(result[name], rng)
    return result

"""README and docs/ as text: their blocks, spans, sections and tables."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from ssdo_gl.cli import build_parser
from ssdo_gl.options.flags import flag_infos
from ssdo_gl.settings import modes
from ssdo_gl.settings.fields import Kind, value_text

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md")))
TEXTS = {page.relative_to(ROOT).as_posix(): page.read_text(encoding="utf-8") for page in PAGES}
# The effect that a reader of adding-an-effect.md writes; a test of that page runs it.
TUTORIAL = "headlight"


class Block(NamedTuple):
    """A fenced block of a page."""

    page: str
    language: str
    text: str


def all_blocks() -> Iterator[Block]:
    for page, text in TEXTS.items():
        for language, body in re.findall(
            r"^```([^\n]*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE
        ):
            yield Block(page, language, body)


BLOCKS = tuple(all_blocks())


def blocks(language: str) -> list[Block]:
    return [block for block in BLOCKS if block.language == language]


def prose(text: str) -> str:
    """Return a page without its fenced blocks."""
    return re.sub(r"^```.*?^```$", "", text, flags=re.DOTALL | re.MULTILINE)


def code_spans(text: str) -> list[str]:
    """Return what stands between backticks, bars of tables unescaped."""
    return [span.replace("\\|", "|") for span in re.findall(r"`([^`]+)`", prose(text))]


def section(page: str, heading: str) -> str:
    """Return what stands below a heading, up to the next one of its level or above."""
    marks = re.search(rf"^(#+) {re.escape(heading)}$", TEXTS[page], re.MULTILINE)
    assert marks is not None, f"{page} has no section {heading!r}"
    return re.split(rf"^#{{1,{len(marks[1])}}} ", TEXTS[page][marks.end() :], flags=re.MULTILINE)[0]


def table(text: str) -> list[list[str]]:
    """Return the cells of a text's tables, row by row, headings left out."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    rules = {index for index, line in enumerate(lines) if re.fullmatch(r"[|: -]+", line)}
    return [
        [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for index, line in enumerate(lines)
        if not {index, index + 1} & rules
    ]


def first_names(text: str) -> list[str]:
    """Return the code spans of each row's first cell, of all rows of a text's tables."""
    return [name for row in table(text) for name in code_spans(row[0])]


def options() -> set[str]:
    return {o for action in build_parser()._actions for o in action.option_strings}


def settings_table() -> str:
    """Return every flag with its values, effect and modes as a Markdown table."""
    lines = ["| flag | values | default | effect | used by |", "|---|---|---|---|---|"]
    for _, info in flag_infos().values():
        values = ", ".join(f"`{value_text(c)}`" for c in info.choices) or info.range_text
        is_plain = info.default is None or info.kind in (Kind.BOOLEAN, Kind.MAPPING)
        default = "" if is_plain else f"`{value_text(info.default)}`"
        flag = f"{info.flag} {info.metavar}".rstrip().replace("|", "\\|")
        used = "all" if info.modes == modes.ALL else ", ".join(sorted(info.modes))
        lines.append(f"| `{flag}` | {values} | {default} | {info.doc} | {used} |")
    return "\n".join(lines) + "\n"

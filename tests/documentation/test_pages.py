"""Form of README and docs/: lengths, links, anchors, files, pictures, words."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from documentation.pages import (
    BLOCKS,
    ROOT,
    TEXTS,
    TUTORIAL,
    blocks,
    code_spans,
    first_names,
    prose,
    section,
    table,
)
from markdown_it import MarkdownIt

# More would not be read; the rest has pages of its own.
MOST_README_LINES = 150
# Of prose: tables, pictures and links that nothing can break are as long as they are.
MOST_COLUMNS = 120
LANGUAGES = {"sh", "text", "python", "toml", "glsl", "mermaid"}
MACHINE_PATH = re.compile(r"(?<![\w.])/(home|root|tmp|work|usr|mnt)/")
# Words that say less than the field's own: reference, neighbours, visibility, input, requested.
# One of them is a flag.
PRIVATE_WORDS = re.compile(
    r"nobody can tell|no numbers\b|content to be|\b(?<!line of )sight\b"
    r"|\b(hands|company|desk|(?<!--)(?<!flag.name=.)truths?|wish(es|ed|ing)?|pretend(s|ed|ing)?)\b",
    re.IGNORECASE,
)


def test_the_readme_is_short():
    assert len(TEXTS["README.md"].splitlines()) <= MOST_README_LINES


def test_the_readme_shows_the_command_that_runs_the_tests():
    assert "make test " in TEXTS["README.md"]


def test_every_block_names_its_language():
    assert {block.language for block in BLOCKS} == LANGUAGES


def anchors(text: str) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.+)$", prose(text), re.MULTILINE)
    kept = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {heading.replace(" ", "-") for heading in kept}


@pytest.mark.parametrize("page", TEXTS)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(TEXTS[page])):
        if target.startswith("https://"):
            continue
        name, _, anchor = target.partition("#")
        path = ((ROOT / page).parent / name).resolve() if name else ROOT / page
        assert path.is_file(), target
        assert path.is_relative_to(ROOT), target
        if anchor:
            assert anchor in anchors(TEXTS[path.relative_to(ROOT).as_posix()]), target


def test_every_page_is_reached_from_the_readme():
    linked = set(re.findall(r"\]\(([\w/.-]+\.md)\)", TEXTS["README.md"]))
    assert linked == set(TEXTS) - {"README.md"}


def test_every_picture_is_shown():
    shown_pictures = {
        Path(target).name
        for text in TEXTS.values()
        for target in re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text)
    }
    folder = ROOT / ".github" / "pictures"
    assert shown_pictures == {p.name for p in folder.iterdir() if p.suffix in (".jpg", ".webp")}


# Files that a run writes, and forms of names.
WRITTEN = {"report.html", "bench/", "bench/gpu", "bench/presets"}


@pytest.mark.parametrize("page", TEXTS)
def test_named_files_exist(page):
    path = re.compile(r"[\w.-]*(/[\w.-]+)+/?|[\w.-]+/|[\w-]+\.(py|glsl|frag|vert|toml|md|html|yml)")
    named = {span for span in code_spans(TEXTS[page]) if path.fullmatch(span)} - WRITTEN
    for name in (name for name in named if TUTORIAL not in name):
        # Folders of the package are named without it.
        assert any((base / name).exists() for base in (ROOT, ROOT / "ssdo_gl")), name


def test_the_layout_is_that_of_the_package():
    text = next(b.text for b in blocks("text") if b.text.startswith("ssdo_gl/\n"))
    top = re.findall(r"^([\w.]+/)", text, re.MULTILINE)
    inside = re.findall(r"^  ([\w./]+)", text, re.MULTILINE)
    assert all((ROOT / name).is_dir() for name in top)
    shaders = first_names(section("docs/architecture.md", "Shaders"))
    folders = [p for p in (ROOT / "shaders").iterdir() if p.is_dir()]
    assert sorted(shaders) == sorted(f"shaders/{folder.name}/" for folder in folders)
    assert all((ROOT / "ssdo_gl" / name).exists() for name in inside)
    entries = {
        f"{path.name}/" if path.is_dir() else path.name
        for path in (ROOT / "ssdo_gl").iterdir()
        if path.name not in ("__pycache__", "py.typed")
    }
    assert {name for name in inside if name.count("/") <= name.endswith("/")} == entries


@pytest.mark.parametrize("page", TEXTS)
def test_lines_of_prose_are_short(page):
    lines = (line.removeprefix("- ").strip() for line in prose(TEXTS[page]).splitlines())
    long = [line for line in lines if len(line) > MOST_COLUMNS and " " in line]
    assert [line for line in long if not line.startswith(("|", "!["))] == []


@pytest.mark.parametrize("page", TEXTS)
def test_pages_render(page):
    """Tables are tables: a row with a cell too many would lose it without a word."""
    html = MarkdownIt("commonmark").enable("table").render(TEXTS[page])
    rules = re.findall(r"^\|[|: -]+\|$", prose(TEXTS[page]), re.MULTILINE)
    assert html.count("<table>") == len(rules)
    for text in re.findall(r"(?:^\|.*\n)+", prose(TEXTS[page]), re.MULTILINE):
        heading = text.splitlines()[0]
        assert {len(row) for row in table(text)} == {len(re.findall(r"(?<!\\)\|", heading)) - 1}


@pytest.mark.parametrize("page", TEXTS)
def test_pages_name_no_machine_and_use_the_fields_words(page):
    for words in (MACHINE_PATH, PRIVATE_WORDS):
        assert words.search(TEXTS[page]) is None


def test_code_uses_the_fields_words():
    files = [
        path
        for folder in ("ssdo_gl", "shaders", "tests", "benchmarks")
        for path in (ROOT / folder).rglob("*.*")
        if path.suffix in (".py", ".glsl", ".frag", ".vert") and path != Path(__file__)
    ]
    assert len(files) > 400
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for path in files
        for match in PRIVATE_WORDS.finditer(path.read_text(encoding="utf-8").replace("_", " "))
    ]
    assert found == []


def test_the_helpers_find_what_they_look_for():
    assert anchors("## The first report's table\n```text\n## no\n```\n") == {
        "the-first-reports-table"
    }
    assert table("| a | b |\n|---|--:|\n| `c\\|d` |  |\n\ntext | e |\n") == [["`c\\|d`", ""]]
    assert code_spans("`--a b\\|c`\n```text\n`no`\n```\n") == ["--a b|c"]
    assert MACHINE_PATH.search("see /home/me/file") and not MACHINE_PATH.search("docs/home/x")
    assert PRIVATE_WORDS.search("the truth") and not PRIVATE_WORDS.search("`--truth gi`")
    assert PRIVATE_WORDS.search("out of sight") and not PRIVATE_WORDS.search("line of sight")


def test_the_layout_names_what_the_tree_holds():
    layout = re.search(r"```text\n(.*?)```", section("docs/architecture.md", "Layout"), re.DOTALL)
    assert layout is not None
    inside = set(re.findall(r"^  (\S+)", layout[1], re.MULTILINE))
    package = ROOT / "ssdo_gl"
    modules = [path.relative_to(package) for path in package.rglob("*.py")]
    # A format is a module or a folder, whichever it takes.
    folders = {f"{path.parent.as_posix()}/" for path in modules if len(path.parts) <= 3}
    files = {path.name for path in modules if len(path.parts) == 1}
    assert inside == (folders - {"./"}) | files
    (tests,) = re.findall(r"^tests/ +(.*)", layout[1], re.MULTILINE)
    own = {name.removesuffix("/") for name in re.findall(r"[a-z_]+/", tests)} - {"ssdo_gl"}
    found = {path.parent.name for path in (ROOT / "tests").glob("*/test_*.py")} | {"oracle"}
    assert found - {path.parts[0] for path in modules} == own

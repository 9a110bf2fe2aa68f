"""The house rules that a reader relies on: who imports whom, and how large things get."""

from __future__ import annotations

import ast
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parent.parent / "ssdo_gl"
TESTS = Path(__file__).parent

# Low to high. A unit is a folder, or a file that stands apart from the rest of its folder;
# it imports lower ones only.
LAYERS: tuple[tuple[str, ...], ...] = (
    ("user_error",),
    (
        "resources",
        "math3d",
        "whole_files",
        "toml_text",
        "process",
        "foreign_output",
        "wording",
        "last_made",
        "package_members",
        "version",
        "color",
    ),
    ("settings",),
    ("scene",),
    ("raytracing",),
    ("gpu",),
    ("graph",),
    ("images", "progress"),
    ("passes",),
    ("facts",),
    ("effects",),
    ("planning",),
    ("options",),
    ("render_result",),
    ("shared_scene", "image_requests"),
    ("frame_loop",),
    ("renderer",),
    ("film", "farm"),
    ("headless", "bench", "window"),
    ("serve",),
    ("dispatch",),
    ("cli", "notebook"),
    ("__init__", "__main__"),
)
LEVEL = {unit: level for level, units in enumerate(LAYERS) for unit in units}
# Run without a device, so that wiring and scenes can be tested anywhere.
WITHOUT_OPENGL = ("scene", "graph/graph", "graph/resource", "graph/frame", "settings/settings")

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 70


def modules(folder: Path) -> dict[str, str]:
    """Return source text by name relative to `folder`, e.g. ``scene/camera``."""
    return {
        path.relative_to(folder).with_suffix("").as_posix(): path.read_text(encoding="utf-8")
        for path in sorted(folder.rglob("*.py"))
    }


@cache
def imported(source: str, *, at_run_time: bool = False) -> frozenset[str]:
    """Return every module or name that `source` imports, dotted.

    With `at_run_time`, leave out what only a type checker sees.
    """
    tree = ast.parse(source)
    skipped: set[ast.AST] = set()
    if at_run_time:
        for node in ast.walk(tree):
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                skipped.update(child for item in node.body for child in ast.walk(item))
    names: set[str] = set()
    for node in ast.walk(tree):
        if node in skipped:
            continue
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute, so that these tests can follow them"
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return frozenset(names)


def own(names: frozenset[str], known: set[str]) -> set[str]:
    """Return those of `names` that are modules of the package, as `modules` names them."""
    found = set()
    for name in names:
        parts = name.split(".")
        if parts[0] != "ssdo_gl":
            continue
        for end in range(len(parts), 0, -1):
            path = "/".join(parts[1:end]) or "__init__"
            if path in known or f"{path}/__init__" in known:
                found.add(path)
                break
    return found


def defined(names: frozenset[str], sources: dict[str, str]) -> frozenset[str]:
    """Return `names`, with what a package passes on replaced by where the package takes it from."""
    found = set()
    for name in names:
        package, _, last = name.removeprefix("ssdo_gl.").rpartition(".")
        passed_on = imported(sources.get(f"{package.replace('.', '/')}/__init__", ""))
        found |= {origin for origin in passed_on if origin.endswith(f".{last}")} or {name}
    return frozenset(found)


def unit_of(name: str) -> str:
    """Return the unit that a module belongs to: itself, if `LAYERS` names it, or its folder."""
    return name if name in LEVEL else name.split("/")[0]


def layer_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for every import that does not point down."""
    faults = []
    for name, source in sources.items():
        unit = unit_of(name)
        if unit not in LEVEL:
            faults.append(f"{name} has no layer: add it to LAYERS")
            continue
        for target in sorted(own(imported(source), set(sources))):
            other = unit_of(target)
            if other != unit and LEVEL.get(other, 99) >= LEVEL[unit]:
                faults.append(f"{name} imports {target}, which is not below it")
    return faults


def circle_faults(sources: dict[str, str]) -> list[str]:
    """Return a line for a circle of modules that import each other, if there is one.

    Imports within functions, and those of type checkers alone, count: one reads both modules.
    """
    graph = {}
    for name, source in sources.items():
        targets = own(imported(source), set(sources))
        graph[name] = {t if t in sources else f"{t}/__init__" for t in targets} - {name}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return [" <- ".join(error.args[1])]
    return []


def sibling_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for every pass that imports a pass, and every effect an effect.

    What several of them need stands in a module without a pass or an effect of its own.
    """
    faults = []
    for folder, suffix, allowed in (
        ("passes/", "Pass", ()),
        ("effects/", "Effect", ("effects/effect", "effects/registry")),
    ):
        members = {
            name
            for name, source in sources.items()
            if name.startswith(folder) and name not in allowed and _defines(source, suffix)
        }
        faults += [
            f"{name} imports {target}"
            for name in sorted(members)
            for names in [defined(imported(sources[name]), sources)]
            for target in sorted(own(names, set(sources)) & members - {name})
        ]
    return faults


def _defines(source: str, suffix: str) -> bool:
    """Return whether `source` defines a class that is, or derives from, a `suffix`."""
    return any(
        isinstance(node, ast.ClassDef)
        and (
            node.name.endswith(suffix)
            or any(ast.unparse(base).endswith(suffix) for base in node.bases)
        )
        for node in ast.parse(source).body
    )


def opengl_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for each module that must not need OpenGL but imports it."""
    faults = []
    for start in sources:
        if not start.startswith(tuple(f"{unit}/" for unit in WITHOUT_OPENGL)) and (
            start not in WITHOUT_OPENGL
        ):
            continue
        seen, queue = {start}, [start]
        while queue:
            name = queue.pop()
            names = imported(sources[name], at_run_time=True)
            if any(n.split(".")[0] in ("moderngl", "glfw", "OpenGL") for n in names):
                faults.append(f"{start} needs OpenGL through {name}")
            new = {n for n in own(names, set(sources)) if n in sources} - seen
            seen |= new
            queue += new
    return faults


def inside_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for each import of a sub-folder's insides from outside of it."""
    faults = []
    for name, source in sources.items():
        for target in sorted(own(imported(source), set(sources))):
            folder = target.rpartition("/")[0]
            if "/" in folder and not name.startswith(f"{folder}/"):
                faults.append(f"{name} imports {target}: take it from {folder}")
    return faults


def module_names(sources: dict[str, str]) -> dict[str, list[str]]:
    """Return which modules bear each name; a package's own file bears none."""
    found: dict[str, list[str]] = {}
    for name in sources:
        if not name.endswith("__init__"):
            found.setdefault(name.rpartition("/")[2], []).append(name)
    return found


def class_names(sources: dict[str, str]) -> dict[str, list[str]]:
    """Return which modules define each class or type alias (``CamelCase = ...``)."""
    found: dict[str, list[str]] = {}
    for module, source in sources.items():
        for node in ast.parse(source).body:
            name = node.name if isinstance(node, ast.ClassDef) else ""
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                name = node.targets[0].id
            name = name.lstrip("_")
            is_camel = name[:1].isupper() and "_" not in name
            if is_camel and (len(name) == 1 or not name.isupper()):
                found.setdefault(name, []).append(module)
    return found


def name_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for each name that two modules, or two classes, share."""
    return [
        f"{name} is in {' and '.join(places)}"
        for table in (module_names(sources), class_names(sources))
        for name, places in table.items()
        if len(places) > 1
    ]


def size_faults(sources: dict[str, str]) -> list[str]:
    """Return one line for each file or function that is too long to be read at once."""
    faults = []
    for name, source in sources.items():
        count = len(source.splitlines())
        if count > MAX_FILE_LINES:
            faults.append(f"{name} has {count} lines")
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.FunctionDef):
                count = (node.end_lineno or node.lineno) - node.lineno + 1
                if count > MAX_FUNCTION_LINES:
                    faults.append(f"{name}: {node.name} has {count} lines")
    return faults


def test_imports_point_down():
    assert layer_faults(modules(PACKAGE)) == []


def test_imports_run_in_no_circle():
    assert circle_faults(modules(PACKAGE)) == []


def test_passes_and_effects_do_not_import_their_kind():
    assert sibling_faults(modules(PACKAGE)) == []


def test_scenes_and_graph_do_not_need_opengl():
    assert opengl_faults(modules(PACKAGE)) == []


def test_insides_of_a_folder_are_its_own():
    assert inside_faults(modules(PACKAGE)) == []


def test_names_tell_modules_and_classes_apart():
    assert name_faults(modules(PACKAGE)) == []


@pytest.mark.parametrize("folder", [PACKAGE, PACKAGE.parent / "benchmarks"])
def test_files_and_functions_stay_readable(folder):
    assert size_faults(modules(folder)) == []


def test_test_files_stay_readable():
    """Their functions may hold long tables of cases."""
    assert [
        fault
        for fault in size_faults(modules(TESTS))
        if fault.endswith(" lines") and ":" not in fault
    ] == []


def test_only_math3d_imports_pyrr():
    users = {name for name, source in modules(PACKAGE).items() if "pyrr" in imported(source)}
    assert users == {"math3d"}


def test_oracles_are_independent_of_the_package():
    guilty = [
        name
        for name, source in modules(TESTS / "oracle").items()
        if any(n.split(".")[0] in ("ssdo_gl", "moderngl") for n in imported(source))
    ]
    assert guilty == []


@pytest.mark.parametrize(
    ("check", "sources"),
    [
        (layer_faults, {"scene/a": "from ssdo_gl.gpu.b import c", "gpu/b": ""}),
        (layer_faults, {"scene/a": "def f():\n    import ssdo_gl.gpu.b", "gpu/b": ""}),
        (layer_faults, {"scene/a": "from ssdo_gl import renderer", "renderer": ""}),
        (layer_faults, {"window/a": "from ssdo_gl.bench.b import c", "bench/b": ""}),
        (layer_faults, {"stranger": ""}),
        (layer_faults, {"window/a": "from ssdo_gl import Scene", "__init__": ""}),
        (circle_faults, {"scene/a": "from ssdo_gl.scene.b import c",
                         "scene/b": "def f():\n    from ssdo_gl.scene.a import d"}),
        (circle_faults, {"scene/a": "from ssdo_gl.scene.b import c",
                         "scene/b": "if TYPE_CHECKING:\n    import ssdo_gl.scene.a"}),
        (circle_faults, {"scene/a": "from ssdo_gl.scene.kinds import c",
                         "scene/kinds/__init__": "from ssdo_gl.scene.kinds.b import c",
                         "scene/kinds/b": "from ssdo_gl.scene.a import d"}),
        (sibling_faults, {"passes/a": "from ssdo_gl.passes.b import BPass\nclass APass: ...",
                       "passes/b": "class BPass: ..."}),
        (sibling_faults, {"passes/a": "from ssdo_gl.passes.rays import BPass\nclass APass: ...",
                       "passes/rays/__init__": "from ssdo_gl.passes.rays.b import BPass",
                       "passes/rays/b": "class BPass: ..."}),
        (sibling_faults, {"effects/a": "from ssdo_gl.effects.b import B\nclass A(Effect): ...",
                          "effects/b": "class B(Effect): ..."}),
        (inside_faults, {"scene/load": "from ssdo_gl.scene.formats.obj.mtl import x",
                         "scene/formats/obj/mtl": ""}),
        (opengl_faults, {"scene/a": "import moderngl"}),
        (opengl_faults, {"graph/graph": "from ssdo_gl.graph import x",
                         "graph/x": "import moderngl"}),
        (inside_faults, {"window/a": "from ssdo_gl.window.live.b import c", "window/live/b": ""}),
        (inside_faults, {"window/a": "from ssdo_gl.window.live import b", "window/live/b": ""}),
        (name_faults, {"gpu/a": "", "scene/a": ""}),
        (name_faults, {"gpu/a": "class _Twin: ...", "scene/b": "Twin = int"}),
        (size_faults, {"a": "\n" * (MAX_FILE_LINES + 1)}),
        (size_faults, {"a": "def f():\n" + "    x = 1\n" * MAX_FUNCTION_LINES}),
    ],
)  # fmt: skip
def test_each_rule_finds_its_fault(check, sources):
    assert len(check(sources)) == 1


@pytest.mark.parametrize(
    ("check", "sources"),
    [
        (layer_faults, {"gpu/a": "from ssdo_gl.scene.b import c\nimport numpy", "scene/b": ""}),
        (layer_faults, {"scene/a": "from ssdo_gl.scene.b import c", "scene/b": ""}),
        (circle_faults, {"scene/a": "from ssdo_gl.scene.kinds import b, c",
                         "scene/kinds/__init__": "from ssdo_gl.scene.kinds.b import c",
                         "scene/kinds/b": "import ssdo_gl.scene.d", "scene/d": ""}),
        (sibling_faults, {"passes/a": "from ssdo_gl.passes.b import f\nclass APass: ...",
                       "passes/b": "def f(): ..."}),
        (sibling_faults, {"passes/a": "from ssdo_gl.passes.rays import f\nclass APass: ...",
                       "passes/rays/__init__": "from ssdo_gl.passes.rays.b import BPass\n"
                                               "from ssdo_gl.passes.rays.c import f",
                       "passes/rays/b": "class BPass: ...",
                       "passes/rays/c": "def f(): ..."}),
        (inside_faults, {"scene/formats/toml/a": "from ssdo_gl.scene.formats.obj import x",
                         "scene/formats/obj/__init__": "import ssdo_gl.scene.formats.obj.mtl",
                         "scene/formats/obj/mtl": "from ssdo_gl.scene.formats.model import y",
                         "scene/formats/model": ""}),
        (opengl_faults, {"scene/a": "if TYPE_CHECKING:\n    import moderngl"}),
        (opengl_faults, {"gpu/a": "import moderngl"}),
        (inside_faults, {"window/a": "from ssdo_gl.window.live import b",
                         "window/live/__init__": "", "window/live/c": ""}),
        (inside_faults, {"window/live/a": "from ssdo_gl.window.live.b import c",
                         "window/live/b": ""}),
        (name_faults, {"gpu/a": "class One: ...\nTWO = 1", "scene/b": "TWO = 1\nclass Other: ..."}),
        (name_faults, {"gpu/__init__": "", "scene/__init__": ""}),
        (size_faults, {"a": "\n" * MAX_FILE_LINES}),
    ],
)  # fmt: skip
def test_what_is_allowed_passes(check, sources):
    assert check(sources) == []

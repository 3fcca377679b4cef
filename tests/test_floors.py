"""Who may use whom: imports only go down, in the Rust core, among the crates and in the Python package.

The floors of the Rust core are read from the list at the end of the documentation of ``lib.rs``; those of the Python
package stand here.
"""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).parents[1]
CORE = ROOT / "crates" / "gravcomp" / "src"
PACKAGE = ROOT / "python" / "ravengc"

FLOORS = (
    {"errors", "frozen", "messages"},
    {"disturbances"},
    {"spec"},
    {"_convert", "atomic"},
    {"coordinates", "units"},
    {"_core", "config", "differentiation", "log", "reference", "trajectory"},
    {"batch"},
    {"robot"},
    {"elastic", "resolved_rate", "symbolic"},
    {"ravengc"},
    {"inertial_units", "monitored"},
    {"control", "recordings", "sim"},
    {"targets"},
    {"sensors"},
    {"calibration", "stability"},
    {"identify", "loop", "replay"},
    {"experiments"},
    {"dvrk", "sweep", "track"},
    {"reports"},
    {"cli"},
    {"__main__"},
)
"""Parts of the Python package (modules, or packages with all their modules). A part uses itself and lower floors.

"ravengc" is the front, ``ravengc/__init__.py``: it also opens doors to higher parts, which it imports when asked.
"""

DOORS = {"reference", "sim"}
CRATES = ("gravcomp", "gravcomp-rt", "gravcomp-py")
EXTRAS = {"dask", "distributed", "matplotlib", "mpl_toolkits", "mujoco", "pyarrow", "pymavlink", "rosbags", "viser"}
EXTRAS |= {"clarabel", "scipy", "sympy"}
HEAVY = EXTRAS | {"rich", "xml"}


# The Rust core


def core_modules() -> dict[str, int]:
    """Modules of the core in the order of the list in ``lib.rs``, with their floors."""
    text = re.sub(r"\s*\n//! ?", " ", (CORE / "lib.rs").read_text(encoding="utf-8"))
    listed = re.search(r"of lower floors[^:]*: (?P<floors>0 [^.]*)\.", text)
    assert listed, "the documentation of lib.rs ends with a list of floors"
    floors = [re.match(r"\s*(\d+) (.*)", floor) for floor in listed["floors"].split(";")]
    return {name: int(floor[1]) for floor in floors if floor for name in re.findall(r"`(\w+)`", floor[2])}


def without_comments(source: str) -> str:
    return re.sub(r"//[^\n]*", "", source)


def crate_paths(source: str) -> set[str]:
    """First names of the paths that start at the crate's root, in ``use`` declarations and elsewhere."""
    code = without_comments(source)
    grouped = re.findall(r"\bcrate::\{([^;]*)\};", code)
    inner = chain.from_iterable(re.split(r",(?![^{]*\})", group) for group in grouped)
    names = (re.match(r"\s*(\w+)", name) for name in inner)
    return set(re.findall(r"\bcrate::(\w+)", code)) | {name[1] for name in names if name}


def test_every_core_module_has_a_floor() -> None:
    declared = re.findall(r"^(?:pub )?mod (\w+);", (CORE / "lib.rs").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(core_modules()) == sorted(declared) == sorted({path.stem for path in CORE.glob("*.rs")} - {"lib"})
    assert list(core_modules().values()) == sorted(core_modules().values())


@pytest.mark.parametrize("module", core_modules())
def test_core_modules_use_what_stands_before_them(module: str) -> None:
    """The list is an order: a module uses lower floors, and on its own floor only what is listed before it.

    A macro names its own module, for those who use it.
    """
    order = list(core_modules())
    before = set(order[: order.index(module)])
    assert crate_paths((CORE / f"{module}.rs").read_text(encoding="utf-8")) - {module} <= before


def test_the_core_has_neither_unsafe_code_nor_a_heap() -> None:
    source = (CORE / "lib.rs").read_text(encoding="utf-8")
    assert "#![no_std]" in source
    assert "#![forbid(unsafe_code)]" in source
    for path in CORE.rglob("*.rs"):
        code = without_comments(path.read_text(encoding="utf-8"))
        assert not re.search(r"\b(std::|extern crate|alloc::)", code), path


# The crates


def manifests() -> dict[str, dict[str, dict[str, object]]]:
    parsed = (tomllib.loads(path.read_text(encoding="utf-8")) for path in sorted(ROOT.glob("crates/*/Cargo.toml")))
    return {str(manifest["package"]["name"]): manifest for manifest in parsed}


def test_crates_depend_downwards() -> None:
    assert "gravcomp" in manifests()
    for name, manifest in manifests().items():
        below = set(CRATES[: CRATES.index(name)])
        assert set(manifest["dependencies"]) & set(CRATES) <= below, name


def test_the_core_depends_on_nalgebra_alone() -> None:
    assert set(manifests()["gravcomp"]["dependencies"]) == {"nalgebra"}


# The Python package


def modules() -> dict[str, Path]:
    """Modules by dotted name, the package itself as "ravengc", the others without that prefix."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(parts).removesuffix("__init__").removesuffix(".") or "ravengc"] = path
    return found


def part(module: str) -> str:
    return module.split(".", maxsplit=1)[0]


def floor(name: str) -> int:
    return next(level for level, names in enumerate(FLOORS) if name in names)


def is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def nodes(tree: ast.AST, *, functions: bool = True, types: bool = True) -> Iterator[ast.AST]:
    """All nodes; ``functions`` and ``types`` say whether those in functions and under TYPE_CHECKING count."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not functions:
            continue
        if is_type_checking(node) and not types:
            continue
        yield node
        yield from nodes(node, functions=functions, types=types)


def own_module(name: str, known: set[str]) -> str | None:
    """The module of the package that a dotted name is in, without the prefix "ravengc."."""
    if name == "ravengc":
        return name
    parts = name.removeprefix("ravengc.").split(".") if name.startswith("ravengc.") else []
    inside = (".".join(parts[:length]) for length in range(len(parts), 0, -1))
    return next((candidate for candidate in inside if candidate in known), "ravengc") if parts else None


def dotted_imports(node: ast.AST) -> list[str]:
    """Dotted names that a statement imports; an attribute of the package itself counts as an import."""
    match node:
        case ast.Import():
            return [alias.name for alias in node.names]
        case ast.ImportFrom():
            assert node.level == 0, "imports are absolute"
            return [f"{node.module}.{alias.name}" for alias in node.names]
        case ast.Attribute(value=ast.Name(id="ravengc"), attr=name):
            return [f"ravengc.{name}"]
        case _:
            return []


def imports(module: str) -> set[str]:
    """Modules of the package, and the compiled core, that a module imports, also inside functions and for types.

    The front's doors are left out: it imports them when they are asked for. So is, for a module, itself.
    """
    tree = ast.parse(modules()[module].read_text(encoding="utf-8"))
    known = {*modules(), "_core"}
    names = chain.from_iterable(map(dotted_imports, nodes(tree)))
    found = {own_module(name, known) for name in names} - {None, module}
    return found - DOORS if module == "ravengc" else found


def test_every_part_has_one_floor() -> None:
    listed = list(chain.from_iterable(FLOORS))
    assert sorted(listed) == sorted({*map(part, modules()), "_core"})
    assert len(listed) == len(set(listed))


@pytest.mark.parametrize("module", modules())
def test_python_imports_go_down(module: str) -> None:
    own = part(module)
    for imported in imports(module):
        assert part(imported) == own or floor(part(imported)) < floor(own), f"{module} imports {imported}"


def test_python_modules_import_in_no_circle() -> None:
    order = TopologicalSorter({module: imports(module) for module in modules()}).static_order()
    assert set(order) == {*modules(), "_core"}


def test_the_binding_imports_only_what_is_below_it() -> None:
    sources = (path.read_text(encoding="utf-8") for path in (ROOT / "crates" / "gravcomp-py" / "src").glob("*.rs"))
    imported = set(re.findall(r"import\((?:py, )?\"ravengc\.(\w+)\"", "\n".join(sources)))
    assert "errors" in imported
    assert all(floor(name) < floor("_core") for name in imported)


@pytest.mark.parametrize("module", modules())
def test_extras_are_imported_where_they_are_used(module: str) -> None:
    tree = ast.parse(modules()[module].read_text(encoding="utf-8"))
    at_import = chain.from_iterable(map(dotted_imports, nodes(tree, functions=False, types=False)))
    assert not {name.split(".")[0] for name in at_import} & EXTRAS


def loaded_by(*names: str) -> set[str]:
    """Top-level packages that a fresh interpreter has after importing ``names``."""
    program = f"import {', '.join(names)}; import json, sys; print(json.dumps(sorted(sys.modules)))"
    result = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)  # noqa: S603
    return {name.split(".")[0] for name in json.loads(result.stdout)}


def test_the_package_imports_nothing_heavy() -> None:
    assert not loaded_by("ravengc") & HEAVY


def test_no_module_imports_an_extra() -> None:
    every = [f"ravengc.{name}" for name in modules() if name not in {"ravengc", "__main__"}]
    assert not loaded_by("ravengc", *every) & EXTRAS

"""An inner kernel has no entry for Python: only kernels of its own file may call it."""

import ast
import re
from functools import cache
from typing import NamedTuple

from architecture.sources import FILES, ROOT, for_each, name, tree

COMPILED = {
    *("entry_kernel", "kernel", "inner_kernel", "kernel_on_demand"),
    *("pointer_kernel", "row_kernel", "switch_kernel"),
}
OUTSIDE = [
    path for folder in ("tests", "benchmarks", "examples", "docs") for path in sorted((ROOT / folder).rglob("*.py"))
]


class Kernel(NamedTuple):
    """A compiled function, its decorator, and the lines outside of all kernels of the file that name it."""

    name: str
    kind: str
    outside: tuple[int, ...]


@cache
def compiled(path) -> list[Kernel]:
    """Return the compiled functions of a file."""
    nodes = list(ast.walk(tree(path)))
    kinds = {
        node: ast.unparse(decorator).split("(")[0]
        for node in nodes
        if isinstance(node, ast.FunctionDef)
        for decorator in node.decorator_list
        if ast.unparse(decorator).split("(")[0] in COMPILED
    }
    within = {id(node) for kernel in kinds for node in ast.walk(kernel)}
    names = [node for node in nodes if isinstance(node, ast.Name) and id(node) not in within]
    return [
        Kernel(kernel.name, kind, tuple(node.lineno for node in names if node.id == kernel.name))
        for kernel, kind in kinds.items()
    ]


@cache
def text(path):
    return path.read_text(encoding="utf-8")


WITH_KERNELS = [path for path in FILES if re.search(r"^\s*@(inner_)?kernel\b", text(path), re.MULTILINE)]


@for_each(WITH_KERNELS)
def test_inner_kernels_are_called_by_kernels_only(path):
    for function, kind, outside in compiled(path):
        if not function.startswith("_"):
            assert kind != "inner_kernel", f"{function} has a public name: other files may call it from Python"
        elif kind == "inner_kernel":
            assert not outside, f"{function} is called from Python, line {outside}: it needs @kernel"
        elif kind == "kernel":
            assert outside or elsewhere(path, function), f"{function} is called by kernels only: @inner_kernel"


@cache
def mentioning():
    """Return the files in which each name stands: most stand in one, so that few are searched."""
    found = {}
    for path in (*FILES, *OUTSIDE):
        for word in set(re.findall(r"\w+", text(path))):
            found.setdefault(word, []).append(path)
    return found


def elsewhere(path, function):
    """Return the files that take a private function of a file."""
    used = re.compile(rf"import[^\n]*\b{function}\b|\b{path.stem}\.{function}\b")
    return [other for other in mentioning()[function] if other != path and used.search(text(other))]


@for_each(WITH_KERNELS)
def test_inner_kernels_stay_in_their_file(path):
    inner = [kernel.name for kernel in compiled(path) if kernel.kind == "inner_kernel"]
    found = {function: [name(other) for other in elsewhere(path, function)] for function in inner}
    assert not any(found.values()), found

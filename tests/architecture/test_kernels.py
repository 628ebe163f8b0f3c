"""An inner kernel has no entry for Python: only kernels may call it, of its own file if its name is private."""

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
        if kind == "inner_kernel":
            assert not outside, f"{function} is called from Python, line {outside}: it needs @kernel"
            others = elsewhere(path, function) if not function.startswith("_") else ()
            found = [f"{name(other)}, line {line}" for other in others for line in named_in_python(other, function)]
            assert not found, f"{function} is called from Python, {found}: it needs @kernel"
        elif kind == "kernel" and function.startswith("_"):
            assert outside or elsewhere(path, function), f"{function} is called by kernels only: @inner_kernel"


def named_in_python(path, function) -> list[int]:
    """Return the lines of a file that name a function or take it of a module, outside of kernels."""
    nodes = list(ast.walk(tree(path)))
    within = {
        id(node)
        for kernel in nodes
        if isinstance(kernel, ast.FunctionDef)
        and any(ast.unparse(decorator).split("(")[0] in COMPILED for decorator in kernel.decorator_list)
        for node in ast.walk(kernel)
    }
    return [
        node.lineno
        for node in nodes
        if id(node) not in within and function in (getattr(node, "id", None), getattr(node, "attr", None))
    ]


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
def test_private_inner_kernels_stay_in_their_file(path):
    inner = [one.name for one in compiled(path) if one.kind == "inner_kernel" and one.name.startswith("_")]
    found = {function: [name(other) for other in elsewhere(path, function)] for function in inner}
    assert not any(found.values()), found

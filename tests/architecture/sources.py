"""The source tree as the architecture tests see it: files, rooms, imports."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "flexmb"
FILES = sorted(PACKAGE.rglob("*.py"))


def name(path: Path) -> str:
    """Return the path relative to the repository, for messages and test ids."""
    return path.relative_to(ROOT).as_posix()


def for_each(paths: Iterable[Path]) -> Callable[[Callable[[Path], None]], Callable[[], None]]:
    """Return a decorator that makes one test of a check of one file; it tells all files that fail.

    One test for each of a thousand files takes three times as long: most of it in what surrounds a test.
    """
    paths = tuple(paths)

    def decorated(check: Callable[[Path], None]) -> Callable[[], None]:
        def test() -> None:
            assert paths, "no files found"
            failures = []
            for path in paths:
                try:
                    check(path)
                except AssertionError as error:
                    failures.append(f"{name(path)}: {error}")
            assert not failures, "\n".join(failures)

        test.__name__, test.__qualname__, test.__doc__ = check.__name__, check.__qualname__, check.__doc__
        test.__module__ = check.__module__
        return test

    return decorated


def dotted(path: Path) -> str:
    """Return the name by which a file is imported: "flexmb.math.kernel", "flexmb.math" for the door of a room."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def room(path: Path) -> str:
    """Return the room a file belongs to: "math", "errors", or "" for the package's own face."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return "" if parts[0] == "__init__" else "cli" if parts[0] == "__main__" else parts[0]


class Source(NamedTuple):
    """What is asked of a file; its tree would take a hundred times the memory of all of this.

    imports   : (dotted module, line) of every import
    functions : (name, first and last line, number of lines of its docstring) of every function
    """

    imports: tuple[tuple[str, int], ...]
    functions: tuple[tuple[str, int, int, int], ...]
    docstring: str


def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def _docstring_lines(node: ast.FunctionDef) -> int:
    first = node.body[0]
    return (first.end_lineno or first.lineno) - first.lineno + 1 if ast.get_docstring(node) is not None else 0


def _statements(node: ast.AST) -> Iterator[ast.stmt]:
    """Yield all statements of a tree, those in others included: a fifth of the time of a walk through expressions."""
    for name in ("body", "handlers", "orelse", "finalbody", "cases"):
        for one in getattr(node, name, ()):
            if isinstance(one, ast.stmt):
                yield one
            yield from _statements(one)


@cache
def source(path: Path) -> Source:
    parsed = tree(path)
    nodes = list(_statements(parsed))
    functions = [
        (node.name, node.lineno, node.end_lineno or node.lineno, _docstring_lines(node))
        for node in nodes
        if isinstance(node, ast.FunctionDef)
    ]
    return Source(tuple(_imports(path, nodes)), tuple(functions), ast.get_docstring(parsed) or "")


def is_module(dotted: str) -> bool:
    """Is `dotted` ("flexmb.math.kernel") a module or a package of flexmb (not a name in one)?"""
    path = ROOT.joinpath(*dotted.split("."))
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


def imports(path: Path) -> tuple[tuple[str, int], ...]:
    """Return (dotted module, line) of every import in a file, inside functions too."""
    return source(path).imports


def _imports(path: Path, nodes: list[ast.AST]) -> Iterator[tuple[str, int]]:
    """Yield (dotted module, line) of every import.

    ``from flexmb import fem`` gives flexmb.fem, ``from flexmb import Model`` gives flexmb.
    """
    here = path.relative_to(ROOT).with_suffix("").parts
    package = here[:-1]
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            whence = ".".join((*above, *filter(None, [node.module])))
            for alias in node.names:
                deeper = f"{whence}.{alias.name}"
                yield (deeper if whence.startswith("flexmb") and is_module(deeper) else whence), node.lineno

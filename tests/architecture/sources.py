"""The source tree as the architecture tests see it: files, rooms, imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "flexmb"
FILES = sorted(PACKAGE.rglob("*.py"))


def name(path: Path) -> str:
    """Return the path relative to the repository, for messages and test ids."""
    return path.relative_to(ROOT).as_posix()


def dotted(path: Path) -> str:
    """Return the name by which a file is imported: "flexmb.math.kernel", "flexmb.math" for the door of a room."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def room(path: Path) -> str:
    """Return the room a file belongs to: "math", "errors", or "" for the package's own face."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return "" if parts[0] == "__init__" else "cli" if parts[0] == "__main__" else parts[0]


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def is_module(dotted: str) -> bool:
    """Is `dotted` ("flexmb.math.kernel") a module or a package of flexmb (not a name in one)?"""
    path = ROOT.joinpath(*dotted.split("."))
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


def imports(path: Path) -> Iterator[tuple[str, int]]:
    """Yield (dotted module, line) of every import in a file, those inside functions too.

    ``from flexmb import fem`` gives flexmb.fem, ``from flexmb import Model`` gives flexmb.
    """
    here = path.relative_to(ROOT).with_suffix("").parts
    package = here[:-1]
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            source = ".".join((*above, *filter(None, [node.module])))
            for alias in node.names:
                deeper = f"{source}.{alias.name}"
                yield (deeper if source.startswith("flexmb") and is_module(deeper) else source), node.lineno

"""Counts of what decision 0020 is about, of any checkout: `python tests/architecture/counts.py [folder]`.

By regular expressions and syntax trees. Complexity is 1 and one for every `if`, loop, `except`, conditional expression,
comprehension, each condition in it, and each `and` or `or`; functions inside a function count for it.
"""

import ast
import re
import sys
from pathlib import Path


def complexity(function: ast.AST) -> int:
    """Return the number of decisions of a function and one."""
    found = 1
    for node in ast.walk(function):
        if isinstance(node, ast.If | ast.For | ast.While | ast.ExceptHandler | ast.IfExp):
            found += 1
        elif isinstance(node, ast.comprehension):
            found += 1 + len(node.ifs)
        elif isinstance(node, ast.BoolOp):
            found += len(node.values) - 1
    return found


def functions(path: Path):
    """Yield name, parameters without self, lines, lines without docstring, and complexity of all functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            given = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
            own = [one for one in given if one.arg not in ("self", "cls")]
            first = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            lines = node.end_lineno - first + 1
            told = node.body[0].end_lineno - node.body[0].lineno + 1 if ast.get_docstring(node) else 0
            yield node.name, len(own), lines, lines - told, complexity(node)


def main() -> None:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    files, pages = sorted((root / "flexmb").rglob("*.py")), sorted((root / "docs").rglob("*.md"))
    tests = sorted((root / "tests").rglob("*.py"))

    def lines(pattern: str, paths: list[Path] = files) -> int:
        sought = re.compile(pattern)
        return sum(bool(sought.search(line)) for p in paths for line in p.read_text(encoding="utf-8").splitlines())

    all_functions = [one for path in files for one in functions(path)]
    rows = {
        "files of the package": len(files),
        "files of more than 400 lines": sum(len(p.read_text(encoding="utf-8").splitlines()) > 400 for p in files),
        "functions": len(all_functions),
        "namedtuple declarations": lines(r'namedtuple\(\s*"'),
        "places of coefficients, weights": lines(r"\b(coefficients|weights)\[[0-9]\]"),
        "    of these records": lines(r"\bweights\[0\]"),
        "places of energy": lines(r"\benergy\[[0-9]\]"),
        "    of these records of energy": lines(r"\benergy\[0\]"),
        "places in packed rows of tree": lines(r"\[[A-Z_]{3,} \+ [^\]]*\]", [p for p in files if "tree" in p.parts]),
        "hasattr": lines(r"\bhasattr\("),
        "fmt: skip": lines("fmt: skip", [*files, *tests]),
        '"that of", "those of"': lines(r"\b(that|those) of\b", [*files, *pages]),
        **{f"functions with more than {n} parameters": sum(f[1] > n for f in all_functions) for n in (6, 12, 15)},
        "functions of more than 70 lines": sum(f[2] > 70 for f in all_functions),
        "    without docstring": sum(f[3] > 70 for f in all_functions),
        "functions of complexity above 25": sum(f[4] > 25 for f in all_functions),
    }
    for name, count in rows.items():
        print(f"{name:44}{count:7}")


if __name__ == "__main__":
    main()

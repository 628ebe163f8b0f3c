"""`Foreign`: the name of a Python function that came with a file, and may not be imported."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from flexmb.errors import ModelError

__all__ = ["Foreign", "imported"]


class Foreign(str):
    """A text "module:function" from a model file that was read without trust in its author.

    It keeps its type in copies of the part, in processes and in files. Code that would import it checks the type.
    """

    __slots__ = ()


def imported(function: Any, title: str, field: str = "function") -> Callable[..., Any]:
    """Return a function, imported if it is named as "module:function"; ModelError if it may or can not be."""
    if not isinstance(function, str):
        return function
    if isinstance(function, Foreign):
        raise ModelError(
            title,
            found=f"{field} = {str(function)!r}: the file names Python code to be imported and run",
            expected="a file whose author you know",
            remedy="If you do, and know what the function does, give --trust, or load_model(path, trust=True)",
        )
    module, _, name = function.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ModelError(
            title,
            found=f"{field} = {function!r} ({error})",
            expected="'module:function' of a module that can be imported",
            remedy=_remedy(module, error),
        ) from error


def _remedy(module: str, error: Exception) -> str:
    """Return what to do; where the file of the module lies in the current folder, which commands do not search."""
    file = f"{module.partition('.')[0]}.py"
    if isinstance(error, ModuleNotFoundError) and error.name == module.partition(".")[0] and Path(file).is_file():
        return f"'{file}' lies in the current folder, which is not on Python's path: begin with PYTHONPATH=."
    return "Check both names, and that the module is on Python's path (PYTHONPATH=folder adds a folder)"

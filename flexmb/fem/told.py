"""Warnings of meshes and FE models: given to the user once, and kept with what they speak of.

What is told on the way from a file to an FE model is repeated by the report of its reduction, which is read by people
who have not seen the terminal.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.mesh import Mesh, MeshWarning

__all__ = ["keeping_warnings", "tell"]

PACKAGE = str(Path(__file__).parents[1])
P = ParamSpec("P")
Made = TypeVar("Made", bound=Mesh | FEModel)

_heard: ContextVar[tuple[list[str], ...]] = ContextVar("heard", default=())


def tell(text: str) -> None:
    """Give a MeshWarning at the line of the user, and keep its text with what is being made."""
    for texts in _heard.get():
        texts.append(text)
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and _inside(frame.f_code.co_filename):
        depth, frame = depth + 1, frame.f_back
    warnings.warn(text, MeshWarning, stacklevel=depth + 1)


def _inside(file: str) -> bool:
    return file.startswith(PACKAGE) or file.endswith("contextlib.py")


@contextmanager
def _listening() -> Iterator[list[str]]:
    texts: list[str] = []
    before = _heard.set((*_heard.get(), texts))
    try:
        yield texts
    finally:
        _heard.reset(before)


def keeping_warnings(make: Callable[P, Made]) -> Callable[P, Made]:
    """Let a function keep what it tells in the `warnings` of the mesh or FE model that it returns.

    Those of meshes and FE models among its arguments go on with it. Not by the filters of the module `warnings`, which
    show a text once only.
    """

    @wraps(make)
    def made(*args: P.args, **kwargs: P.kwargs) -> Made:
        with _listening() as texts:
            out = make(*args, **kwargs)
        given = [a for a in (*args, *kwargs.values()) if isinstance(a, Mesh | FEModel)]
        before = [text for a in given for text in a.warnings]
        return replace(out, warnings=tuple(dict.fromkeys([*before, *out.warnings, *texts])))

    return made

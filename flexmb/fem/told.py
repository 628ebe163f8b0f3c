"""Warnings of meshes and FE models: given to the user once, and kept with what they speak of.

What is told on the way from a file to an FE model is repeated by the report of its reduction, which is read by people
who have not seen the terminal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import ParamSpec, TypeVar

from flexmb import told
from flexmb.fem.fe_model import FEModel
from flexmb.fem.meshes.mesh import Mesh, MeshWarning

__all__ = ["keeping_warnings", "tell"]

P = ParamSpec("P")
Made = TypeVar("Made", bound=Mesh | FEModel)


def tell(text: str) -> None:
    """Give a MeshWarning at the line of the user, and keep its text with what is being made."""
    told.tell(text, MeshWarning)


def keeping_warnings(make: Callable[P, Made]) -> Callable[P, Made]:
    """Let a function keep what it tells in the `warnings` of the mesh or FE model that it returns.

    Those of meshes and FE models among its arguments go on with it. Not by the filters of the module `warnings`, which
    show a text once only.
    """

    @wraps(make)
    def made(*args: P.args, **kwargs: P.kwargs) -> Made:
        with told.listening() as heard:
            out = make(*args, **kwargs)
        texts = [text for category, text in heard if category is MeshWarning]
        given = [a for a in (*args, *kwargs.values()) if isinstance(a, Mesh | FEModel)]
        before = [text for a in given for text in a.warnings]
        return replace(out, warnings=tuple(dict.fromkeys([*before, *out.warnings, *texts])))

    return made

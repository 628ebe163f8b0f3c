"""Parameters that an assembly takes from the file around it (``inherit = true``)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flexmb.errors import FlexmbError
from flexmb.io.file_parameters import resolve
from flexmb.told import tell

__all__ = ["inherited"]

SAME = 1e-9
"""Relative difference of two values below which they are one."""


def inherited(
    tables: Mapping[str, Any],
    file: str,
    around: Mapping[str, Any],
    stated: Mapping[str, Any],
    explicit: Mapping[str, Any],
    where: str,
) -> dict[str, Any]:
    """Return the parameters of an assembly: its own names with the values of the file around, and the explicit ones.

    A name for which both files have formulas of their own may mean two things: where the values differ, a warning says
    so. A load share was once the angle of a motor in this way.

    Parameters
    ----------
    tables : mapping
        Of the assembly's file.
    file : str
        Its name.
    around, stated : mapping
        Parameters of the file around: their values, and as they are written there.
    explicit : mapping
        Those in the table ``parameters`` of the assembly.
    where : str
        The assembly, for messages.
    """
    own = tables.get("parameters", {})
    given = {**{name: value for name, value in around.items() if name in own}, **explicit}
    doubtful = [name for name in given if name not in explicit and _differ(_formula(own[name]), _formula(stated[name]))]
    if not doubtful:
        return given
    try:
        values = resolve(tables, {name: value for name, value in given.items() if name not in doubtful}, file)
    except FlexmbError:  # they need what they inherit
        return given
    for name in doubtful:
        if not _same(values[name], given[name]):
            tell(
                f"{where}: inherit = true gives '{name}' of {file} the value {given[name]!r} of the file around it, "
                f"where {file} itself calculates {values[name]!r} ({name} = {own[name]!r}). If both mean the same, "
                f'state it: parameters = {{ {name} = "= {name}" }}; if not, choose another name in one of the files.'
            )
    return given


def _formula(written: Any) -> str | None:
    """Return a formula without spaces; None for a number, a text or a list."""
    return "".join(written.split()) if isinstance(written, str) and written.lstrip().startswith("=") else None


def _differ(own: str | None, other: str | None) -> bool:
    return own is not None and other is not None and own != other


def _same(one: Any, other: Any) -> bool:
    try:
        return bool(np.allclose(np.asarray(one, float), np.asarray(other, float), rtol=SAME, atol=0.0))
    except (TypeError, ValueError):  # texts, or lists of other lengths
        return bool(one == other)

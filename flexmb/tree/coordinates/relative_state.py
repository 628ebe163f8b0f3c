"""`RelativeState`: a state in joint coordinates, and numbers for it, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError
from flexmb.model.described import is_number

__all__ = ["RelativeState", "checked_numbers", "checked_time", "require_axes"]


@dataclass(frozen=True, eq=False)
class RelativeState:
    """A state in relative coordinates.

    Parameters
    ----------
    q : (nq,), rad, m, Euler parameters, modal coordinates
    v : (nv,), rad/s, m/s, modal rates
    a : (nv,), rad/s2, m/s2
    t : float, s
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    t: float = 0.0


def checked_numbers(given: Mapping[str, tuple[Any, tuple[str, ...]]]) -> list[np.ndarray]:
    """Return arrays of finite numbers, one for each label; what is not given is zero.

    Parameters
    ----------
    given : mapping of name to (numbers or None, labels)

    Raises
    ------
    ModelError
        If there are more or fewer numbers than labels, or one is not finite.
    """
    out = []
    for name, (x, labels) in given.items():
        x = np.zeros(len(labels)) if x is None else _numbers(name, x)
        if x.shape != (len(labels),):
            raise ModelError(
                "JointTree",
                found=f"{name} has the shape {x.shape}",
                expected=f"({len(labels)},): {', '.join(labels)}",
                remedy="Give one number for each coordinate",
            )
        bad = np.flatnonzero(~np.isfinite(x))
        if len(bad):
            raise ModelError(
                "JointTree",
                found=f"{name} has {x[bad[0]]} for '{labels[bad[0]]}'",
                expected="finite numbers",
                remedy="Look at where these numbers come from",
            )
        out.append(x)
    return out


def _numbers(name: str, given: Any) -> np.ndarray:
    """Return an array of its own of what is given; ModelError if it is no array of real numbers."""
    try:
        return np.array(given, float)
    except (TypeError, ValueError):
        raise ModelError(
            "JointTree",
            found=f"{name} = {given!r:.60}",
            expected="real numbers",
            remedy="Give one number for each coordinate",
        ) from None


def checked_time(t: Any) -> float:
    """Return a time, s; ModelError if it is no finite number."""
    if not is_number(t) or not np.isfinite(t):
        raise ModelError(
            "JointTree", found=f"t = {t!r:.60}", expected="a time in s", remedy="Leave it out for the time zero"
        )
    return float(t)


def require_axes(q: np.ndarray, places: np.ndarray, names: tuple[str, ...]) -> None:
    """Raise ModelError if Euler parameters among coordinates q (nq,), at `places` (n, 4), are all zero."""
    empty = np.flatnonzero(~np.any(q[places], axis=1))
    if len(empty):
        first = names[int(places[empty[0], 0])]
        raise ModelError(
            "JointTree",
            found=f"the Euler parameters from '{first}' on are all zero",
            expected="four numbers that tell axes: (1, 0, 0, 0) does not turn",
            remedy="Begin with tree.start.q",
        )

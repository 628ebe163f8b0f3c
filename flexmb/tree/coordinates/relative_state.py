"""`RelativeState`: a state in joint coordinates, and numbers for it, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError

__all__ = ["RelativeState", "checked_numbers"]


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
        x = np.zeros(len(labels)) if x is None else np.array(x, float)
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

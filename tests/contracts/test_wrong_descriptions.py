"""Every field of every public description is given values of a wrong kind: they are used, or refused by a message.

Nothing but a FlexmbError may come out, and nothing may end the process. What is accepted is used as users would.
"""

import warnings

import numpy as np
import pytest
from contracts.every_description import DESCRIPTIONS, changed
from contracts.test_messages import INSIDE

from flexmb.errors import FlexmbError

WRONG = (
    *(None, float("nan"), -1, 10**400, 1e308, True, 1j, "", "no such", "\0", b"bytes", (), {}, [1, 2], [[1, 2], [3]]),
    *({"x": object()}, {1: 2}, np.array([1.0, 2.0]), np.array("a"), np.full((2, 2), -1.0), np.array([None, 1], object)),
    *(object(), lambda x: x, int, [object()], range(3), {1}, [b"a"]),
)
SLOW = {"parts.MeshFile", "parts.Stretch", "parts.Part", "OrthotropicMaterial", "LoadSteps", "ArcLength"}
"""These read a mesh, reduce a body or follow a path many times."""


def complaint(description, field, value) -> str:
    """Return what is said against a value, or "" if it is taken."""
    try:
        made = description.make(**changed(description, field, value))
        repr(made)
        description.use(made)
    except FlexmbError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in DESCRIPTIONS])
@pytest.mark.parametrize("turn", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_wrong_values(name, turn, tmp_path, monkeypatch):
    """Every second value for each field, and the others for the next one; the rest is a long test."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path))
    description = DESCRIPTIONS[name]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        description.use(description.make(**description.fields))
        told = [
            (field, complaint(description, field, value))
            for k, field in enumerate(description.fields)
            for value in WRONG[(k + turn) % 2 :: 2]
        ]
    inside = [(field, text) for field, text in told if INSIDE.search(text) or len(text) > 3000]
    assert not inside
    refused = sum(bool(text) for _, text in told)
    assert refused >= len(told) // 2

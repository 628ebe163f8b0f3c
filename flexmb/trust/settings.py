"""Integrators as a solution remembers them, and other settings that must give the same answers."""

from __future__ import annotations

import ast
from dataclasses import replace
from typing import Any

from flexmb import integrate, tree
from flexmb.errors import ModelError
from flexmb.model.methods import is_integrator

__all__ = ["another", "of_solution", "tighter"]

TENTH = 0.1
LEAST = 1e-13
"""Relative tolerance below which rounding decides."""
ROOT = 10.0**0.5


def of_solution(solution, given: Any = None) -> Any:
    """Return the integrator of a run: the one that is given, or that its statistics name; None if neither is known."""
    if given is not None:
        if not is_integrator(given):
            raise ModelError(
                "verify",
                found=f"integrator = {given!r}",
                expected="the integrator by which the solution was made, such as GeneralizedAlpha(rtol=1e-5)",
                remedy="Give the object itself, or leave it out: a solution of `simulate` knows its integrator",
            )
        return given
    text = solution.statistics.get("integrator")
    try:
        made = None if text is None else _made(ast.parse(str(text), mode="eval").body)
    except (SyntaxError, ValueError, TypeError, ModelError, AttributeError, RecursionError):
        return None
    return made if is_integrator(made) else None


def _made(node: ast.expr) -> Any:
    """Return the value of a literal or of a call of an integrator or formulation by its name, as `repr` writes it."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        room = next((room for room in (integrate, tree) if node.func.id in room.__all__), None)
        if room is None or node.args:
            raise ValueError(node.func.id)
        fields = {keyword.arg: _made(keyword.value) for keyword in node.keywords if keyword.arg}
        return getattr(room, node.func.id)(**fields)
    return ast.literal_eval(node)


def tighter(integrator: Any) -> tuple[Any, str]:
    """Return the integrator with a tenth of its tolerances, or a third of its fixed step, and what that is."""
    if getattr(integrator, "step", None) is not None:
        return replace(integrator, step=integrator.step / ROOT), f"step {integrator.step / ROOT:.3g} s"
    changes = {
        name: max(LEAST, TENTH * value)
        for name in ("rtol", "atol")
        if (value := getattr(integrator, name, None)) is not None
    }
    return replace(integrator, **changes), ", ".join(f"{name} {value:.2g}" for name, value in changes.items())


def another(integrator: Any) -> Any:
    """Return an integrator of another family at the same tolerance: multistep for one-step methods, else one-step."""
    rtol = max(LEAST, getattr(integrator, "rtol", 1e-6))
    if isinstance(integrator, integrate.IDA):
        return integrate.GeneralizedAlpha(rtol=rtol)
    return integrate.IDA(rtol=min(rtol, 1e-6), atol=1e-2 * min(rtol, 1e-6))

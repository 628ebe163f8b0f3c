"""Checks of a phase at samples: its equations, constraints, and the laws of rigid contacts."""

from __future__ import annotations

from typing import Any

from flexmb.results import Solution
from flexmb.trust.balance import unexplained
from flexmb.trust.contact_laws import in_the_middle, lawfulness, regular_steps
from flexmb.trust.levels import Residual, constraint_levels
from flexmb.trust.verification import Check

__all__ = ["constraint_check", "of_equations", "of_impulses"]

HELD = 1e-2
"""Limit of open constraints, relative to the limit of the answers."""


def of_equations(phase, system, samples, within: float, notes: list[str]) -> list[Check]:
    """Return what forces leave unexplained of the motion at samples; notes get the bodies that were left out."""
    balances, skipped = unexplained(phase, system, samples)
    notes += [f"no equations from energies of {text}" for text in skipped]
    return [
        Check(
            name="equations of motion",
            share=b.worst,
            limit=within,
            worst=f"body '{b.body}' at {b.at:.6g} s: share of forces that nothing explains",
        )
        for b in balances[:1]
    ]


def constraint_check(found: Residual, within: float) -> Check:
    """Return the check of a level of constraints."""
    return Check(
        name=f"constraints, {found.level}",
        share=found.share,
        limit=within if found.level == "acceleration" else HELD * within,
        worst=f"{found.equation}: {found.value:.2g} at {found.at:.6g} s",
    )


def of_impulses(solution: Solution, number: int, samples, used: Any, within: float) -> tuple[list[Check], list[str]]:
    """Return the checks of a phase with rigid contacts, at the middles of the steps that end at samples, and what was
    left out.
    """
    phase, system = solution.phases[number], solution.series(number).system
    steps, notes, found = [k for k in samples if k > 0], [], []
    length = getattr(used, "step", None)
    if length is None or not steps:
        return [], ["no laws of contact: the step is not known, or there is no sample after the first"]
    middle, _, _ = in_the_middle(phase, system, steps, length)
    every = list(range(len(steps)))
    found += of_equations(middle, system, every, within, notes)
    levels = {
        **{r.level: r for r in constraint_levels(phase, system, steps) if r.level != "acceleration"},
        **{r.level: r for r in constraint_levels(middle, system, every) if r.level == "acceleration"},
    }
    found += [constraint_check(r, within) for r in levels.values()]
    if not regular_steps(solution, length):
        return found, [*notes, "no laws of contact: steps were shortened or divided, and their lengths are not known"]
    laws = lawfulness(phase, system, steps, length, within)
    notes += [laws.skipped] if laws.skipped else []
    for name, share, at, text in (
        ("laws of contact", laws.force, laws.at[0], "share of the resultants that no lawful forces explain"),
        ("surfaces that touch still approach", laws.approach, laws.at[1], "relative to what changes in a step"),
        ("penetration", laws.depth, laws.at[2], "relative to the smallest surface"),
    ):
        found.append(Check(name=name, share=share, limit=within, worst=f"at {at:.6g} s, {text}"))
    return found, notes

"""Spells of contact: how many steps lie between the begin and the end of a contact, and what speed changed in them."""

from __future__ import annotations

import numpy as np

from flexmb.math.impact_steps import SLOWLY
from flexmb.math.kernel import inner_kernel, kernel
from flexmb.math.structures import Record

__all__ = ["POWER", "Spell", "follow_spell", "forget_spell"]

POWER = 2
"""The error of a rebound falls with this power of the steps within a contact: its begin and end lie within steps."""
FELT = 0.02
"""Share of the speed of an impact by which a step has to change it to count among those that resolve it."""


class Spell(Record):
    """The present contact of a gap, and of those that have ended the one that is resolved worst.

    Changes are of the rate of the gap: m/s, or rad/s of angles.
    """

    steps: float
    """within the contact that is closed now, with parts of steps; 0: open, or closed since the start"""
    span: float
    """s, how long it is closed"""
    change: float
    """sum of the changes of speed in it"""
    jump: float
    """largest change of speed in one of its steps"""
    longest: float
    """s, of the whole steps that have changed it: one that begins far before the contact does not resolve it"""
    worst_steps: float
    """of the contact with the largest error; 0: none has ended yet"""
    worst_span: float
    worst_change: float
    largest_change: float
    """of all contacts that have ended"""
    ended: float
    """contacts that have ended"""
    deepest: float
    """m or rad, below a gap of zero at the end of a step, since the last look"""


@kernel
def forget_spell(spell):
    """Of a gap that is not there now nothing is known."""
    spell.steps, spell.span, spell.change, spell.jump, spell.longest = 0.0, 0.0, 0.0, 0.0, 0.0


@inner_kernel
def _end_spell(spell, little):
    """Compare a contact that has ended with those before, if it has changed the speed by more than is little.

    Of steps of different lengths those count in which the speed changes: in one of n equal ones it changes by up to
    sin(pi/2n) of the whole, if the force is a half-wave.
    """
    if spell.change > little:
        steps = min(spell.steps, 0.5 * np.pi / np.arcsin(min(1.0, spell.jump / spell.change)))
        if spell.longest > 0.0:
            steps = min(steps, spell.span / spell.longest)
        spell.ended += 1.0
        spell.largest_change = max(spell.largest_change, spell.change)
        error, worst = spell.change / steps**POWER, 0.0
        if spell.worst_steps > 0.0:
            worst = spell.worst_change / spell.worst_steps**POWER
        if error > worst:
            spell.worst_steps, spell.worst_span, spell.worst_change = steps, spell.span, spell.change
    forget_spell(spell)


@kernel
def follow_spell(spell, g0, g1, change, speed, fastest, h):
    """Take a step from the gap g0 to g1 into account, which has changed the speed of an impact; what was closed at the
    start is passed over, and of a line what touches slowly beside its `fastest` point.
    """
    if g0 < 0.0 and spell.steps == 0.0:
        return
    part = 1.0
    if g0 >= 0.0 > g1:
        part = g1 / (g1 - g0)
    elif g0 < 0.0 <= g1:
        part = g0 / (g0 - g1)
    spell.steps += part
    spell.span += part * h
    spell.change += change
    spell.jump = max(spell.jump, change)
    if change > FELT * max(speed, fastest):
        spell.longest = max(spell.longest, h)
    if g1 >= 0.0:
        _end_spell(spell, 2.0 * SLOWLY * fastest)

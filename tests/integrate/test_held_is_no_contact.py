"""What a quantiser or a relay looks at passes zero as the gap of a contact does; it is counted as none."""

from types import SimpleNamespace

import numpy as np

import flexmb as fmb
from flexmb.integrate.runs.coarse_contacts import CoarseContacts
from flexmb.integrate.runs.spells import Spell
from flexmb.math.switches import COLUMNS, FORMULA, GAP, HELD, KINK


def ended(kind: float, formula: float) -> SimpleNamespace:
    """Return a switch whose number was below zero for one step and is above it again."""
    now = np.zeros((1, COLUMNS))
    now[0, 0], now[0, FORMULA] = kind, formula
    spells = np.zeros(1, Spell.dtype)
    for name, x in {"ended": 1.0, "worst_steps": 1.0, "worst_span": 1e-4, "worst_change": 2.0}.items():
        spells[name] = x
    spells["largest_change"] = 2.0
    return SimpleNamespace(now=now, spells=spells, limits=[SimpleNamespace(share=1e-6, floor=1e-6)])


def found(switching: SimpleNamespace) -> tuple[dict, list[str]]:
    """Return the statistics and the warnings of a run of a second."""
    contacts = CoarseContacts(fmb.GeneralizedAlpha())
    seen = contacts.look(SimpleNamespace(switch_owners=("Block 'q'",)), switching)
    return seen, contacts.sentences(1.0)


def test_the_number_of_a_quantiser_is_no_contact():
    assert found(ended(float(KINK), HELD)) == ({}, [])


def test_a_gap_is_one():
    seen, told = found(ended(float(GAP), 0.0))
    assert seen["contacts ended"] == 1
    assert "it closed and opened again" in told[0]

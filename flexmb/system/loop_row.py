"""The row of a compiled model that measures, runs the programs of loops, and writes what follows them with tangents."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from flexmb.constraints import Measured
from flexmb.constraints.loop import kept_places, words
from flexmb.constraints.measured_kernels import MEASURED, REACTION
from flexmb.errors import ModelError
from flexmb.model.expression import joined_arrays
from flexmb.model.table import in_order
from flexmb.system.holds import Hold, upstream_first
from flexmb.system.loop_kinks import kink_rows
from flexmb.system.loop_places import LoopPlaces
from flexmb.system.loop_programs import affine_rows, atoms_read, chain_rows, input_places, inputs_of, renumbered

__all__ = ["loop_row"]


def loop_row(loops, used: int) -> dict[str, Any]:
    """Return the values of the row that measures, runs all programs and writes what follows them.

    Parameters
    ----------
    loops : Loops
        Receives where its numbers go in the iteration matrix, `places`.
    used : int
        Number of programs that act on forces and states; those behind are looked at for kinks only.
    """
    compiler, sources = loops.compiler, _with_more_derivatives(loops)
    n_atoms = len(loops.atoms)
    compiler.writing = compiler.writing or "Signals"
    numbers = [tuple(_markers(loops, scalar)) for scalar in loops.atoms]
    legs = tuple(dict.fromkeys(m for of_one in numbers for m in of_one if m >= 0))
    legs_of = {marker: k for k, marker in enumerate(legs)}
    rows = np.array(
        [in_order(MEASURED, z.record(compiler, lambda m: legs_of.get(m, -1))) for z in loops.atoms], MEASURED
    )
    rows["source"] = sources
    programs = [renumbered(program, n_atoms) for program in loops.programs]
    ops, args, tables = joined_arrays(programs)
    uses = [inputs_of(program) for program in programs]
    read = atoms_read(uses, n_atoms)
    loops.holds = upstream_first(loops.holds, [_needs(loops, hold, read) for hold in loops.holds])
    held = [number for hold in loops.holds for number in (*hold.branches, hold.clock) if number >= 0]
    for slot, *_ in (*loops.rates, *loops.channels):
        _require_explicit(loops, read[slot])
    places = loops.places = LoopPlaces(compiler, rows, legs, read, loops.follows_accelerations)
    for slot, marker, component in loops.rates:
        places.add(slot, marker, component=component)
    for channel, (slot, marker) in enumerate(loops.channels):
        places.add(slot, marker, channel=channel)
    inputs, chain = input_places(compiler, programs, uses), chain_rows(compiler, uses, n_atoms, used)
    counts = n_atoms, len(programs), sum(map(len, uses)), chain["n_reads"], inputs["width"]
    return {
        "n_atoms": n_atoms,
        "atoms": compiler.bulk(rows.view(float)),
        "sorts": compiler.bulk(words([atom.sort for atom in loops.atoms])),
        "n": len(programs),
        "n_used": used,
        "programs": compiler.bulk(words(np.cumsum([0] + [len(p.ops) for p in programs]))),
        "ops": compiler.bulk(words(ops)),
        "args": compiler.bulk(args),
        **inputs,
        "n_uses": counts[2],
        "n_tables": len(tables),
        "tables": compiler.bulk(np.concatenate([*tables, np.zeros(0)])),
        "table_starts": compiler.bulk(words(np.cumsum([0] + [len(table) for table in tables]))),
        "uses": compiler.bulk(words([i for of_one in uses for i in of_one])),
        "use_starts": compiler.bulk(words(np.cumsum([0] + [len(of_one) for of_one in uses]))),
        **affine_rows(compiler, programs, loops.addresses, uses),
        "addresses": compiler.bulk(words(loops.addresses)),
        **chain,
        "n_outputs": len(loops.outputs),
        "outputs": compiler.bulk(words(loops.outputs)),
        "n_rates": len(loops.rates),
        "rates": compiler.bulk(words(loops.rates)),
        **places.fields(),
        "implicit": int(loops.follows_accelerations),
        "n_held": len(held),
        "held": compiler.bulk(words(held)),
        **kink_rows(compiler, loops.kinks, loops.atoms),
        **kept_places(*counts, places.most),
    }


def _with_more_derivatives(loops) -> list[int]:
    """Add scalars for the derivatives of wrenches by further pairs; return of which each scalar has more, or -1."""
    sources = [-1] * len(loops.atoms)
    for k, atom in enumerate(tuple(loops.atoms)):
        if atom.what == "wrench":
            more = loops.wrenches.more_pairs(atom.part)
            loops.atoms += [replace(atom, pair=pair) for pair in more]
            sources += [k] * len(more)
    return sources


def _require_explicit(loops, read: list[int]) -> None:
    """Raise ModelError if a force, or the rate of a state, follows a reaction of the same instant."""
    at_once = next((loops.atoms[k] for k in read if loops.atoms[k].sort == REACTION), None)
    if at_once is not None:
        raise ModelError(
            "Signals",
            found=f"an algebraic loop: a force or a state follows a reaction of joint '{at_once.part}', which "
            "follows from all forces at the same instant",
            expected="a reaction that is sampled",
            remedy='Write fmb.Sampled(fmb.measured("reaction"), period=1e-3), or make the joint a Bushing and '
            "measure its force",
        )


def _needs(loops, hold: Hold, read: list[list[int]]) -> set[int]:
    """Return the branches whose values a change of a block reads."""
    slots = [slot for slot, number in loops.outputs if number in hold.reads]
    return {loops.atoms[a].held for slot in slots for a in read[slot]} - {-1}


def _markers(loops, scalar: Measured) -> list[int]:
    """Return the markers that move a scalar."""
    if scalar.state is not None:
        return [loops.compiler.state_place(*scalar.state)[0]]
    if scalar.combination is not None:
        return [loops.compiler.combined(scalar.combination)]
    if scalar.what == "wrench":
        return list(loops.wrenches.place(scalar.part, scalar.pair)[2:])
    if scalar.sort == REACTION:
        return []
    return [loops.compiler.marker(name) for name in scalar.markers]

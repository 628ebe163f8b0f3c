"""Programs of loops: one in the place of another's inputs, numbers of inputs, and which are affine."""

from __future__ import annotations

import numpy as np

from flexmb.constraints.loop import words
from flexmb.math import operations as op
from flexmb.model.affine import affine_parts
from flexmb.model.expression import SignalProgram

__all__ = ["LATER", "affine_rows", "atoms_read", "chain_rows", "input_places", "inputs_of", "renumbered", "with_inputs"]

LATER = 1_000_000
"""Inputs from here on are results of programs."""


def inputs_of(program: SignalProgram) -> list[int]:
    """Return the inputs that a program reads, each once."""
    return list(dict.fromkeys(program.args[program.ops == op.INPUT].astype(int).tolist()))


def with_inputs(program: SignalProgram, inputs: list[SignalProgram]) -> SignalProgram:
    """Return a program with programs in the place of its inputs."""
    pieces, first = [], 0
    for k in np.flatnonzero(program.ops == op.INPUT).tolist():
        pieces += [_part(program, first, k), inputs[int(program.args[k])]]
        first = k + 1
    whole = [piece for piece in [*pieces, _part(program, first, len(program.ops))] if len(piece.ops)]
    return whole[0].then(*whole[1:])


def _part(program: SignalProgram, first: int, last: int) -> SignalProgram:
    return SignalProgram(program.ops[first:last], program.args[first:last], program.tables)


def renumbered(program: SignalProgram, n_atoms: int) -> SignalProgram:
    """Return a program that reads results of programs behind all atoms."""
    later = (program.ops == op.INPUT) & (program.args >= LATER)
    return SignalProgram(program.ops, np.where(later, program.args - LATER + n_atoms, program.args), program.tables)


def affine_rows(compiler, programs: list[SignalProgram], addresses: list[int], uses: list[list[int]]) -> dict[str, int]:
    """Return where it stands in the bulk data which programs only multiply their inputs and add, and their numbers."""
    found = [None if at else affine_parts(program) for program, at in zip(programs, addresses, strict=True)]
    both = list(zip(found, programs, strict=True))
    of_inputs = [0.0 if parts is None else parts[1].get(i, 0.0) for parts, read in zip(found, uses) for i in read]
    return {
        "affine": compiler.bulk(words([1 if parts else 2 if _is_limit(p) else 0 for parts, p in both])),
        "constants": compiler.bulk(np.array([0.0 if parts is None else parts[0] for parts in found])),
        "factors": compiler.bulk(np.array(of_inputs)),
    }


def _is_limit(program: SignalProgram) -> bool:
    """Is a program min(max(x, low), high) of an input x, with low <= high?"""
    if program.inputs or program.ops.tolist() != [op.INPUT, op.CONSTANT, op.MAX, op.CONSTANT, op.MIN]:
        return False
    return bool(program.args[1] <= program.args[3])


def input_places(compiler, programs: list[SignalProgram], uses: list[list[int]]) -> dict[str, int]:
    """Return where it stands in the bulk data which input an operation reads, and which of its program's that is."""
    numbers, places = [], []
    for program, read in zip(programs, uses, strict=True):
        for code, argument in zip(program.ops.tolist(), program.args.tolist(), strict=True):
            number = int(argument) if code == op.INPUT else -1
            numbers.append(number)
            places.append(read.index(number) if number >= 0 else -1)
    width = max((len(read) for read in uses), default=0)
    return {"inputs": compiler.bulk(words(numbers)), "places": compiler.bulk(words(places)), "width": width}


def atoms_read(uses: list[list[int]], n_atoms: int) -> list[list[int]]:
    """Return the atoms on which the result of each program depends, by way of programs before it too."""
    found: list[list[int]] = []
    for of_one in uses:
        found.append(sorted({a for i in of_one for a in ((i,) if i < n_atoms else found[i - n_atoms])}))
    return found


def chain_rows(compiler, uses: list[list[int]], n_atoms: int, used: int) -> dict[str, int]:
    """Return where it stands in the bulk data which atoms programs read, and of which products derivatives consist.

    The derivative of a program by an atom that it reads has the number 1 + its place among all reads; 0 is an atom's
    own, which is 1. `used` : number of programs that act.
    """
    reads = atoms_read(uses, n_atoms)
    starts = np.cumsum([0] + [len(of_one) for of_one in reads]).tolist()
    chain, counts, use = [], [0], 0
    for p, of_one in enumerate(uses):
        for i in of_one:
            before = [(i, 0)]
            if i >= n_atoms:
                before = [(a, 1 + starts[i - n_atoms] + k) for k, a in enumerate(reads[i - n_atoms])]
            chain += [(1 + starts[p] + reads[p].index(a), use, source) for a, source in before]
            use += 1
        counts.append(len(chain))
    return {
        "reads": compiler.bulk(words([a for of_one in reads for a in of_one])),
        "read_starts": compiler.bulk(words(starts)),
        "n_reads": starts[-1],
        "chain": compiler.bulk(words(chain)),
        "n_chain": counts[-1],
        "n_chain_used": counts[used],
    }

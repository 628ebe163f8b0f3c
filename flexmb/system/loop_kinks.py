"""Where the programs of loops have kinks and jumps: the numbers that pass zero there, read from the programs.

Of `max(a, b)` it is a - b, of `abs(a)` a, of a table its argument at the points. Steps end there as at the times at
which signals of time are not smooth (`flexmb.model.breakpoints`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from flexmb.constraints.loop import words
from flexmb.constraints.measured import Measured
from flexmb.math import operations as op
from flexmb.math.switches import CROSSING, KINK, PIECE
from flexmb.model.breakpoints import RECORD, TRUTHS, bent_points
from flexmb.model.expression import SignalProgram
from flexmb.system.loop_programs import LATER, inputs_of

__all__ = ["Kink", "kink_rows", "located"]

MOST_KINKS = 200
"""Numbers that one model looks at after every step: each costs a short program and its derivatives."""
IN_FUNCTIONS = (
    "steps do not end where its Function has a kink or jumps, which nobody but the function knows; write it as a "
    "formula, whose kinks are known, or smooth (tanh)"
)
OF_ACCELERATIONS = (
    "steps do not end where it jumps with an acceleration: the force would change what tells its place; write a steep "
    "slope in the place of the jump (a linear table, tanh), or sample the acceleration (Sampled)"
)
CORNERS_OF_ACCELERATIONS = (
    "steps do not end at its corners over an acceleration, which bend what tells their place: the control of errors "
    "takes them up (steps of fixed size do not); give a smaller rtol, or sample the acceleration (Sampled)"
)
SMOOTH_BY = 2
"""Derivatives of a table that are looked at: a jump of the third one is left to the control of errors."""


class Kink(NamedTuple):
    """A number that passes zero, or points, where a program is not smooth.

    Parameters
    ----------
    kind : int
        KINK, CROSSING (of a jump) or PIECE, see `flexmb.math.switches`.
    program : SignalProgram
    points : tuple of float
        Of a table.
    periodic : bool
    """

    kind: int
    program: SignalProgram
    points: tuple[float, ...] = ()
    periodic: bool = False

    @property
    def key(self) -> tuple[Any, ...]:
        """What is the same of kinks that are the same."""
        tables = tuple(id(table) for table in self.program.tables)
        return self.kind, self.program.ops.tobytes(), self.program.args.tobytes(), tables, self.points, self.periodic


def located(
    programs: list[SignalProgram],
    addresses: list[int],
    writers: list[str],
    varying: list[bool],
    bending: list[bool],
    acting: set[int],
) -> tuple[list[tuple[Kink, str]], list[str]]:
    """Return the kinks of what acts on forces and states, each once and with the part that follows it, and sentences
    about those at which steps do not end.

    Parameters
    ----------
    programs : list of SignalProgram
    addresses : list of int
        Of functions in the place of programs, or 0.
    writers : list of str
        Titles of the parts for which they were made.
    varying : list of bool
        Of the atoms: may they change within a step?
    bending : list of bool
        Of the atoms: do they follow from the forces at once, as accelerations do? A kink then bends what tells its
        place, and integrators find accelerations less exactly than places: it is left to the control of errors, and
        a sentence tells.
    acting : set of int
        Programs on which forces and states depend.
    """
    reads = [inputs_of(program) for program in programs]
    changing: list[bool] = []
    bent: list[bool] = []

    def varies(number: int) -> bool:
        return changing[number - LATER] if number >= LATER else varying[number]

    def bends(number: int) -> bool:
        return bent[number - LATER] if number >= LATER else bending[number]

    for of_one in reads:
        changing.append(any(varies(number) for number in of_one))
        bent.append(any(bends(number) for number in of_one))
    used = set(acting)
    for slot in reversed(range(len(programs))):
        if slot in used:
            used |= {number - LATER for number in reads[slot] if number >= LATER}
    notes, found = [], {}
    for slot in sorted(used):
        if addresses[slot]:
            notes.append(f"{writers[slot]}: {IN_FUNCTIONS}")
            continue
        for kink in kinks_in(programs[slot], varies):
            if any(bends(number) for number in inputs_of(kink.program)):
                words = OF_ACCELERATIONS if kink.kind == CROSSING else CORNERS_OF_ACCELERATIONS
                note = f"{writers[slot]}: {words}"
                if note not in notes:
                    notes.append(note)
                continue
            found.setdefault(kink.key, (kink, writers[slot]))
    if len(found) > MOST_KINKS:
        notes.append(
            f"formulas and tables have {len(found)} kinks and jumps; steps end at the first {MOST_KINKS} of them, and "
            "may pass over the others"
        )
    return list(found.values())[:MOST_KINKS], notes


def kinks_in(program: SignalProgram, varies: Callable[[int], bool]) -> Iterator[Kink]:
    """Yield the kinks and jumps of a program, the inner ones first.

    `varies` says of an input if it changes within a step.
    """
    stack: list[tuple[int, int]] = []  # first operation of a value, and the one that makes it
    for k, code in enumerate(program.ops.tolist()):
        if code in op.PUSHES:
            stack.append((k, code))
        elif code in op.UNARY:
            first, made = stack.pop()
            yield from _unary(program, first, k, made, varies)
            stack.append((first, code))
        elif code in op.BINARY:
            (middle, right), (first, left) = stack.pop(), stack.pop()
            yield from _binary(program, (first, middle, k), (left, right), varies)
            stack.append((first, code))
        else:
            _, (second, _), (first, condition) = stack.pop(), stack.pop(), stack.pop()
            if condition not in TRUTHS:
                yield from _passes(program, (first, second), CROSSING, varies)
            stack.append((first, code))


def _unary(program: SignalProgram, first: int, at: int, made: int, varies) -> Iterator[Kink]:
    code, span = int(program.ops[at]), (first, at)
    if code == op.ABS:
        yield from _passes(program, span, KINK, varies)
    elif code in (op.SIGN, op.STEP) or (code == op.NOT and made not in TRUTHS):
        yield from _passes(program, span, CROSSING, varies)
    elif code == op.TABLE:
        table = program.tables[int(program.args[at])]
        n = abs(int(table[0]))
        points = table[[1, n]] if n > RECORD else bent_points(table, SMOOTH_BY)
        yield from _passes(program, span, PIECE, varies, points, periodic=table[0] < 0.0)


def _binary(program: SignalProgram, spans: tuple[int, int, int], made: tuple[int, int], varies) -> Iterator[Kink]:
    first, middle, at = spans
    code = int(program.ops[at])
    if code in (op.MIN, op.MAX, *range(op.LESS, op.GREATER_EQUAL + 1)):
        # equality holds at single moments, where a value of its own has no effect
        minus = SignalProgram.of((op.SUBTRACT, 0.0))
        yield from _passes(program, (first, at), KINK if code in (op.MIN, op.MAX) else CROSSING, varies, then=minus)
    elif code in (op.AND, op.OR):
        for span, inner in (((first, middle), made[0]), ((middle, at), made[1])):
            if inner not in TRUTHS:
                yield from _passes(program, span, CROSSING, varies)
    elif code == op.TABLE2:
        table = program.tables[int(program.args[at])]
        n, m = int(table[0]), int(table[1])
        powers = table[2 + n + m :].reshape(n - 1, m - 1, 4, 4)
        linear = not np.any(powers[:, :, :2]) and not np.any(powers[..., :2])
        for span, points in (((first, middle), table[2 : 2 + n]), ((middle, at), table[2 + n : 2 + n + m])):
            yield from _passes(program, span, PIECE, varies, points if linear else points[[0, -1]])


def _passes(
    program: SignalProgram,
    span: tuple[int, int],
    kind: float,
    varies: Callable[[int], bool],
    points: np.ndarray | None = None,
    *,
    periodic: bool = False,
    then: SignalProgram | None = None,
) -> Iterator[Kink]:
    """Yield what the operations [first, last) make, unless it is constant within steps."""
    own = slice(*span)
    ops, args = program.ops[own], program.args[own]
    if not any(varies(int(argument)) for argument in args[ops == op.INPUT]):
        return
    used = program.tables if np.any((ops == op.TABLE) | (ops == op.TABLE2)) else ()
    made = SignalProgram(ops, args, used)
    yield Kink(
        int(kind),
        made if then is None else made.then(then),
        () if points is None else tuple(points.tolist()),
        periodic,
    )


def kink_rows(compiler, kinks: list[tuple[int, Kink, str]], atoms: list[Measured]) -> dict[str, int]:
    """Return the fields of the row of loops that tell where kinks are: each with its program and its title."""
    starts = np.cumsum([0] + [len(kink.points) for _, kink, _ in kinks])
    counts = [-len(kink.points) if kink.periodic else len(kink.points) for _, kink, _ in kinks]
    units = [_unit(compiler, atom) for atom in atoms]
    return {
        "n_kinks": len(kinks),
        "kinks": compiler.bulk(words([(slot, kink.kind, *at) for (slot, kink, _), *at in zip(kinks, starts, counts)])),
        "points": compiler.bulk(np.array([x for _, kink, _ in kinks for x in kink.points], float)),
        "units": compiler.bulk(words([unit for unit, _ in units])),
        "shares": compiler.bulk(np.array([size for _, size in units], float)),
    }


def _unit(compiler, atom: Measured) -> tuple[int, float]:
    """Return in what an atom is measured: 1 lengths, 2 angles and states, 3 speeds, 4 rates of angles, 0 others; and
    the size of a state.
    """
    if atom.state is not None:
        owner, name = atom.state
        sizes = [
            size
            for title, group in compiler.states.items()
            for own, size in zip(group.names, group.size)
            if title.endswith(f"'{owner}'") and own == name
        ]
        return 2, min(sizes, default=1.0)
    if atom.what in ("coordinate", "cosine", "place"):
        angle = atom.what == "cosine" or (atom.coordinate is not None and atom.coordinate.kind == "turn")
        return 1 + angle + 2 * atom.rate, 1.0
    return {"velocity": 3, "spin": 4}.get(atom.what, 0), 1.0

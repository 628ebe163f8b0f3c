"""Values of the programs of loops and their derivatives, beside the complex step."""

import cmath

import numpy as np
import pytest

from flexmb.constraints.loop import ROW, kept_places, words
from flexmb.constraints.loop_values import gradients, program_values
from flexmb.math import operations as op
from flexmb.model.expression import SignalProgram, joined_arrays
from flexmb.system.loop_programs import affine_rows, atoms_read, chain_rows, input_places, inputs_of

TIME = 0.7
COMPLEX = {
    op.NEGATIVE: lambda x: -x, op.SIN: cmath.sin, op.COS: cmath.cos, op.TAN: cmath.tan, op.ASIN: cmath.asin,
    op.ACOS: cmath.acos, op.ATAN: cmath.atan, op.SINH: cmath.sinh, op.COSH: cmath.cosh, op.TANH: cmath.tanh,
    op.EXP: cmath.exp, op.LOG: cmath.log, op.SQRT: cmath.sqrt, op.ADD: lambda a, b: a + b,
    op.SUBTRACT: lambda a, b: a - b, op.MULTIPLY: lambda a, b: a * b, op.DIVIDE: lambda a, b: a / b,
    op.POWER: lambda a, b: a**b, op.MIN: lambda a, b: a if a.real < b.real else b,
    op.MAX: lambda a, b: a if a.real > b.real else b, op.ABS: lambda x: x if x.real > 0 else -x,
    op.ATAN2: lambda a, b: cmath.atan(a / b),
}  # fmt: skip


class Bulk:
    """Collects bulk data, as a compiler of models does."""

    def __init__(self):
        self.pieces, self.size = [], 0

    def bulk(self, numbers):
        self.pieces.append(np.asarray(numbers, float))
        self.size += len(self.pieces[-1])
        return self.size - len(self.pieces[-1])


def evaluated(programs, atoms):
    """Return values of programs, and their derivatives by atoms; inputs behind the atoms are programs before."""
    store, n = Bulk(), len(atoms)
    uses = [inputs_of(program) for program in programs]
    ops, args, tables = joined_arrays(programs)
    row = np.zeros(1, ROW)
    fields = {
        "n_atoms": n, "n": len(programs), "n_used": len(programs), "n_uses": sum(map(len, uses)),
        "programs": store.bulk(words(np.cumsum([0] + [len(p.ops) for p in programs]))),
        "ops": store.bulk(words(ops)), "args": store.bulk(args), **input_places(store, programs, uses),
        "n_tables": len(tables), "tables": store.bulk(np.concatenate([*tables, np.zeros(0)])),
        "table_starts": store.bulk(words(np.cumsum([0] + [len(t) for t in tables]))),
        "uses": store.bulk(words([i for one in uses for i in one])),
        "use_starts": store.bulk(words(np.cumsum([0] + [len(one) for one in uses]))),
        **affine_rows(store, programs, [0] * len(programs), uses),
        "addresses": store.bulk(words([0] * len(programs))), **chain_rows(store, uses, n, len(programs)),
    }  # fmt: skip
    fields |= kept_places(n, len(programs), fields["n_uses"], fields["n_reads"], fields["width"])
    for name, value in fields.items():
        row[name] = value
    data, kept = np.concatenate(store.pieces), np.full(fields["size"], np.nan)
    kept[:n], values = atoms, slice(n, n + len(programs))
    program_values(row[0], data, TIME, len(programs), 0, kept)
    plain = kept[values].copy()
    program_values(row[0], data, TIME, len(programs), 1, kept)
    np.testing.assert_array_equal(kept[values], plain)  # the same numbers whether derivatives are asked for or not
    gradients(row[0], data, fields["n_chain"], kept)
    found, at = np.zeros((len(programs), n)), fields["gradient"] + 1
    for own, reads in zip(found, atoms_read(uses, n), strict=True):
        own[reads] = kept[at : at + len(reads)]
        at += len(reads)
    return plain, found


def complex_value(program, inputs):
    """Return the value of a program at complex inputs."""
    stack = []
    for code, argument in zip(program.ops.tolist(), program.args.tolist(), strict=True):
        if code == op.INPUT:
            stack.append(inputs[int(argument)])
        elif code in op.PUSHES:
            stack.append(complex(argument if code == op.CONSTANT else TIME))
        elif code in op.UNARY:
            stack.append(COMPLEX[code](stack.pop()))
        else:
            b, a = stack.pop(), stack.pop()
            stack.append(COMPLEX[code](a, b))
    return stack.pop()


def random_program(rng, known):
    """Return a program whose value lies between 0.5 and 2.5, where every operation is defined."""
    items, depth = [], 0
    for _ in range(rng.integers(3, 12)):
        if depth >= 2 and rng.random() < 0.45:
            # two values between 0.5 and 2.5: every operation takes them
            items += [(op.TANH, 0.0), (op.CONSTANT, 1.5), (op.ADD, 0.0)]
            items.append((int(rng.choice([c for c in COMPLEX if c in op.BINARY])), 0.0))
            items += [(op.TANH, 0.0), (op.CONSTANT, 1.5), (op.ADD, 0.0)]
            depth -= 1
        elif depth >= 1 and rng.random() < 0.4:
            items.append((int(rng.choice([op.NEGATIVE, op.SIN, op.COS, op.TANH, op.ATAN, op.ABS])), 0.0))
            items += [(op.TANH, 0.0), (op.CONSTANT, 1.5), (op.ADD, 0.0)]
        else:
            kind = int(rng.choice([op.INPUT, op.INPUT, op.CONSTANT, op.TIME]))
            items.append((kind, float(rng.integers(known)) if kind == op.INPUT else rng.uniform(0.2, 0.9)))
            depth += 1
    items += [(op.ADD, 0.0)] * (depth - 1) + [(op.TANH, 0.0), (op.CONSTANT, 1.5), (op.ADD, 0.0)]
    return SignalProgram.of(*items)


@pytest.mark.parametrize("seed", range(40))
def test_chains_of_random_programs_have_the_derivatives_of_the_complex_step(seed):
    rng = np.random.default_rng([seed, 71])
    atoms, programs = rng.uniform(0.2, 0.8, 3), []
    for _ in range(4):
        programs.append(random_program(rng, 3 + len(programs)))
    values, gradient = evaluated(programs, atoms)
    for k in range(len(atoms)):
        z = [complex(x, 1e-30 * (i == k)) for i, x in enumerate(atoms)]
        for program in programs:
            z.append(complex_value(program, z))
        found = np.array(z[3:])
        np.testing.assert_allclose(values, found.real, rtol=1e-12)
        np.testing.assert_allclose(gradient[:, k], found.imag / 1e-30, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("code", [op.ASIN, op.ACOS, op.SINH, op.COSH, op.EXP, op.LOG, op.SQRT, op.TAN])
def test_every_other_function_of_one_value(code):
    values, gradient = evaluated([SignalProgram.of((op.INPUT, 0), (code, 0.0))], np.array([0.4]))
    exact = COMPLEX[code](complex(0.4, 1e-30))
    assert values[0] == pytest.approx(exact.real, rel=1e-14)
    assert gradient[0, 0] == pytest.approx(exact.imag / 1e-30, rel=1e-12)


def test_of_equals_the_one_counts_that_will_be_the_greatest_next():
    pair = (op.INPUT, 0), (op.INPUT, 1)
    programs = [SignalProgram.of(*pair, (op.MAX, 0.0)), SignalProgram.of(*pair, (op.MIN, 0.0))]
    _, gradient = evaluated(programs, np.ones(2))
    np.testing.assert_array_equal(gradient, [[1, 1], [0, 0]])  # along each direction for itself


def test_constants_have_no_derivative_where_a_function_has_an_infinite_one():
    root = SignalProgram.of((op.CONSTANT, 0.0), (op.SQRT, 0.0), (op.INPUT, 0), (op.MULTIPLY, 0.0))
    values, gradient = evaluated([root], np.array([2.0]))
    assert values[0] == 0.0
    assert gradient[0, 0] == 0.0


def test_a_choice_follows_the_value_that_is_chosen():
    for at, chosen in ((0.2, 0), (0.9, 1)):
        items = (op.INPUT, 0), (op.CONSTANT, 0.5), (op.LESS, 0.0), (op.INPUT, 1), (op.INPUT, 2), (op.WHERE, 0.0)
        values, gradient = evaluated([SignalProgram.of(*items)], np.array([at, 3.0, 5.0]))
        assert values[0] == (3.0, 5.0)[chosen]
        np.testing.assert_array_equal(gradient[0], [0, 1 - chosen, chosen])

"""Expressions: what they may hold, what they are worth, and what is said about the others."""

import math

import numpy as np
import pytest

from flexmb.errors import ModelError
from flexmb.model.expression import SignalProgram, compile_expression, evaluate, names


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2 + 3*4", 14.0),
        ("-2**2", -4.0),
        ("+1.5e3/3", 500.0),
        ("2**-1", 0.5),
        ("38*deg", math.radians(38.0)),
        ("sin(pi/6)", 0.5),
        ("atan2(1, -1)", 0.75 * math.pi),
        ("log(e)", 1.0),
        ("min(3, 1, 2) + max(3, 1, 2)", 4.0),
        ("sign(-3) + abs(-3)", 2.0),
        ("smooth(0.5) + step(-1) + step(0)", 1.5),
        ("where(0 < 1 < 2, 7, 8)", 7.0),
        ("where(1 > 2 or not 3 == 3, 7, 8)", 8.0),
        ("where(1 <= 2 and 2 >= 2 and 1 != 2, 7, 8)", 7.0),
        ("2*arm", 0.8),
        ("  arm + 1", 1.4),
    ],
)
def test_value(text, value):
    assert evaluate(text, {"arm": 0.4}) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "found", "remedy"),
    [
        ("2 +", "not arithmetic", "brackets"),
        ("", "not arithmetic", "brackets"),
        ("__import__('os').system('true')", "a call of '__import__('os').system'", "Use one of"),
        ("open('x')", "the function 'open' is unknown", "Use one of"),
        ("sine(1)", "the function 'sine' is unknown", "Did you mean 'sin'?"),
        ("np.float64(0.3)*t", "a call of 'np.float64'", "float(x)"),
        ("arm.real", "a dot after a name", "Leave it out"),
        ("[1, 2]", "not arithmetic: List", "Leave it out"),
        ("(1, 2)", "a comma", "Leave it out"),
        ("'text'", "text or a word", "Leave it out"),
        ("True", "text or a word", "Leave it out"),
        ("lambda: 1", "a function definition", "Leave it out"),
        ("2^3", "the operator ^", "A power is written **"),
        ("7 % 2", "the operator %", "Leave it out"),
        ("1 < 2", "a comparison outside of where", "Write where"),
        ("1 if 2 else 3", "'if' and 'else'", "Write where"),
        ("where(1 in 2, 1, 2)", "a comparison other than", "Compare numbers"),
        ("amr*2", "the name 'amr' is unknown", "Did you mean 'arm'?"),
        ("height", "the name 'height' is unknown", "Add height to the parameters"),
        ("sin", "the function 'sin' without arguments", "Write sin(...)"),
        ("sin(1, 2)", "sin with 2 arguments", "Write sin(a)"),
        ("min(1)", "min with 1 arguments", "Write min(a, b)"),
        ("sin(x=1)", "sin with 1 arguments", "Write sin(a)"),
        ("t*2", "'t' in a value that is constant", "Only signals"),
        ("1/0", "no finite value", "division by zero"),
        ("sqrt(-1)", "no finite value", "root"),
        ("1e999", "no finite value", "division"),
        ("10.0**400", "no finite value", "division"),
        ("9" * 400, "no finite value", "division"),
        ("word", "the parameter 'word' is 'text'", "Give the parameter a number"),
        ("(" * 300 + "1" + ")" * 300, "not arithmetic", "brackets"),
        ("1+" * 1500 + "1", "3001 characters", "brackets"),
    ],
)
def test_what_is_no_arithmetic(text, found, remedy):
    with pytest.raises(ModelError) as caught:
        evaluate(text, {"arm": 0.4, "word": "text"})
    assert found in str(caught.value)
    assert remedy in str(caught.value)
    assert caught.value.part.startswith("Expression '")
    assert caught.value.expected


def test_names():
    assert names("2*arm*sin(omega*t) + pi") == {"arm", "omega", "t"}


def test_constants_are_computed_once():
    assert compile_expression("2*sin(pi/2)*t + 3*a", {"a": 2.0}).ops.tolist() == [0, 1, 52, 0, 50]


def test_programs_join_with_their_tables():
    one = SignalProgram.of((1, 0.0), (40, 0.0), tables=(np.zeros(1),))
    both = one.then(one, SignalProgram.of((50, 0.0)))
    assert both.args.tolist() == [0.0, 0.0, 0.0, 1.0, 0.0]
    assert len(both.tables) == 2


def test_stack_is_limited():
    with pytest.raises(ModelError, match=r"needs 65 values at once.*at most 64.*use a table"):
        compile_expression("t+(" * 64 + "t" + ")" * 64)

"""Numbers of units: integers, booleans, enumerations and elements of arrays, without a unit behind them."""

from types import SimpleNamespace

import pytest

import flexmb as fmb
from flexmb.fmi.unit_variables import UnitVariables, failed_reading


def variable(name, kind, causality="input", dimensions=(), start=None, reference=1):
    return SimpleNamespace(
        name=name, type=kind, causality=causality, dimensions=dimensions, shape=dimensions, start=start,
        valueReference=reference,
    )  # fmt: skip


class Unit:
    """Keeps what it is told, by the function that was called."""

    def __init__(self):
        self.calls, self.values = [], {}

    def __getattr__(self, function):
        if function.startswith("set"):
            return lambda references, values: self._set(function[3:], references, values)
        return lambda references, n=None: self.values[function[3:], references[0]]

    def _set(self, kind, references, values):
        self.calls.append((kind, list(values)))
        self.values[kind, references[0]] = list(values)


def with_unit(*described, old=False):
    variables = UnitVariables("Fmu 'a'", described, old)
    variables.unit = Unit()
    return variables


@pytest.mark.parametrize(
    ("kind", "old", "value", "call"),
    [
        ("Real", True, 1.5, ("Real", [1.5])),
        ("Integer", True, 2.6, ("Integer", [3])),
        ("Enumeration", True, 2.0, ("Integer", [2])),
        ("Boolean", True, 0.5, ("Boolean", [1])),
        ("Boolean", True, 0.49, ("Boolean", [0])),
        ("Float32", False, 1.5, ("Float32", [1.5])),
        ("UInt8", False, 254.6, ("UInt8", [255])),
        ("UInt64", False, 2**53 + 1, ("UInt64", [2**53 + 1])),
        ("Int64", False, -3.2, ("Int64", [-3])),
        ("Enumeration", False, 2.0, ("Int64", [2])),
        ("Boolean", False, 7.0, ("Boolean", [1])),
    ],
)
def test_a_number_becomes_what_the_variable_holds(kind, old, value, call):
    variables = with_unit(variable("v", kind), old=old)
    variables.set("v", value, "input")
    assert variables.unit.calls == [call]
    assert type(variables.unit.calls[0][1][0]) is type(call[1][0])


@pytest.mark.parametrize(("kind", "value"), [("UInt8", 255.6), ("UInt16", -0.6), ("Int8", 128.0), ("Int32", 1e300)])
def test_what_does_not_fit_is_named_with_the_bounds(kind, value):
    with pytest.raises(fmb.IntegrationError, match=rf"input v = .* {kind}: a whole number from"):
        with_unit(variable("v", kind)).set("v", value, "input")


def test_a_real_of_32_bits_has_its_bounds():
    with pytest.raises(fmb.IntegrationError, match=r"input v = 1e\+300.* Float32: at most 3\.40282347e\+38"):
        with_unit(variable("v", "Float32")).set("v", 1e300, "input")


@pytest.mark.parametrize(("kind", "value"), [("Int32", 2.5), ("Boolean", 0.5), ("Boolean", 2.0), ("UInt8", 300.0)])
def test_parameters_must_be_what_they_are_set_to(kind, value):
    with pytest.raises(fmb.ModelError, match="parameter v = "):
        with_unit(variable("v", kind, "parameter")).set("v", value, "parameter")


def test_elements_of_arrays_are_set_beside_those_that_stay():
    """By rows, from 1 on; the others keep the start of the description."""
    variables = with_unit(variable("A", "Float64", "parameter", (2, 3), start="1 2 3 4 5 6"))
    variables.set("A[2,1]", 9.0, "parameter")
    variables.set("A[1,3]", 8.0, "parameter")
    assert variables.unit.calls == [("Float64", [1, 2, 3, 9, 5, 6]), ("Float64", [1, 2, 8, 9, 5, 6])]
    variables.unit.values["Float64", 1] = [1.0, 2.0, 8.0, 9.0, 5.0, 6.0]
    assert variables.get("A[2,1]", "parameter") == 9.0


def test_names_that_do_not_fit_are_told_with_those_that_do():
    every = with_unit(
        variable("A", "Float64", "output", (2,)), variable("n", "Int32", "output"), variable("s", "String", "output")
    )
    with pytest.raises(fmb.ModelError, match=r"output 'A', an array\. Expected: one of: A\[1\], A\[2\], n"):
        every.find("A", "output")
    with pytest.raises(fmb.ModelError, match=r"no output 'A\[3\]'"):
        every.find("A[3]", "output")
    with pytest.raises(fmb.ModelError, match="of the type String"):
        every.find("s", "output")
    with pytest.raises(fmb.ModelError, match="no input 'n'"):
        every.find("n", "input")


def test_large_arrays_are_told_by_their_ends_and_set_by_one_call():
    """A million names are neither made nor listed for a message; elements of one array go by one call."""
    variables = with_unit(variable("A", "Float64", dimensions=(1000, 1000), start="0"))
    with pytest.raises(fmb.ModelError, match=r"an array\. Expected: one of: A\[1,1\], A\[1,2\], A\[1000,1000\]"):
        variables.find("A", "input")
    variables.set_all({"A[1,1]": 2.0, "A[1000,1000]": 3.0}, "input")
    (call,) = variables.unit.calls
    assert (call[1][0], call[1][1], call[1][-1]) == (2.0, 0.0, 3.0)
    assert variables.get_all(("A[1000,1000]", "A[1,1]"), "input") == [3.0, 2.0]


def test_what_failed_to_be_read():
    """The same words for both kinds of units: three names and how many others."""
    assert failed_reading(["x"]) == "failed when 'x' was read"
    assert failed_reading({"x": 0, "y": 1}) == "failed when 'x', 'y' were read"
    assert (
        failed_reading([f"x[{k}]" for k in range(1, 10)]) == "failed when 'x[1]', 'x[2]', 'x[3]' and 6 others were read"
    )

"""The bound of the response's error against the exact error: beam, plate, crankshaft and wing, all bases."""

import numpy as np
import pytest
from reduction.four_bodies import BODIES, body, true_error

from flexmb import reduction


@pytest.mark.parametrize("name", BODIES)
def test_the_bound_is_near_the_error(name):
    fe, interfaces, band, _, _ = body(name)
    for basis, modes in [
        (reduction.CraigBampton(), 4),
        (reduction.Rubin(), 6),
        (reduction.Krylov((0.0, 0.6 * band)), "usual"),
        (reduction.CharacteristicModes(6), 6),
        (reduction.Balanced(60), 14),
    ]:
        data = reduction.reduce(fe, interfaces, modes, basis=basis, error_up_to=band, compare=0, stress=False)
        error = true_error(name, data)
        told = data.quality["transfer"]["relative"]
        assert 1.0 - 1e-3 <= told / error <= 10.0 or error < 1e-7


@pytest.mark.parametrize("name", ["beam", "plate"])
def test_craig_bampton_modes_meet_an_accuracy_of_the_response(name):
    """One text for all bases; of the frequencies alone 1 % leaves much more of the response, near resonances."""
    fe, interfaces, _, _, _ = body(name)
    asked = "up to 200 Hz within 1 %"
    usual = reduction.reduce(fe, interfaces, f"{asked} of the frequencies", error_up_to=200.0, compare=0, stress=False)
    close = reduction.reduce(fe, interfaces, asked, compare=0, stress=False)
    rubin = reduction.reduce(fe, interfaces, f"{asked} of the response", basis="Rubin", compare=0, stress=False)
    given = {"compare": 0, "stress": False, "error_up_to": 200.0}
    fewer = reduction.reduce(fe, interfaces, close.n_modes - (6 * len(interfaces) - 6) - 1, **given)
    assert true_error(name, usual) > 0.05
    assert true_error(name, close) < 0.01
    assert true_error(name, rubin) < 0.01
    assert close.quality["transfer"]["relative"] < 0.01
    assert fewer.n_modes == close.n_modes - 1
    assert fewer.quality["transfer"]["relative"] > 0.01


def test_krylov_vectors_are_few_where_the_frequency_of_the_loads_is_known():
    """Loads of 19.6 to 20.4 kHz on the journals of a crankshaft: 24 shapes instead of more than 126."""
    fe, interfaces, _, _, _ = body("short crank")
    near = np.linspace(19.6e3, 20.4e3, 9)
    given = {"compare": 0, "stress": False, "error_up_to": 10.0}
    few = reduction.reduce(fe, interfaces, basis=reduction.Krylov((20e3,), order=2), **given)
    many = reduction.reduce(fe, interfaces, 120, **given)
    assert few.n_modes == 24
    assert true_error("short crank", few, near) < 0.002
    assert many.n_modes == 126
    assert true_error("short crank", many, near) > 0.01


def test_craig_bampton_modes_are_few_where_many_interfaces_are_loaded():
    """Each new frequency of a Krylov basis costs as many shapes as there are loads: 97 of them instead of 64."""
    fe, interfaces, band, _, _ = body("long table")
    modes = reduction.reduce(fe, interfaces, 16, error_up_to=band, compare=0)
    krylov = reduction.reduce(fe, interfaces, f"up to {band} Hz within 1 %", basis="Krylov", compare=0)
    assert modes.n_modes == 64
    assert true_error("long table", modes) < 0.01
    assert krylov.n_modes > 90


def test_craig_bampton_modes_where_each_frequency_costs_many_shapes():
    """A plate fastened along an edge: 30 modes meet 200 Hz within 1 %; Krylov's 48 vectors of a second frequency leave
    a third of the response, and it takes a third one."""
    fe, interfaces, band, _, _ = body("edge")
    given = {"compare": 0, "stress": False, "error_up_to": band}
    modes = reduction.reduce(fe, interfaces, 30, **given)
    krylov = reduction.reduce(fe, interfaces, basis=reduction.Krylov((0.0, 140.0)), **given)
    more = reduction.reduce(fe, interfaces, basis=reduction.Krylov((0.0, 80.0, 180.0)), **given)
    assert modes.n_modes == 72
    assert true_error("edge", modes) < 0.01
    assert krylov.n_modes == 96
    assert true_error("edge", krylov) > 0.3
    assert more.n_modes > 120
    assert true_error("edge", more) < 0.01

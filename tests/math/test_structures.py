"""Structures of kernels: what a system, its workspace and the integrators hold is what their declarations say."""

import numpy as np
import pytest
from numba import typeof

import flexmb as fmb
from flexmb.math.program import Program
from flexmb.math.structures import Record, numba_type
from flexmb.math.tables import State, Work
from flexmb.system.assembly import assemble, consistent_start
from flexmb.tree.any_body.store import new_store
from flexmb.tree.spanning import spanning_tree


def assert_as_declared(value):
    """Compare every field with its annotation, those of structures inside as well."""
    declared = numba_type(type(value))
    for name, own, kind in zip(value._fields, value, declared.types, strict=True):
        if hasattr(own, "_fields"):
            assert_as_declared(own)
        else:
            assert typeof(own) == kind, f"{type(value).__name__}.{name}"
    assert typeof(value) == declared


@pytest.fixture(scope="module")
def started():
    model = fmb.Model(
        gravity=(0, 0, -9.81),
        bodies=[fmb.Ground(markers={"O": (0, 0, 0)}), fmb.RigidBody.rod("arm", length=1.0, mass=2.0)],
        joints=[fmb.Revolute("hinge", markers=("ground.O", "arm.start"))],
    )
    system, state = assemble(model)
    return system, consistent_start(system, state, system.workspace())


def test_a_system_is_as_declared(started):
    system, state = started
    found = system.program, system.workspace(), state
    assert [type(value) for value in found] == [Program, Work, State]
    for value in found:
        assert_as_declared(value)


def test_tables_of_the_recursion_are_as_declared(started):
    tables = spanning_tree(started[0]).tables
    assert_as_declared(tables)
    assert_as_declared(new_store(tables))


@pytest.mark.parametrize(
    ("integrator", "holds"),
    [
        (fmb.GeneralizedAlpha(), {"Variables", "Apart"}),
        (fmb.Explicit(), {"Steps", "LinkTree", "Switching"}),
        (fmb.Explicit(formulation=fmb.Recursive()), {"Steps", "LinkTree", "Switching"}),
        (fmb.Implicit(), {"Stages", "Switching"}),
        (fmb.IDA(), {"Stabilised"}),
    ],
    ids=["GeneralizedAlpha", "Explicit", "Explicit, recursive", "Implicit", "IDA"],
)
def test_storage_of_integrators_is_as_declared(integrator, holds, started):
    system, state = started
    run = integrator.start(system, state, system.workspace(), 1.0)
    parts = [run, *run] if isinstance(run, tuple) else vars(run).values()
    structures = {type(part).__name__: part for part in parts if hasattr(part, "_fields")}
    assert holds <= structures.keys()
    for name in holds:
        assert_as_declared(structures[name])


def test_records_have_their_fields_by_name():
    class Sample(Record):
        level: float
        count: int

    row = Sample.table(level=2.5)
    assert (row[0].level, row[0].count) == (2.5, 0)
    row[0].count += 3
    assert row["count"].tolist() == [3]
    assert row.dtype.names == ("level", "count")
    with pytest.raises(ValueError, match="no field"):
        Sample.table(levl=1.0)
    assert np.zeros(2, Sample.dtype)[1].level == 0.0

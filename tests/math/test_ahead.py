"""Entry kernels that are missing are compiled in another process, once, and found there by this one."""

import importlib
import os
import sys

import numpy as np
import pytest

import flexmb as fmb
from flexmb.integrate.runs.ahead_of_run import compile_ahead_of_run
from flexmb.lock import Lock
from flexmb.math import ahead, declared_kernels, kernel_claims
from flexmb.system.observe import observe_samples
from flexmb.system.program import compile_shared

ENTRY = """
from numba import types
from flexmb.math.kernel import entry_kernel

from flexmb.math.tables import pointer_kernel

@entry_kernel(types.float64)
def cube(x):
    return x * x * x

@pointer_kernel(types.float64(types.float64))
def square(x):
    return x * x
"""


@pytest.fixture
def cube(tmp_path, monkeypatch):
    """An entry kernel of a module that other processes find, and an empty cache."""
    (tmp_path / "cubes.py").write_text(ENTRY)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv(ahead.SWITCH, "1")
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    monkeypatch.delitem(sys.modules, "cubes", raising=False)
    yield importlib.import_module("cubes").cube
    sys.modules.pop("cubes", None)


def test_missing_kernels_are_compiled_elsewhere(cube):
    assert ahead.compile_ahead([cube]) == 1
    assert ahead._started[-1].wait(120) == 0
    assert not cube.overloads
    assert cube(3.0) == 27.0
    assert sum(cube.stats.cache_hits.values()) == 1
    assert ahead.compile_ahead([cube]) == 0


def test_row_kernels_are_compiled_elsewhere_as_well(cube):
    square = sys.modules["cubes"].square
    assert ahead.compile_ahead([], rows=[square]) == 1
    assert ahead._started[-1].wait(120) == 0
    assert not square.is_missing()
    assert square.compiled.cache_hits == 1
    assert ahead.compile_ahead([], rows=[square]) == 0


def test_row_kernels_come_after_all_else_and_the_last_ones_first(monkeypatch):
    """The process of the user begins with the first ones: the two meet in the middle."""
    commands = []
    monkeypatch.setenv(ahead.SWITCH, "1")
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    monkeypatch.setattr(ahead.subprocess, "Popen", lambda command, **_: commands.append(command))
    monkeypatch.setattr(ahead, "_started", [])
    monkeypatch.setattr(ahead, "_is_missing", lambda _: True)
    ball = fmb.RigidBody("ball", mass=1.0, inertia=(1, 1, 1), markers={"A": (0, 0, 0)})
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), ball],
        joints=[fmb.Spherical("A", markers=("ground.A", "ball.A"))],
    )
    compile_ahead_of_run(model, fmb.GeneralizedAlpha())
    named = [name.removeprefix("flexmb.") for name in commands[0][4:]]
    rows = [f"bodies.rigid:{stage}" for stage in ("place", "inertia", "energy")]
    expected = [*rows, "constraints.coincident:evaluate", "system.program:evaluation"]
    assert named[-5:] == expected[::-1]
    assert named[-6] == "integrate.alpha.newmark:run_steps"


def test_kernels_that_only_this_process_finds_are_passed_over(cube, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["", str(os.getppid()), "no_such_module:cube", "cubes:none", "cubes:square"])
    ahead.main()
    assert not sys.modules["cubes"].square.is_missing()


def test_what_another_process_compiles_is_waited_for_last(cube, monkeypatch):
    """Meanwhile this one compiles the others."""
    square = sys.modules["cubes"].square
    path = square._declared._cache._paths(square._declared._sig, cube.targetctx)[0]
    path.parent.mkdir(parents=True)
    order = []

    class Kernel:
        def __init__(self, name, elsewhere):
            self.name, self.elsewhere = name, elsewhere

        def is_missing(self):
            return True

        def is_being_compiled(self):
            return self.elsewhere

        @property
        def compiled(self):
            order.append(self.name)

    compile_shared([Kernel("a", False), Kernel("b", True), Kernel("c", False)])
    assert order == ["a", "c", "b"]
    with Lock(path, "Kernel"):
        assert square.is_being_compiled()
    assert not square.is_being_compiled()


def test_what_another_process_compiles_is_left_to_it(cube, monkeypatch):
    """Nor is anything compiled twice."""
    path = cube._cache._paths(cube.entry, cube.targetctx)[0]
    path.parent.mkdir(parents=True)
    monkeypatch.setattr(sys, "argv", ["", str(os.getppid()), "cubes:cube"])
    with Lock(path, "Kernel"):
        ahead.main()
    assert not cube.overloads
    ahead.main()
    assert list(cube.overloads) == [cube.entry]
    assert path.exists()
    assert not kernel_claims.is_claimed(path)


def test_parts_are_passed_over_where_the_whole_is_there(cube, monkeypatch):
    assert cube(2.0) == 8.0
    monkeypatch.setattr(ahead.subprocess, "Popen", None)
    assert ahead.compile_ahead([cube], [None]) == 0


def test_nothing_is_started_where_cores_are_not_free(cube, monkeypatch):
    monkeypatch.setattr(ahead, "cores", lambda: 1)
    assert ahead.compile_ahead([cube]) == 0
    monkeypatch.setattr(ahead, "cores", lambda: 2)
    monkeypatch.setenv(ahead.SWITCH, "0")
    assert ahead.compile_ahead([cube]) == 0


@pytest.mark.parametrize(
    "integrator",
    [fmb.GeneralizedAlpha(), fmb.Explicit(), fmb.Explicit(formulation=fmb.Recursive()), fmb.Implicit()],
    ids=["alpha", "explicit", "links", "implicit"],
)
def test_entries_are_declared_with_the_types_they_are_called_with(integrator):
    """A run calls the kernel that was compiled before it, and no other."""
    assert integrator.entries
    parts = getattr(integrator, "parts", ())
    for entry in (*integrator.entries, *parts):
        entry.compile(entry.entry)
    versions = [len(part.overloads) for part in parts]  # other integrators call some with other types
    model = fmb.Model(
        bodies=[fmb.Ground(), fmb.RigidBody("ball", mass=1.0, inertia=(1, 1, 1))],
        gravity=(0, 0, -9.81),
        sensors=[fmb.Position("place", marker="ball.center")],
    )
    solution = fmb.simulate(model, 0.1, integrator=integrator)
    for entry in integrator.entries:
        assert list(entry.overloads) == [entry.entry]
    assert versions == [len(part.overloads) for part in parts]
    assert set(integrator.entries) | set(parts) <= set(declared_kernels("flexmb"))
    np.testing.assert_allclose(solution["place"][-1], (0, 0, -0.5 * 9.81 * 0.01), rtol=1e-6, atol=1e-9)


def test_samples_are_observed_by_the_kernel_that_is_compiled_ahead():
    observe_samples.compile(observe_samples.entry)
    before = len(observe_samples.overloads)
    ball = fmb.RigidBody("ball", mass=2.0, inertia=(1, 1, 1))
    model = fmb.Model(
        bodies=[fmb.Ground(markers={"A": (0, 0, 0)}), ball],
        joints=[fmb.Fixed("hold", markers=("ground.A", "ball.center"))],
        gravity=(0, 0, -9.81),
        sensors=[fmb.Reaction("force", joint="hold")],
    )
    force = fmb.simulate(model, 0.01, samples=3)["force"]
    np.testing.assert_allclose(force[-1, :3], (0, 0, 2.0 * 9.81), atol=1e-9)
    assert len(observe_samples.overloads) == before


def test_parts_are_called_with_the_types_they_are_declared_with():
    """By machine code too, where a run adds no version: that of another type would be compiled while a user waits."""
    integrator = fmb.GeneralizedAlpha()
    called = set()
    for entry in integrator.entries:
        entry.compile(entry.entry)
        called |= _callees(entry.overloads[entry.entry].library)
    found = {part: {one.arguments for one in called if _is_of(one, part)} for part in integrator.parts}
    reached = [part for part, types in found.items() if types]
    others = {part.py_func.__name__ for part in integrator.parts if part not in reached and not _is_copied(part)}
    assert others <= {"energies_of_samples", "sample_signals"}  # called from Python or by address
    for part in reached:
        assert found[part] == {part.entry}, part


def _is_copied(part):
    """Whether callers hold a copy: a small kernel, whose size depends on the processor."""
    part.compile(part.entry)
    return part.overloads[part.entry].library.callee is None


def _callees(library):
    """Return all kernels that machine code calls, and those that these call."""
    called = {one.callee for one in library.called.values()}
    return called.union(*map(_callees, library.called.values()))


def _is_of(callee, kernel):
    function = kernel.py_func
    return (callee.module, callee.name) == (function.__module__, function.__qualname__)


def test_few_processes_are_started_each_with_another_kernel_first(cube, monkeypatch):
    commands = []
    monkeypatch.setattr(ahead, "cores", lambda: 16)
    monkeypatch.setattr(ahead.subprocess, "Popen", lambda command, **_: commands.append(command))
    monkeypatch.setattr(ahead, "_started", [])
    monkeypatch.setattr(ahead, "_is_missing", lambda _: True)
    integrator = fmb.GeneralizedAlpha()
    assert ahead.compile_ahead(integrator.entries, integrator.parts) == ahead.MOST == len(commands)
    orders = [command[4:] for command in commands]
    assert len({order[0] for order in orders}) == ahead.MOST
    assert len({tuple(sorted(order)) for order in orders}) == 1


def test_methods_of_scipy_have_no_entries():
    assert fmb.Explicit(method="Radau").entries == ()

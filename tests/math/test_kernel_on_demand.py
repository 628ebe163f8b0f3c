"""Kernels on demand are compiled when the first call is reached, by machine code as by Python, and not before."""

import importlib
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from numba.core.errors import TypingError

from flexmb.math import declared_kernels
from flexmb.math.kernel_on_demand import KernelOnDemand, kernel_on_demand
from flexmb.math.tables import COUNT, NUMBER

MODULE = """
import math

from numba import types
from flexmb.math.kernel import kernel
from flexmb.math.kernel_on_demand import kernel_on_demand
from flexmb.math.structures import array_type
from flexmb.math.tables import CHOICE, COUNT, FLOATS, NUMBER, void

@kernel_on_demand(NUMBER, NUMBER, COUNT)
def power(x, n):
    if n < 0:
        raise ValueError("n is negative")
    found = 1.0
    for _ in range(n):
        found *= x
    return found

@kernel_on_demand(CHOICE, array_type(FLOATS), CHOICE)
def double(x, wanted):
    for i in range(len(x)):
        x[i] *= 2.0 if wanted else 1.0
    return x[0] > 1.0

@kernel_on_demand(void, array_type(FLOATS))
def clear(x):
    x[:] = 0.0

@kernel_on_demand(COUNT, NUMBER)
def wrong(x):
    return 0.5 * x

@kernel
def sums(x, n):
    return power(x, n) + power(x, 1) if n != 0 else -1.0

@kernel
def changed(x, wanted):
    above = double(x, wanted)
    if x[0] > 100.0:
        clear(x)
    return above

@kernel
def sums_after(x, n, turns):
    waited = 0.0
    for i in range(turns):
        waited = math.sin(waited + i)
    return power(x, n) + 0.0 * waited

@kernel
def of_fraction(x):
    return power(x, 0.5 * x)

@kernel
def changed_part(x):
    return double(x[::2], True)

@kernel
def changed_as_given(x):
    return double(x, True)

@kernel
def calls_wrong(x):
    return wrong(x)
"""


@pytest.fixture
def rare(tmp_path, monkeypatch):
    """A module of kernels, and an empty cache."""
    name = f"rare_{tmp_path.name.replace('-', '_')}"  # symbols of a process live as long as it does
    (tmp_path / f"{name}.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "cache"))
    yield importlib.import_module(name)
    sys.modules.pop(name, None)


def test_it_is_compiled_at_its_first_call(rare):
    assert rare.sums(3.0, 0) == -1.0
    assert not rare.power.overloads
    assert rare.sums(3.0, 4) == 84.0
    assert list(rare.power.overloads) == [rare.power.entry]
    assert rare.sums(2.0, 10) == 1026.0
    assert rare.power(2.0, 3) == 8.0  # from Python


def test_arrays_and_choices_are_passed_on(rare):
    x = np.array([0.5, 3.0])
    assert rare.changed(x, False) is False
    assert rare.changed(x, True) is False
    assert rare.changed(x, True) is True
    np.testing.assert_array_equal(x, [2.0, 12.0])
    assert not rare.clear.overloads
    x[0] = 60.0
    rare.changed(x, True)
    np.testing.assert_array_equal(x, 0.0)
    assert rare.clear.overloads


def test_errors_of_it_reach_the_caller(rare):
    with pytest.raises(ValueError, match="n is negative"):
        rare.sums(3.0, -1)
    assert rare.sums(3.0, 1) == 6.0


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_another_result_than_declared_is_told(rare):
    with pytest.raises(RuntimeError, match=r"rare_.*\.wrong could not be compiled"):
        rare.calls_wrong(1.0)
    with pytest.raises(TypeError, match="returns float64, declared int64"):
        rare.wrong.ready()


def test_ctrl_c_while_it_is_compiled_is_not_lost(rare, monkeypatch):
    """The number is right, and the interruption follows."""
    rare.sums(3.0, 0)
    compiled, struck = rare.power.kernel.compile, []

    def interrupted(types):
        if not struck:
            struck.append(True)
            raise KeyboardInterrupt
        return compiled(types)

    monkeypatch.setattr(rare.power.kernel, "compile", interrupted)
    found = 0.0
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012 - it may come as soon as the number is there
        found = rare.sums(3.0, 4)
        for _ in range(1000):
            time.sleep(0.01)
    assert found == 84.0


def test_ctrl_c_before_it_is_called_is_not_lost(rare):
    """It strikes while machine code runs, and Python sees it only in the call that fills the cell."""
    rare.sums_after.compile((NUMBER, COUNT, COUNT))
    assert not rare.power.overloads
    striking = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
    found = 0.0
    with pytest.raises(KeyboardInterrupt):  # noqa: PT012 - it may come as soon as the number is there
        striking.start()
        found = rare.sums_after(3.0, 4, 60_000_000)
        for _ in range(1000):
            time.sleep(0.01)
    assert found == 81.0


@pytest.mark.parametrize(
    ("caller", "given", "told"),
    [
        ("of_fraction", 5.0, "argument n is declared int64, the call has float64"),
        ("changed_part", np.arange(6.0), r"argument x is declared array\(float64, 1d, C\), the call has .*, A\)"),
        ("changed_as_given", np.broadcast_to(1.0, 6), "argument x is declared array.*, the call has readonly"),
    ],
)
def test_arguments_of_other_types_are_refused(rare, caller, given, told):
    """2.5 would be taken as 2, and a view with gaps or one that may only be read as an array of its own."""
    with pytest.raises(TypingError, match=told):
        getattr(rare, caller)(given)


def test_it_is_a_function_of_a_module():
    def inner(x):
        return x

    with pytest.raises(TypeError, match="must be a function of a module"):
        kernel_on_demand(NUMBER, NUMBER)(inner)


def test_kernels_that_call_it_are_pickled(rare):
    assert pickle.loads(pickle.dumps(rare.power)) is rare.power
    assert pickle.loads(pickle.dumps(rare.sums))(3.0, 4) == 84.0


def test_threads_that_need_it_at_once_find_it(rare):
    rare.sums(3.0, 0)
    found = [0.0] * 4

    def run(k):
        found[k] = rare.sums(float(k), 2)

    threads = [threading.Thread(target=run, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert found == [0.0, 2.0, 6.0, 12.0]
    assert len(rare.power.overloads) == 1


def test_machine_code_of_another_process_finds_it(rare, tmp_path):
    """Where the caller is loaded the cell is empty: it is filled at the first call, from the cache as well."""
    assert rare.sums(3.0, 4) == 84.0
    code = f"import {rare.__name__} as m; assert m.sums(3.0, 0) == -1.0; assert not m.power.overloads; "
    code += "assert m.sums(3.0, 4) == 84.0; assert sum(m.power.stats.cache_hits.values()) == 1; "
    code += "assert sum(m.sums.stats.cache_hits.values()) == 1"
    subprocess.run([sys.executable, "-c", code], check=True, env=os.environ, timeout=120)


def test_a_caller_stays_valid_when_the_code_of_it_changes(rare, tmp_path):
    """Only its types are part of the caller."""
    from flexmb.math.kernel_content import code_digest

    before = code_digest(rare.sums.py_func), code_digest(rare.changed.py_func)
    path = tmp_path / f"{rare.__name__}.py"
    path.write_text(MODULE.replace("found *= x", "found = found * x * 1.0").replace("(void, array", "(COUNT, array"))
    sys.modules.pop(rare.__name__)
    importlib.invalidate_caches()
    anew = importlib.import_module(rare.__name__)
    assert code_digest(anew.sums.py_func) == before[0]
    assert code_digest(anew.changed.py_func) != before[1]


def _on_demand():
    return [one for one in declared_kernels("flexmb") if isinstance(one, KernelOnDemand)]


@pytest.mark.parametrize("called", _on_demand(), ids=lambda one: one.py_func.__qualname__)
def test_results_are_as_declared(called):
    called.ready()
    assert called.overloads[called.entry].signature.return_type == called.types.return_type


PENDULUM = """
import flexmb as fmb
from flexmb.math import declared_kernels
from flexmb.math.kernel_on_demand import KernelOnDemand
ground = fmb.Ground(markers={"hinge": (0, 0, 0)})
arm = fmb.RigidBody("arm", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(1, 0, 0), markers={"hinge": (-1, 0, 0)})
joints, forces, arguments = [fmb.Revolute("hinge", markers=("ground.hinge", "arm.hinge"))], [], {}
CHANGE
fmb.simulate(fmb.Model(bodies=[ground, arm], joints=joints, forces=forces, gravity=(0, 0, -9.81)), 1.0, samples=11)
for one in declared_kernels("flexmb"):
    if isinstance(one, KernelOnDemand) and one.overloads:
        print(one.py_func.__name__)
"""


def _compiled(change):
    run = subprocess.run(
        [sys.executable, "-c", PENDULUM.replace("CHANGE", change)], check=True, capture_output=True, text=True
    )
    return set(run.stdout.split())


def test_a_pendulum_needs_none():
    assert _compiled("") == set()


@pytest.mark.slow
def test_a_model_gets_what_it_needs():
    pushed = 'forces = [fmb.PointLoad("push", marker="arm.center", force=(0, 0, fmb.expression("sin(t)")))]'
    assert _compiled(pushed) == {"run_program"}
    rope = 'forces = [fmb.OneSidedSpring("rope", markers=("ground.hinge", "arm.center"), stiffness=1e3, length=1.0)]'
    assert {"allowed", "keep_switches", "part_of_step"} <= _compiled(rope)

"""What must not change a motion: a marker, a far body, a body in two parts, a joint twice; resuming and repeating."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from metamorphic.analyses import END, INTEGRATORS, SAMPLES
from metamorphic.campaign import relation_holds
from metamorphic.mechanisms import mechanism
from metamorphic.relations import RELATIONS, apart, results, run
from metamorphic.seen import PLAIN

import flexmb as fmb


@pytest.mark.parametrize("name", RELATIONS)
@pytest.mark.parametrize("number", [0, 1])
def test_relations(seed, number, name):
    seed += number
    holds, found = relation_holds(seed, "steps", name)
    assert holds, f"seed {seed}, {name}: {found}"


def test_resumed_runs(seed):
    """In five pieces, each resumed from the one before, or in one."""
    model = mechanism(seed + 2)
    integrator, times = INTEGRATORS["IDA"](PLAIN), np.linspace(0.0, END, SAMPLES)
    pieces = fmb.simulate(model, times[2], samples=times[:3], integrator=integrator)
    for last in (4, 6, 8, 10):
        pieces = fmb.resume(pieces, times[last], samples=times[: last + 1], integrator=integrator)
    share, where = apart(results(run(model, "IDA"), model), results(pieces, model))
    assert share < 1e-4, f"seed {seed + 2}: {where} {share:.1e}"


def fingerprint(seed: int) -> str:
    """Return a hash of all bits of a motion."""
    solution = run(mechanism(seed), "GeneralizedAlpha")
    phase = solution.phases[0]
    return hashlib.sha256(
        b"".join(np.ascontiguousarray(x).tobytes() for x in (phase.q, phase.u, phase.lam))
    ).hexdigest()


def test_equal_on_repetition_in_other_processes_and_with_other_threads(seed):
    here = [fingerprint(seed), fingerprint(seed)]
    assert here[0] == here[1]
    code = f"from metamorphic.test_relations import fingerprint; print(fingerprint({seed}))"
    tests = Path(__file__).parents[1]
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "2")
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tests,
        env={**os.environ, **threads, "PYTHONPATH": str(tests)},  # the working directory may not be on the path
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.strip() == here[0], done.stderr


def bar_at_rest(frame) -> tuple[np.ndarray, np.ndarray]:
    """Return first frequencies and the reaction of a bar in equilibrium; damping is a share per mode of its frame."""
    model = mechanism(21, count=1, frame=frame, kinds=("reduced",))
    undamped = [body if body.name == "ground" else body.replaced(damping=0.0) for body in model.bodies]
    model = replace(model, bodies=tuple(undamped))
    rest = fmb.statics(model)
    frequencies = np.sort(fmb.linearize(model, about=rest).frequencies)[:4]
    return frequencies, rest["joint1 reaction"][-1, :3]


@pytest.mark.parametrize("frame", ["start", "end"])
def test_choice_of_the_reduction_frame(frame):
    plain, other = bar_at_rest(None), bar_at_rest(frame)
    np.testing.assert_allclose(other[0], plain[0], rtol=1e-3)
    np.testing.assert_allclose(other[1], plain[1], rtol=0.0, atol=1e-3 * np.abs(plain[1]).max())

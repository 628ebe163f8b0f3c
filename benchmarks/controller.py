"""What controllers cost: twenty blocks on the flap station, an arm of ten links led from Python, a four-bar stepped.

    python benchmarks/controller.py               # one or two minutes

The flap station of the demo, elastic lever, with a controller of twenty blocks (filters, PID, limits, dead zones, a
transfer function, a table) that follows lever and flap angle and acts on the foot of the pendulum, and without it:
`GeneralizedAlpha` with a fixed step, so that the steps are the same, both runs in turn. The arm: torques computed in
numpy every millisecond, twenty sensors read each time. CPU time of one thread, kernels compiled.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 (one thread: set before it is loaded)

import flexmb as fmb  # noqa: E402
from flexmb.integrate.alpha import generalized_alpha  # noqa: E402

ROOT = Path(__file__).parents[1]
STEP = 2e-4
BURSTS, OF_BURST = 150, 20


def blocks():
    """Return a signal that passes through twenty blocks."""
    lever, flap = fmb.measured("lever angle"), fmb.measured("flap angle")
    slow, quick = fmb.Lag(lever, time=0.05), fmb.Lag(flap, time=0.02)  # 2
    error = fmb.DeadZone(0.5 - slow, limits=(-1e-3, 1e-3))  # 3
    outer = fmb.Pid(error, kp=40.0, ki=10.0, kd=1.0, filter=0.01, limits=(-200.0, 200.0))  # 4
    wanted = fmb.RateLimit(outer, limits=(-50.0, 50.0), time=0.01)  # 5
    inner = fmb.Pid(wanted - 2.0 * quick, kp=3.0, ki=1.0, limits=(-100.0, 100.0))  # 6, and a gain: 7
    held = fmb.Limit(inner, limits=(-90.0, 90.0))  # 8
    notch = fmb.TransferFunction(held, numerator=[1.0, 2.0, 900.0], denominator=[1.0, 40.0, 900.0])  # 9
    bent = fmb.table([-100.0, -20.0, 20.0, 100.0], [-80.0, -20.0, 20.0, 80.0], of=notch)  # 10
    watch = fmb.formula("a*sin(b)", over={"a": bent, "b": quick})  # 11
    mean = fmb.Lag(watch, time=0.1)  # 12
    total = fmb.Integral(mean, gain=0.1, limits=(-10.0, 10.0))  # 13
    ahead = fmb.Lag(fmb.measured("carriage stroke"), time=0.03)  # 14
    second = fmb.Pid(0.2 - ahead, kp=5.0, ki=0.5)  # 15
    third = fmb.Limit(second, limits=(-30.0, 30.0))  # 16
    both = bent + total  # 17
    all_three = both + third  # 18
    zone = fmb.DeadZone(all_three, limits=(-0.1, 0.1))  # 19
    return fmb.Lag(zone, time=0.005)  # 20


def station(controlled: bool) -> fmb.Model:
    """Return the flap station, perhaps with the controller; the actuator is there in both."""
    model = fmb.load_model(Path(fmb.__file__).parent / "cli" / "demo_data" / "flap_station.toml")
    effort = 1e-2 * blocks() if controlled else 0.1
    return replace(model, forces=[*model.forces, fmb.Actuator("trim", joint="pendulum foot", effort=effort)])


def per_step(models: tuple[fmb.Model, ...]) -> np.ndarray:
    """Return the CPU time per step of runs that go on in turn, by burst and model, s: (n, models).

    Steps alone: what a run costs at its start would hide what a controller costs.
    """
    runs = [fmb.stepper(model, integrator=fmb.GeneralizedAlpha(step=STEP), keep=False) for model in models]
    for run in runs:
        run.advance(by=10 * STEP)  # compiles
    times = np.empty((BURSTS, len(runs)))
    for burst in range(BURSTS):
        for k, run in enumerate(runs):
            begun = time.process_time()
            run.advance(by=OF_BURST * STEP)
            times[burst, k] = (time.process_time() - begun) / OF_BURST
    return times


def arm_for_a_second(integrator) -> float:
    """Return the CPU time that an arm with computed torques takes for a second of motion, s."""
    sys.path.insert(0, str(ROOT / "tests"))
    from integrate.test_computed_torque import N, arm, torques

    goal = 0.2 * np.cos(np.arange(N))
    with fmb.stepper(arm(), integrator=integrator, t_end=2.0, keep=False) as run:
        for k in range(1050):
            if k == 50:
                begun = time.process_time()
            q, w = (np.array([run[f"{name}{i}"] for i in range(N)]) for name in "qw")
            run.set({f"t{i}": float(x) for i, x in enumerate(torques(q, w[:, 1], goal))})
            run.advance(to=1e-3 * (k + 1))
        return time.process_time() - begun


def four_bar(spatial: bool) -> fmb.Model:
    """Return a plane four-bar with a torque that is set from outside; `spatial`: without dependent equations."""

    def turned(x, z):
        return fmb.Pose.axes((x, 0.0, z), z=(0, 1, 0))

    points, bodies = [(0.0, 0.0), (0.0, 1.0), (2.0, 2.0), (3.0, 0.0)], []
    for k, (p, q) in enumerate(pairwise(points)):
        x, z = 0.5 * (q[0] - p[0]), 0.5 * (q[1] - p[1])
        ends = {"p": turned(-x, -z), "q": turned(x, z)}
        at = (p[0] + x, 0.0, p[1] + z)
        bodies.append(fmb.RigidBody(f"bar{k}", mass=1.0, inertia=(0.1, 0.1, 0.1), at=at, markers=ends))
    kinds = (fmb.Revolute, fmb.Cylindrical, fmb.Spherical, fmb.Revolute) if spatial else (fmb.Revolute,) * 4
    ends = (("ground.a", "bar0.p"), ("bar0.q", "bar1.p"), ("bar1.q", "bar2.p"), ("ground.d", "bar2.q"))
    return fmb.Model(
        bodies=[fmb.Ground(markers={"a": turned(0.0, 0.0), "d": turned(3.0, 0.0)}), *bodies],
        joints=[kind(f"hinge{k}", markers=pair) for k, (kind, pair) in enumerate(zip(kinds, ends, strict=True))],
        forces=[fmb.Actuator("motor", joint="hinge0", effort=fmb.input("torque"))],
        sensors=[fmb.JointCoordinate("angle", joint="hinge0")],
    )


def of_a_call(spatial: bool, calls: int = 200) -> tuple[float, float]:
    """Return the CPU time of a step of a four-bar from Python, s, and the part of it in calls of kernels."""
    spent, direct = [0.0], generalized_alpha.direct

    def timed(owner, kernel):
        call = direct(owner, kernel)

        def run(*arguments):
            begun = time.thread_time()
            found = call(*arguments)
            spent[0] += time.thread_time() - begun
            return found

        return run

    def burst(run) -> float:
        begun = time.thread_time()
        for k in range(calls):
            run.set("torque", 0.1 * (k % 7))
            run.advance(by=1e-4)
            run["angle"]
        return (time.thread_time() - begun) / calls

    with fmb.stepper(four_bar(spatial), integrator=fmb.GeneralizedAlpha(step=1e-4), keep=False) as run:
        burst(run)
        whole = np.percentile([burst(run) for _ in range(20)], 25)
        generalized_alpha.direct, of_kernels = timed, []
        try:
            for _ in range(20):
                spent[0] = 0.0
                burst(run)
                of_kernels.append(spent[0] / calls)
        finally:
            generalized_alpha.direct = direct
    return float(whole), float(np.percentile(of_kernels, 25))


def main() -> None:
    """Measure and print."""
    times = per_step((station(False), station(True)))
    quiet = 1e6 * np.percentile(times, 25, axis=0)
    more, least = np.median(times[:, 1] / times[:, 0]) - 1.0, quiet[1] / quiet[0] - 1.0
    print(
        f"flap station {quiet[0]:.0f} us a step, with 20 blocks {quiet[1]:.0f} us, {least:.0%} more (lower quartiles);"
    )
    print(f"median of the ratios of {BURSTS} pairs of bursts: {more:.0%} more")
    for spatial in (True, False):
        whole, kernels = (1e6 * x for x in of_a_call(spatial))
        kind = "independent equations" if spatial else "four parallel hinges"
        print(f"four-bar, {kind}: {whole:.0f} us a step from Python, {whole - kernels:.0f} us beyond its kernels")
    for integrator in (fmb.GeneralizedAlpha(step=1e-3), fmb.GeneralizedAlpha(), fmb.Explicit()):
        print(f"arm of ten links, 1 s at 1 kHz, {integrator!r}: {arm_for_a_second(integrator):.2f} s")


if __name__ == "__main__":
    main()

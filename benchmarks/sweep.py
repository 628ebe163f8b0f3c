"""A sweep of 100 variants of the flap station: one process beside two, start of the processes included; and sweeps of
small mechanisms by processes beside the engine "compiled".

Wall time says how much faster two processes are, if nobody else uses the cores; to see through other load, the second
line of each run says which share of the processes' time was spent on variants, and the CPU seconds they took in all:
two processes are twice as fast if both shares are near 1 and the CPU seconds are equal. Run with
``python benchmarks/sweep.py [variants] [engines | turns]``; "turns" takes both ways by turns in one process, without
the start of processes, so that other load falls on both.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import flexmb as fmb
from flexmb.study.ensemble import Ensemble
from flexmb.study.sources import ModelFile
from flexmb.study.variants import Task


def measured(model: Path, variants: int, jobs: int) -> float:
    """Sweep, print the figures, and return the wall time."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    plan = fmb.study.latin_hypercube({"pressure": (3e3, 6e3), "damping": (0.01, 0.05)}, variants)
    results = fmb.sweep(model, plan, outputs=["peak(strut force fx)"], jobs=jobs)
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    busy = sum(row.seconds for row in results.rows)
    assert not results.failed
    print(f"{jobs} processes: {wall:7.1f} s wall, load average {os.getloadavg()[0]:.1f}")
    print(f"             {100 * busy / (jobs * wall):5.1f} % of it on variants, {cpu:7.1f} s CPU")
    return wall


CART = """
gravity = [0, 0, -9.81]
[parameters]
mass = 0.5
stiffness = 2.0
[[body]]
kind = "Ground"
markers = {rail = {at = [0, 0, 0], z = [1, 0, 0], x = [0, 1, 0]}}
[[body]]
kind = "RigidBody"
name = "cart"
mass = 1.0
inertia = [1e-3, 1e-3, 1e-3]
markers = {rail = {at = [0, 0, 0], z = [1, 0, 0], x = [0, 1, 0]}, pin = {at = [0, 0, 0], z = [0, 1, 0], x = [1, 0, 0]}}
[[body]]
kind = "RigidBody"
name = "pole"
mass = "= mass"
inertia = [1e-2, 1e-2, 1e-3]
at = [0.05, 0, 0.25]
markers = {pin = {at = [-0.05, 0, -0.25], z = [0, 1, 0], x = [1, 0, 0]}, tip = [0, 0, 0.25]}
[[joint]]
kind = "Prismatic"
name = "rail"
markers = ["ground.rail", "cart.rail"]
[[joint]]
kind = "Revolute"
name = "pin"
markers = ["cart.pin", "pole.pin"]
[[force]]
kind = "SpringDamper"
name = "spring"
markers = ["ground.rail", "pole.tip"]
stiffness = "= stiffness"
damping = 0.05
length = 0.5
[[sensor]]
kind = "Position"
name = "tip"
marker = "pole.tip"
[simulation]
t_end = 1.0
samples = 101
integrator = %s
"""
PENDULUM = """
gravity = [0, 0, -9.81]
[parameters]
mass = 0.5
stiffness = 2.0
[[body]]
kind = "Ground"
markers = {pin = {at = [0, 0, 0], z = [0, 1, 0], x = [1, 0, 0]}}
[[body]]
kind = "RigidBody"
name = "rod"
mass = "= mass"
inertia = [1e-2, 1e-2, 1e-3]
at = [0.25, 0, 0]
markers = {pin = {at = [-0.25, 0, 0], z = [0, 1, 0], x = [1, 0, 0]}, tip = [0.25, 0, 0]}
[[joint]]
kind = "Revolute"
name = "pin"
markers = ["ground.pin", "rod.pin"]
[[force]]
kind = "TorsionSpring"
name = "spring"
joint = "pin"
stiffness = "= stiffness"
damping = 0.02
[[sensor]]
kind = "Position"
name = "tip"
marker = "rod.tip"
[simulation]
t_end = 1.0
samples = 101
integrator = %s
"""
INTEGRATORS = {
    "GeneralizedAlpha": '"GeneralizedAlpha"',
    "Explicit": '"Explicit"',
    "Implicit": '"Implicit"',
    "IDA": '"IDA"',
}


def spent() -> float:
    """Return the processor time of this process and its children so far, s."""
    of = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(usage.ru_utime + usage.ru_stime for usage in of)


def engines(variants: int) -> None:
    """Sweep a pole on a cart both ways in turn; print time per variant, and without the start of the processes."""
    plan = fmb.study.latin_hypercube({"mass": (0.4, 0.8), "stiffness": (1.0, 4.0)}, variants)
    few = fmb.study.latin_hypercube({"mass": (0.4, 0.8), "stiffness": (1.0, 4.0)}, 2)
    for name, text in INTEGRATORS.items():
        with TemporaryDirectory() as folder:
            model = Path(folder) / "cart.toml"
            model.write_text(CART % text)
            figures, tables = {}, {}
            for engine in ("compiled", "processes"):
                fmb.sweep(model, few, outputs=["peak(tip x)"], engine=engine)  # kernels
                marks = [(time.perf_counter(), spent())]
                fmb.sweep(model, few, outputs=["peak(tip x)"], engine=engine)
                marks.append((time.perf_counter(), spent()))
                tables[engine] = fmb.sweep(model, plan, outputs=["peak(tip x)"], engine=engine)["peak(tip x)"]
                marks.append((time.perf_counter(), spent()))
                (start, cpu0), (whole, cpu) = (
                    [1e3 * (b - a) for a, b in zip(*pair, strict=True)] for pair in pairwise(marks)
                )
                figures[engine] = whole / variants, cpu / variants, (cpu - cpu0) / (variants - 2)
                print(
                    f"{name}, {engine}: {whole / variants:.2f} ms wall and {cpu / variants:.2f} ms CPU a variant, "
                    f"{figures[engine][2]:.2f} without the start ({start:.0f} ms); load {os.getloadavg()[0]:.1f}"
                )
            shares = [one / two for one, two in zip(figures["compiled"], figures["processes"], strict=True)]
            print(f"{name}: shares {', '.join(f'{share:.2f}' for share in shares)} of the processes' time; ", end="")
            print(f"largest difference {abs(tables['compiled'] - tables['processes']).max():.1g} m")


def turns(variants: int) -> None:
    """Compute variants of a pendulum and of the cart both ways by turns; print lower quartiles of the time of one."""
    plan = fmb.study.latin_hypercube({"mass": (0.4, 0.8), "stiffness": (1.0, 4.0)}, variants)
    for name, text in INTEGRATORS.items():
        for mechanism, described in (("pendulum", PENDULUM), ("cart", CART)):
            with TemporaryDirectory() as folder:
                model = Path(folder) / "model.toml"
                model.write_text(described % text)
                origin, spent_on = ModelFile(str(model)), ([], [])
                ways = Task(Ensemble(origin), ["peak(tip x)"]), Task(origin, ["peak(tip x)"])
                for k in range(-3, variants):  # the first ones compile
                    rows = []
                    for way, spent_by in zip(ways, spent_on, strict=True):
                        clock = time.process_time()
                        rows.append(way.row(k + 1, plan.variant(max(k, 0))).values)
                        spent_by += [time.process_time() - clock] if k >= 0 else []
                    assert rows[0] == rows[1]
            one, two = (1e3 * sorted(times)[variants // 4] for times in spent_on)
            print(f"{name}, {mechanism}: {one:.1f} ms a variant, {two:.1f} in a process: {one / two:.2f}", flush=True)


def main() -> None:
    variants = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    if "engines" in sys.argv:
        engines(variants)
        return
    if "turns" in sys.argv:
        turns(variants)
        return
    source = Path(str(files("flexmb") / "cli" / "demo_data"))
    station = source / "flap_station.toml"
    measured(station, 2, 1)  # kernels, and the lever
    one, two = (measured(station, variants, jobs) for jobs in (1, 2))
    print(f"two processes are {one / two:.2f} times as fast as one: {50 * one / two:.0f} % of linear")


if __name__ == "__main__":
    main()

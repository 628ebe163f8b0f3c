"""Flexible trees: time of an evaluation beside sparse and dense solutions in the coordinates of all bodies.

    python benchmarks/antenna.py                    # the antenna of examples/wrap_rib_antenna.py, 16 to 160 segments
    python benchmarks/antenna.py --links 10 100     # chains of reduced beams with six modes on hinges

Links: an evaluation of an explicit run in joint coordinates, second rates of all joints and modes with all forces;
also with the boom made rigid. General: the recursion over bodies of any kind, with all reactions. Sparse and dense:
`Augmented`, and NumPy's solution of the same equations. Least CPU time of several blocks, one thread.
"""

from __future__ import annotations

import argparse
import os
import runpy
import time
from pathlib import Path

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import numpy as np  # noqa: E402 (one thread: set before it is loaded)
from tree import dense, repeat  # noqa: E402

import flexmb as fmb  # noqa: E402
from flexmb import fem, reduction  # noqa: E402
from flexmb.system import assemble  # noqa: E402


def least_time(call, count: int, blocks: int = 7) -> float:
    """Return the least CPU time of one of `count` calls, s."""
    call(1)
    spent = []
    for _ in range(blocks):
        clock = time.process_time()
        call(count)
        spent.append((time.process_time() - clock) / count)
    return min(spent)


def again(call):
    """Return a function that repeats a call."""

    def repeated(count: int) -> None:
        for _ in range(count):
            call()

    return repeated


def chain(n: int, stiffened: bool = True) -> fmb.Model:
    """Return n reduced beams with six modes on hinges, one behind the other."""
    points = np.column_stack([np.linspace(0.0, 1.0, 11), np.zeros(11), np.zeros(11)])
    fe = fem.frame(points=points, section=fem.Section.rectangle(0.02, 0.03), material=fmb.MATERIALS["aluminium"])
    data = reduction.reduce(fe, interfaces={"root": [0], "tip": [10]}, modes=0, geometric_stiffness=stiffened)
    beams = [fmb.FloatingBody(f"b{k}", data=data, at=(k, 0, 0)) for k in range(n)]
    ends = ["ground.origin"] + [f"b{k}.tip" for k in range(n)]
    joints = [fmb.Revolute(f"j{k}", markers=(ends[k], f"b{k}.root")) for k in range(n)]
    return fmb.Model(gravity=(0, -9.81, 0), bodies=[fmb.Ground(), *beams], joints=joints)


def times(model, others: bool = True, with_dense: bool = True) -> dict[str, float]:
    """Return the time of an evaluation by each way, s."""
    system, start = assemble(model)
    work = system.workspace()
    unknowns = fmb.Recursive().unknowns(system, start, work)
    x, v, _ = unknowns.of(start)
    v = v + 0.01
    count = max(3, 20000 // len(v))
    found = {"links": least_time(lambda n: repeat(unknowns.links, work, 0.0, x, v, n), count)}
    if others:
        state, count = unknowns.state(0.0, x.copy(), v.copy()), max(2, 500 // len(v))
        for name, way in (("general", fmb.Recursive()), ("sparse", fmb.Augmented())):
            found[name] = least_time(again(lambda way=way: way.accelerate(system, state, work)), count)
        if with_dense:
            found["dense"] = least_time(again(lambda: dense(system, state, work)), 1, 2)
    return found


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--segments", type=int, nargs="+", default=[1, 2, 4, 10], help="of each of 16 ribs")
    parser.add_argument("--links", type=int, nargs="*", default=[])
    options = parser.parse_args()
    example = runpy.run_path(str(Path(__file__).parents[1] / "examples" / "wrap_rib_antenna.py"))
    for n in options.segments:
        found = times(example["antenna"](ribs=16, segments=n))
        found["links, boom rigid"] = times(example["antenna"](ribs=16, segments=n, rigid=True), others=False)["links"]
        line = ", ".join(f"{name} {1e3 * value:.3f}" for name, value in found.items())
        ratios = ", ".join(f"{name} {found[name] / found['links']:.1f}" for name in ("sparse", "dense"))
        print(f"antenna of {16 * n} segments: ms {line}; times the links: {ratios}", flush=True)
    for n in options.links:
        for stiffened in (True, False):
            found = times(chain(n, stiffened), others=n <= 1000, with_dense=n <= 100)
            line = ", ".join(f"{name} {1e6 * value / n:.2f}" for name, value in found.items())
            print(
                f"chain of {n} links, {'with' if stiffened else 'without'} stiffening: us per link {line}", flush=True
            )


if __name__ == "__main__":
    main()

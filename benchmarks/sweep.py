"""A sweep of 100 variants of the flap station: one process beside two, start of the processes included.

Wall time says how much faster two processes are, if nobody else uses the cores; to see through other load, the second
line of each run says which share of the processes' time was spent on variants, and the CPU seconds they took in all:
two processes are twice as fast if both shares are near 1 and the CPU seconds are equal. Run with
``python benchmarks/sweep.py [variants]``.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from importlib.resources import files
from pathlib import Path

import flexmb as fmb
from flexmb import fem, reduction


def measured(model: Path, variants: int, lever: Path, jobs: int) -> float:
    """Sweep, print the figures, and return the wall time."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    plan = fmb.study.latin_hypercube({"pressure": (3e3, 6e3), "damping": (0.01, 0.05)}, variants)
    results = fmb.sweep(model, plan, outputs=["peak(strut force fx)"], parameters={"lever": str(lever)}, jobs=jobs)
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    busy = sum(row.seconds for row in results.rows)
    assert not results.failed
    print(f"{jobs} processes: {wall:7.1f} s wall, load average {os.getloadavg()[0]:.1f}")
    print(f"             {100 * busy / (jobs * wall):5.1f} % of it on variants, {cpu:7.1f} s CPU")
    return wall


def main() -> None:
    variants = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    source = Path(str(files("flexmb") / "cli" / "demo_data"))
    with tempfile.TemporaryDirectory() as scratch:
        fe = fem.solid(fem.read_mesh(source / "lever_arm.msh"), fmb.MATERIALS["titanium"])
        bores = {"root": reduction.Averaging("bore_root"), "tip": reduction.Averaging("bore_tip")}
        lever = reduction.reduce(fe, interfaces=bores, modes=12, geometric_stiffness=True).save(
            Path(scratch) / "lever.h5"
        )
        measured(source / "flap_station.toml", 2, lever, 1)  # kernels
        one, two = (measured(source / "flap_station.toml", variants, lever, jobs) for jobs in (1, 2))
        print(f"two processes are {one / two:.2f} times as fast as one: {50 * one / two:.0f} % of linear")


if __name__ == "__main__":
    main()

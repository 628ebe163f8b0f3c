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
import time
from importlib.resources import files
from pathlib import Path

import flexmb as fmb


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


def main() -> None:
    variants = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    source = Path(str(files("flexmb") / "cli" / "demo_data"))
    station = source / "flap_station.toml"
    measured(station, 2, 1)  # kernels, and the lever
    one, two = (measured(station, variants, jobs) for jobs in (1, 2))
    print(f"two processes are {one / two:.2f} times as fast as one: {50 * one / two:.0f} % of linear")


if __name__ == "__main__":
    main()

"""How long a user waits before the first result: import, and a pendulum of one second with the default integrator.

Every row is a new process. "cold" has an empty cache and compiles for the processor; "wheel" has an empty cache too,
but takes the kernels that a wheel carries (`flexmb/compiled`; left out where there are none); "warm" finds its kernels
in the cache of the cold run. CPU time includes what children take.

Usage: python benchmarks/start.py
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

IMPORT = "import flexmb"
PENDULUM = """
import flexmb as fmb
arm = fmb.RigidBody("arm", mass=1.0, inertia=(0.1, 0.1, 0.1), at=(1, 0, 0), markers={"hinge": (-1, 0, 0)})
ground = fmb.Ground(markers={"hinge": (0, 0, 0)})
hinge = fmb.Revolute("hinge", markers=("ground.hinge", "arm.hinge"))
assert fmb.simulate(fmb.Model(bodies=[ground, arm], joints=[hinge], gravity=(0, 0, -9.81)), 1.0, samples=11).status
"""


def measured(code: str, **environment: str) -> tuple[float, float]:
    """Return the time by the clock and of the processor, s, of a new process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], env={**os.environ, "FLEXMB_QUIET": "1", **environment}, check=True)
    elapsed = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return elapsed, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    import flexmb

    shipped = any((Path(flexmb.__file__).parent / "compiled").glob("*/*"))
    with tempfile.TemporaryDirectory() as empty, tempfile.TemporaryDirectory() as other:
        import llvmlite.binding as llvm

        native = {"NUMBA_CPU_NAME": llvm.get_host_cpu_name()}  # a processor that is named takes no shipped kernels
        rows = {"import": measured(IMPORT), "cold": measured(PENDULUM, NUMBA_CACHE_DIR=empty, **native)}
        rows["warm"] = measured(PENDULUM, NUMBA_CACHE_DIR=empty, **native)
        if shipped:
            rows["wheel"] = measured(PENDULUM, NUMBA_CACHE_DIR=other)
    for name, (elapsed, processor) in rows.items():
        print(f"{name:8}  {elapsed:6.2f} s  {processor:6.2f} s CPU")


if __name__ == "__main__":
    main()

"""Compiled kernels that come with the package: for which processors, and what they were made with.

A wheel carries a folder of kernels (`flexmb/compiled`) that were compiled for a level of processors. A file is found by
its name, which holds the versions of numba and Python, so nothing has to be checked before it is used. The note beside
them says what they were made with, for the message where they cannot be used.
"""

from __future__ import annotations

import json
import platform
import shutil
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numba

__all__ = ["BASELINES", "SHIPPED", "lacking", "ship", "why_unused"]

SHIPPED = Path(__file__).parents[1] / "compiled"
"""Kernels that came with the package, compiled for a level of processors when the wheel was built."""
BASELINES = {
    "x86_64": ("x86-64-v3", "sse3 ssse3 sse4.1 sse4.2 popcnt cx16 sahf xsave avx avx2 bmi bmi2 f16c fma lzcnt movbe"),
    "aarch64": ("generic", "neon"),  # never tried
}
"""By architecture: the processor that shipped kernels are compiled for, and the features that it has."""
NOTE = "made_with.json"


def lacking(features: str) -> list[str]:
    """Return which of some features the processor that runs has not."""
    host = llvm.get_host_cpu_features()
    return [feature for feature in features.split() if not host.get(feature)]


def _versions() -> dict[str, str]:
    return {
        "numba": numba.__version__,
        "Python": f"{sys.version_info[0]}.{sys.version_info[1]}",
        "architecture": platform.machine(),
    }


def ship(made: Path, shipped: Path) -> int:
    """Put kernels that were compiled for a baseline into the package, in place of others; return their number."""
    shutil.rmtree(shipped, ignore_errors=True)
    files = [path for path in sorted(made.glob("*/*")) if not path.name.startswith(".")]
    for path in files:
        target = shipped / path.relative_to(made)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    (shipped / NOTE).write_text(json.dumps(_versions()))
    return len(files)


def why_unused(shipped: Path) -> str:
    """Return why the kernels that came with the package do not fit here; an empty text if they do or there are none."""
    try:
        made = json.loads((shipped / NOTE).read_text())
    except (OSError, ValueError):
        return ""
    here = _versions()
    for name, value in here.items():
        if made.get(name) != value:
            return f"the kernels in the package are for {name} {made.get(name)}, this is {value}"
    level, features = BASELINES.get(here["architecture"], ("", ""))
    missing = lacking(features)
    return f"the kernels in the package are for {level}, this processor lacks {', '.join(missing)}" if missing else ""

"""Mathematics without mechanics: kernels, vectors, rotations, tables, sparse factorisation and eigenmodes."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from platform import machine
from time import perf_counter
from typing import Any

from flexmb.math.ahead import SWITCH, compile_ahead, cores

__all__ = [
    "SWITCH",
    "compile_ahead",
    "compile_declared",
    "cores",
    "declared_kernels",
    "ship_kernels",
    "shipped_level",
    "watch_compilation",
]


def watch_compilation(
    announce: Callable[[], None], follow: Callable[[bool], None] = lambda begins: None
) -> Callable[[], float]:
    """Call `announce` when the first kernel of this process is compiled (none is if all come from the cache).

    `follow` is called with True whenever compiling begins, and with False when it ends.

    Returns
    -------
    callable () -> float
        The seconds spent compiling since then.
    """
    from numba.core import event

    class Watch(event.Listener):
        """Kernels compile the kernels they call: only the outermost counts."""

        seconds, depth, began = 0.0, 0, 0.0

        def on_start(self, event):
            if not self.depth:
                self.began = perf_counter()
                if not self.seconds:
                    announce()
                follow(True)
            self.depth += 1

        def on_end(self, event):
            self.depth -= 1
            if not self.depth:
                self.seconds += perf_counter() - self.began
                follow(False)

    watch = Watch()
    event.register("numba:compile", watch)
    return lambda: watch.seconds


def declared_kernels(package: str) -> list[Any]:
    """Return all kernels below a package whose signature is declared, in the order of their modules."""
    from flexmb.math.tables import PointerKernel

    found: dict[int, Any] = {}
    for module in walk_packages(import_module(package).__path__, f"{package}."):
        if not module.name.endswith("__main__"):
            for value in vars(import_module(module.name)).values():
                if isinstance(value, PointerKernel) or getattr(value, "entry", None) is not None:
                    found[id(value)] = value
    return list(found.values())


def compile_declared(package: str, part: int = 0, parts: int = 1) -> int:
    """Compile every `parts`-th of these kernels from number `part` on; return how many that are."""
    from flexmb.math.tables import PointerKernel

    kernels = declared_kernels(package)[part::parts]
    for kernel in kernels:
        _ = kernel.compiled if isinstance(kernel, PointerKernel) else kernel.compile(kernel.entry)
    return len(kernels)


def shipped_level() -> str:
    """Return the level of processors of this architecture for which a package carries kernels, or an empty text."""
    from flexmb.math.shipped_kernels import BASELINES

    return BASELINES.get(machine(), ("", ""))[0]


def ship_kernels(made: Path) -> int:
    """Put kernels that were compiled for that level into the package; return their number."""
    from flexmb.math.shipped_kernels import SHIPPED, ship

    return ship(made, SHIPPED)

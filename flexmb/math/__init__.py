"""Mathematics without mechanics: kernels, vectors, rotations, tables, sparse factorisation and eigenmodes."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

__all__ = ["watch_compilation"]


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

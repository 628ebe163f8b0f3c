"""What the processes of a run of the tests have used: processor time, and the most memory at one time."""

from __future__ import annotations

import os
import sys

import pytest


class Spent:
    """A plugin: each worker tells the controller, which writes one line; without workers the one process does."""

    def __init__(self):
        self.workers: list[tuple[str, float, float]] = []

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node, error):
        used = getattr(node, "workeroutput", {}).get("spent")
        if used is not None:
            self.workers.append((node.gateway.id, *used))

    def pytest_sessionfinish(self, session):
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["spent"] = spent()

    def pytest_terminal_summary(self, terminalreporter):
        for name, seconds, memory in self.workers or [("one process", *spent())]:
            terminalreporter.write_line(f"{name}: {seconds:.0f} s of processor time, {memory:.2f} GB at most")


def spent() -> tuple[float, float]:
    """Return the processor time, s, of this process and of its children that have ended, and its largest memory, GB."""
    if sys.platform == "win32":
        return sum(os.times()[:2]), float("nan")
    import resource

    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    unit = 1e9 if sys.platform == "darwin" else 1e6  # bytes there, kilobytes elsewhere
    seconds = sum(use.ru_utime + use.ru_stime for use in (own, children))
    return seconds, own.ru_maxrss / unit

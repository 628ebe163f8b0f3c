"""What the processes of a run of the tests have used: processor time, and the most memory at one time."""

from __future__ import annotations

import os
import sys

import pytest

RISE = 0.3
"""GB by which a test lets the largest memory of its process grow, to be named."""


class Spent:
    """A plugin: each worker tells the controller, which writes one line; without workers the one process does."""

    def __init__(self):
        self.workers: list[tuple[str, float, float]] = []
        self.rises: list[tuple[str, float]] = []

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        before = spent()[1]
        result = yield
        rise = spent()[1] - before
        if rise > RISE:
            self.rises.append((item.nodeid, rise))
        return result

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node, error):
        told = getattr(node, "workeroutput", {})
        if "spent" in told:
            self.workers.append((node.gateway.id, *told["spent"]))
            self.rises += map(tuple, told["rises"])

    def pytest_sessionfinish(self, session):
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput |= {"spent": spent(), "rises": self.rises}

    def pytest_terminal_summary(self, terminalreporter):
        for name, seconds, memory in self.workers or [("one process", *spent())]:
            terminalreporter.write_line(f"{name}: {seconds:.0f} s of processor time, {memory:.2f} GB at most")
        for name, rise in sorted(self.rises, key=lambda one: -one[1]):
            terminalreporter.write_line(f"{rise:.2f} GB more memory than ever before in its process: {name}")


def spent() -> tuple[float, float]:
    """Return the processor time, s, of this process and of its children that have ended, and its largest memory, GB."""
    if sys.platform == "win32":
        return sum(os.times()[:2]), float("nan")
    import resource

    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    unit = 1e9 if sys.platform == "darwin" else 1e6  # bytes there, kilobytes elsewhere
    seconds = sum(use.ru_utime + use.ru_stime for use in (own, children))
    return seconds, own.ru_maxrss / unit

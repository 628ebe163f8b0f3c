"""What the processes of a run of the tests have used: processor time and memory, and which tests used most of it."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from collections import Counter
from pathlib import Path

import pytest

RISE = 0.3
"""GB by which a test lets the largest memory of its process grow, to be named."""
KEPT = 0.05
"""GB that the tests of a file leave behind in all processes, to be named."""
LONG = 5.0
"""s of processor time of a test, to be named."""
FREED = 0.05
"""GB by which a process has grown after a file of tests, for what nobody holds any more to be given back."""


class Spent:
    """A plugin: each worker tells the controller, which writes one line; without workers the one process does."""

    def __init__(self):
        self.workers: list[tuple[str, float, float]] = []
        self.rises: list[tuple[str, float]] = []
        self.times: Counter[str] = Counter()
        """Processor time by test, s."""
        self.kept: Counter[str] = Counter()
        """Memory that is there after the tests of a file, and was not before, GB; of several processes together."""
        self.least = 0.0
        """Memory in use when it was given back, GB."""

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_teardown(self, item, nextitem):
        if (nextitem is None or nextitem.path != item.path) and held() > self.least + FREED:
            give_back()
            self.least = held()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        (seconds, peak), before = spent(), held()
        result = yield
        later, highest = spent()
        if highest - peak > RISE:
            self.rises.append((item.nodeid, highest - peak))
        self.times[item.nodeid] += later - seconds
        self.kept[item.nodeid.partition("::")[0]] += held() - before
        return result

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node, error):
        told = getattr(node, "workeroutput", {})
        if "spent" in told:
            self.workers.append((node.gateway.id, *told["spent"]))
            self.rises += map(tuple, told["rises"])
            self.times.update(told["times"])
            self.kept.update(told["kept"])

    def pytest_sessionfinish(self, session):
        if hasattr(session.config, "workeroutput"):
            long = {name: seconds for name, seconds in self.times.items() if seconds > LONG}
            own = {"times": long, "kept": dict(self.kept)}
            session.config.workeroutput |= {"spent": spent(), "rises": self.rises, **own}

    def pytest_terminal_summary(self, terminalreporter):
        for name, seconds, memory in self.workers or [("one process", *spent())]:
            terminalreporter.write_line(f"{name}: {seconds:.0f} s of processor time, {memory:.2f} GB at most")
        for name, rise in sorted(self.rises, key=lambda one: -one[1]):
            terminalreporter.write_line(f"{rise:.2f} GB more memory than ever before in its process: {name}")
        for words, counted, least in (("GB left behind", self.kept, KEPT), ("s of processor time", self.times, LONG)):
            for name, amount in counted.most_common():
                if amount > least:
                    terminalreporter.write_line(f"{amount:.2f} {words}: {name}")


def spent() -> tuple[float, float]:
    """Return the processor time, s, of this process and of its children that have ended, and its largest memory, GB."""
    if sys.platform == "win32":
        return sum(os.times()[:2]), float("nan")
    import resource

    own, children = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    unit = 1e9 if sys.platform == "darwin" else 1e6  # bytes there, kilobytes elsewhere
    seconds = sum(use.ru_utime + use.ru_stime for use in (own, children))
    return seconds, own.ru_maxrss / unit


def give_back() -> None:
    """Free what only circles hold, and give the system back what is free: the allocator of Linux would keep it."""
    gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # other libraries have none
        if trim is not None:
            trim(0)


def held() -> float:
    """Return the memory of this process that is in use now, GB; 0 where the system has no such file."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e9

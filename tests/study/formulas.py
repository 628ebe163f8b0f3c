"""Functions that the workers of the tests compute; they import this module."""

import os
import signal
import time
from pathlib import Path

from numba import njit

import flexmb as fmb


def square(x, offset=0.0):
    """Return x^2 + offset; 13 kills the process, a negative x is refused."""
    if x == 13:
        os.kill(os.getpid(), signal.SIGKILL)
    if x < 0:
        raise ValueError(f"no root of {x}")
    return {"y [m2]": x * x + offset}


def counted(x, folder):
    """Return x, and leave a trace of the call; 13 ends the process the first time."""
    trace = Path(folder) / str(x)
    calls = int(trace.read_text()) if trace.exists() else 0
    trace.write_text(str(calls + 1))
    if x == 13 and calls == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def slow(x):
    time.sleep(60.0 if x == 99 else 0.0)
    return x


def stone(g):
    """Return a model: a mass that falls from rest."""
    return fmb.Model(
        gravity=(0, 0, -g),
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=2.0)],
        sensors=[fmb.Position("place", marker="stone.center")],
    )


def thrown(g):
    return fmb.simulate(stone(g), 1.0, samples=3)


def wrong(x):
    return "no number"


@njit(cache=True)
def _sum_of_squares(n):
    total = 0.0
    for k in range(n):
        total += k * k
    return total


def compiled(x):
    """Return how often this process has compiled the kernel: 0 if it came from the cache."""
    before = sum(_sum_of_squares.stats.cache_misses.values())
    _sum_of_squares(int(x))
    return sum(_sum_of_squares.stats.cache_misses.values()) - before

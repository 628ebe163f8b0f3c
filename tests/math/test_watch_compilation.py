"""The first compilation of a process is announced and timed; code from the cache is not."""

from numba import njit

from flexmb.math import watch_compilation


def test_compilation_is_announced_once_and_timed():
    @njit
    def inner(x):
        return x + 1.0

    @njit
    def outer(x):
        return inner(x) * 2.0

    said = []
    seconds = watch_compilation(lambda: said.append("compiling"))
    assert seconds() == 0.0
    assert outer(1.0) == 4.0
    first = seconds()
    assert first > 0.0
    assert outer(2.0) == 6.0
    assert seconds() == first
    assert outer(1) == 4.0  # another type: compiled again, not announced again
    assert seconds() > first
    assert said == ["compiling"]

"""Arrays are written to parts of others as numpy does it; the error for other sizes has a constant text."""

import os
import subprocess
import sys

import numpy as np
import pytest

from flexmb.math import unequal_sizes
from flexmb.math.kernel import kernel

COMPILED = """
import numpy as np
from numba.core import event

class Names(event.Listener):
    def __init__(self):
        self.names = set()

    def on_start(self, one):
        self.names.add(one.data["dispatcher"].py_func.__module__)

    def on_end(self, one):
        pass

names = Names()
event.register("numba:compile", names)
from flexmb.math.kernel import kernel

@kernel
def write(out, x):
    out[1:4] = x

out = np.zeros(5)
write(out, np.ones(3))
assert list(out) == [0, 1, 1, 1, 0]
print(any("unicode" in name for name in names.names))
"""


@kernel
def write(out, x):
    out[1:4] = x


@kernel
def write_rows(out, x):
    out[1:, ::2] = x


@kernel
def write_three(out, x):
    out[:] = (x, x + 1.0, x + 2.0)


def test_numbers_are_written_as_numpy_writes_them(rng):
    for x in (rng.normal(size=3), rng.normal(size=1), rng.normal(size=6)[::2]):
        ours, theirs = np.zeros(5), np.zeros(5)
        write(ours, x)
        theirs[1:4] = x
        assert np.array_equal(ours, theirs)
    for x in (rng.normal(size=(2, 2)), rng.normal(size=2), rng.normal(size=(2, 1))):
        ours, theirs = np.zeros((3, 4)), np.zeros((3, 4))
        write_rows(ours, x)
        theirs[1:, ::2] = x
        assert np.array_equal(ours, theirs)
    ours = np.zeros(3)
    write_three(ours, 4.0)
    assert list(ours) == [4.0, 5.0, 6.0]


def test_parts_of_one_array_may_overlap():
    x = np.arange(6.0)
    write(x, x[2:5])
    assert list(x) == [0, 2, 3, 4, 4, 5]
    write(x, x[:3])
    assert list(x) == [0, 0, 2, 3, 4, 5]


@pytest.mark.parametrize(
    ("kernel_", "out", "x"),
    [
        (write, np.zeros(5), np.zeros(2)),
        (write, np.zeros(5), np.zeros(0)),
        (write_rows, np.zeros((3, 4)), np.zeros((2, 3))),
        (write_three, np.zeros(4), 1.0),
    ],
)
def test_other_sizes_are_refused(kernel_, out, x):
    with pytest.raises(ValueError, match=unequal_sizes.MESSAGE):
        kernel_(out, x)
    assert not out.any()


def test_from_python_it_raises_the_same():
    with pytest.raises(ValueError, match=unequal_sizes.MESSAGE):
        unequal_sizes.refuse((2,), (3,))


def test_no_function_of_texts_is_compiled(tmp_path):
    """They took 4.6 of the 4.9 s of processor time for which such a kernel was compiled."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "FLEXMB_QUIET": "1", "FLEXMB_AHEAD": "0"}
    child = subprocess.run(
        [sys.executable, "-c", COMPILED], env=environment, capture_output=True, text=True, check=True, timeout=600
    )
    assert child.stdout.split() == ["False"]

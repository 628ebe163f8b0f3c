"""What is compiled is announced once and timed; what is known already is not."""

import numpy as np

from flexmb.math import watch_compilation
from flexmb.math.kernel import kernel


def test_first_compilation_is_announced(tmp_path, monkeypatch):
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path))  # nothing was compiled there before

    @kernel
    def twice(x):
        return 2.0 * x

    said = []
    seconds = watch_compilation(lambda: said.append("compiling"))
    assert seconds() == 0.0
    assert twice(np.float64(3.0)) == 6.0
    first = seconds()
    assert first > 0.0
    assert twice(np.float64(4.0)) == 8.0
    assert seconds() == first
    assert said == ["compiling"]

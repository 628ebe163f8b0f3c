"""What a run of the tests says of its processes at the end."""

from types import SimpleNamespace

import pytest
from spent import Spent, spent


def test_workers_tell_their_time_and_memory():
    told, lines = Spent(), []
    worker = SimpleNamespace(config=SimpleNamespace(workeroutput={}))
    told.pytest_sessionfinish(worker)
    node = SimpleNamespace(gateway=SimpleNamespace(id="gw0"), workeroutput=worker.config.workeroutput)
    told.pytest_testnodedown(node, None)
    told.pytest_testnodedown(SimpleNamespace(), "a worker that crashed tells nothing")
    told.pytest_terminal_summary(SimpleNamespace(write_line=lines.append))
    (line,) = lines
    assert line.startswith("gw0: ")
    assert line.endswith(" GB at most")
    assert 0.01 < spent()[1] < 100.0


def test_a_test_that_takes_much_more_memory_than_all_before_is_named(monkeypatch):
    peaks = iter([0.5, 0.9, 0.9, 1.0])
    monkeypatch.setattr("spent.spent", lambda: (1.0, next(peaks)))
    told, controller, lines = Spent(), Spent(), []
    for name in ("tests/a.py::large", "tests/b.py::small"):
        running = told.pytest_runtest_protocol(SimpleNamespace(nodeid=name))
        next(running)
        with pytest.raises(StopIteration):
            running.send(True)
    peaks = iter([1.0])
    worker = SimpleNamespace(config=SimpleNamespace(workeroutput={}))
    told.pytest_sessionfinish(worker)
    controller.pytest_testnodedown(
        SimpleNamespace(gateway=SimpleNamespace(id="gw0"), workeroutput=worker.config.workeroutput), None
    )
    controller.pytest_terminal_summary(SimpleNamespace(write_line=lines.append))
    assert lines[1:] == ["0.40 GB more memory than ever before in its process: tests/a.py::large"]

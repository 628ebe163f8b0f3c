"""What a run of the tests says of its processes at the end."""

import gc
from types import SimpleNamespace

import numpy as np
import pytest
from spent import Spent, give_back, held, spent


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


def test_long_tests_and_files_that_leave_memory_behind_are_named(monkeypatch):
    """Of all workers together: tests by processor time, files by the memory that is in use after their tests."""
    seconds, memory = iter([0.0, 7.0, 7.0, 8.0, 9.0, 0.0, 1.0, 2.0]), iter([0.2, 0.22, 0.22, 0.24, 0.2, 0.24])
    monkeypatch.setattr("spent.spent", lambda: (next(seconds), 0.5))
    monkeypatch.setattr("spent.held", lambda: next(memory))
    controller, lines = Spent(), []
    for names in (("a.py::long", "a.py::short"), ("a.py::other",)):
        told = Spent()
        for name in names:
            running = told.pytest_runtest_protocol(SimpleNamespace(nodeid=name))
            next(running)
            with pytest.raises(StopIteration):
                running.send(True)
        worker = SimpleNamespace(config=SimpleNamespace(workeroutput={}))
        told.pytest_sessionfinish(worker)
        node = SimpleNamespace(gateway=SimpleNamespace(id="gw"), workeroutput=worker.config.workeroutput)
        controller.pytest_testnodedown(node, None)
    controller.pytest_terminal_summary(SimpleNamespace(write_line=lines.append))
    assert lines[2:] == ["0.08 GB left behind: a.py", "7.00 s of processor time: a.py::long"]


def test_memory_in_use_is_that_of_this_process():
    pytest.importorskip("resource")
    before = held()
    numbers = bytearray(100_000_000)
    assert held() == 0.0 or held() - before == pytest.approx(0.1, abs=0.02)
    assert len(numbers) == 100_000_000


@pytest.mark.skipif(held() == 0.0, reason="the system does not tell what memory is in use")
def test_what_only_circles_hold_is_given_back():
    one = SimpleNamespace(array=np.ones(4_000_000))
    one.own = one
    gc.disable()
    try:
        del one
        before = held()
        give_back()
    finally:
        gc.enable()
    assert held() < before - 0.03

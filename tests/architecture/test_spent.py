"""What a run of the tests says of its processes at the end."""

from types import SimpleNamespace

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

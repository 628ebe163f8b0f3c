"""The suite's workers share the rewriting of assertions: each file once, and pytest reads what was kept."""

import sys
from pathlib import Path

import pytest
from _pytest.assertion import rewrite
from rewritten import files_of, rewrite_own_share, share

TESTS = Path(__file__).parents[1]


@pytest.mark.parametrize("count", [1, 2, 7])
def test_shares_are_equal_and_hold_each_file_once(count):
    paths = sorted(TESTS.rglob("test_*.py"))
    shares = [share(paths, k, count) for k in range(count)]
    assert [path for each in shares for path in each] == paths
    sizes = [sum(path.stat().st_size for path in each) for each in shares]
    assert max(sizes) - min(sizes) <= 2 * max(path.stat().st_size for path in paths)


def test_files_without_text(tmp_path):
    (tmp_path / "test_one.py").write_text("")
    assert [share([tmp_path / "test_one.py"], k, 2) for k in (0, 1)] == [[tmp_path / "test_one.py"], []]
    assert share([], 0, 2) == []


def test_what_a_worker_keeps_is_read(request, monkeypatch, tmp_path):
    path = tmp_path / "test_one.py"
    path.write_text("def test():\n    assert 1 + 1 == 2\n")
    (tmp_path / "helper.py").write_text("assert True\n")
    monkeypatch.setattr(request.config, "args", [str(tmp_path)])
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)
    monkeypatch.setenv("PYTEST_XDIST_WORKER", "gw0")
    monkeypatch.setenv("PYTEST_XDIST_WORKER_COUNT", "1")
    assert files_of(request.config) == [path]
    rewrite_own_share(request.config)
    (kept,) = (tmp_path / "__pycache__").iterdir()
    assert rewrite._read_pyc(path, kept) is not None


def test_one_process_rewrites_while_it_collects(request, monkeypatch, tmp_path):
    (tmp_path / "test_one.py").write_text("")
    monkeypatch.setattr(request.config, "args", [str(tmp_path)])
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)
    rewrite_own_share(request.config)
    assert not (tmp_path / "__pycache__").exists()

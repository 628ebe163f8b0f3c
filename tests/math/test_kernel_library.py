"""Large kernels are called by machine code, not copied into it; what is kept of them fits together or is made again."""

import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from flexmb.math import kernel_cache, kernel_library

LARGE = "\n".join(f"    out[{k}] = x[{k}] * x[{(k + 1) % 40}] + {k}.5 * x[{(k + 2) % 40}]" for k in range(40))
PARTS = f"""
from flexmb.math.kernel import kernel

@kernel
def large(x, out):
{LARGE}

@kernel
def small(x):
    return 2.0 * x
"""
TOP = """
from flexmb.math.kernel import kernel
from .parts import large, small

@kernel
def outer(x, out):
    large(x, out)
    out[0] += small(x[0])
"""
USE = """
import sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
from scratch.top import outer, large
x, out = np.arange(40.0), np.zeros(40)
outer(x, out)
print(repr(float(out.sum())), *(sum(k.stats.cache_hits.values()) for k in (outer, large)))
"""
X = np.arange(40.0)
SUM = float(np.sum(X * np.roll(X, -1) + (np.arange(40) + 0.5) * np.roll(X, -2)))  # 2 x[0] is zero


@pytest.fixture
def use(tmp_path, monkeypatch):
    """Return what a new process gets from two files of kernels, and how often it found machine code on disk."""
    home = tmp_path / "scratch"
    home.mkdir()
    for name, text in {"__init__": "", "parts": PARTS, "top": TOP}.items():
        (home / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)  # what is kept of a kernel names its module
    for name in ("scratch", "scratch.parts", "scratch.top"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tmp_path), *sys.path]),
        "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }

    def run():
        command = [sys.executable, "-c", USE]
        child = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, cwd=tmp_path)
        total, *hits = child.stdout.split()
        return float(total), tuple(map(int, hits))

    yield run
    for name in [name for name in sys.modules if name.partition(".")[0] == "scratch"]:
        del sys.modules[name]


def kept(tmp_path, name):
    (path,) = (tmp_path / "cache").rglob(f"{name}-*")
    content = path.read_bytes()[len(kernel_cache.FORMAT) + kernel_cache.CHECK :]
    return path, pickle.loads(content)[0]


def test_a_large_kernel_is_called_and_a_small_one_is_copied(use, tmp_path):
    assert use() == (SUM, (0, 0))
    _, (_, code, copy, _, calls, own) = kept(tmp_path, "outer")
    assert [call.name for call in calls] == ["large"]
    assert own is None  # itself small
    _, (_, large, no_copy, symbols, _, callee) = kept(tmp_path, "large")
    assert no_copy is None
    assert calls == [callee]
    assert callee.symbol in symbols
    assert copy is not None
    assert len(code) < len(large)


def test_the_next_process_loads_both(use):
    use()
    assert use() == (SUM, (1, 1))


def test_a_called_kernel_that_is_gone_is_compiled_again(use, tmp_path):
    use()
    path, _ = kept(tmp_path, "large")
    path.unlink()
    assert use() == (SUM, (1, 0))
    assert path.exists()


def test_another_content_has_another_symbol(use, tmp_path):
    use()
    parts = tmp_path / "scratch" / "parts.py"
    parts.write_text(PARTS.replace("+ 1.5", "+ 3.5"))
    total, hits = use()
    assert (total, hits) == (SUM + 2.0 * X[3], (0, 0))
    assert len(list((tmp_path / "cache").rglob("outer-*"))) == 2


@pytest.mark.slow
def test_code_that_calls_what_is_not_there_is_compiled_again(use, tmp_path):
    """A file whose called kernel has another symbol (written by a process that could not name it) is not trusted."""
    use()
    path, _ = kept(tmp_path, "outer")
    raw = path.read_bytes()
    parts = list(pickle.loads(raw[len(kernel_cache.FORMAT) + kernel_cache.CHECK :]))
    name, code, copy, symbols, (call,), own = parts[0]
    other = kernel_library.Callee(call.module, call.name, call.arguments, call.symbol + "x")
    parts[0] = name, code, copy, symbols, [other], own
    kernel_cache._write(path, pickle.dumps(tuple(parts)))
    assert use() == (SUM, (0, 1))


def test_equal_functions_of_one_process_do_not_share_a_symbol():
    from flexmb.math.kernel import kernel

    def half(x):
        return 0.5 * x

    first, second = kernel(half), kernel(half)
    for made in (first, second):
        made._cache.disable()
    assert (first(3.0), second(3.0)) == (1.5, 1.5)
    names = {next(iter(made.overloads.values())).fndesc.llvm_func_name for made in (first, second)}
    assert len(names) == 2


def test_two_processes_compile_a_kernel_once(use, tmp_path):
    """Both begin with an empty cache at the same time: one has compiled `outer`, the other has found it."""
    with ThreadPoolExecutor(2) as pool:
        results = [one.result() for one in [pool.submit(use), pool.submit(use)]]
    assert [total for total, _ in results] == [SUM, SUM]
    assert sorted(hits[0] for _, hits in results) == [0, 1]
    assert not list((tmp_path / "cache").rglob("*.lock"))

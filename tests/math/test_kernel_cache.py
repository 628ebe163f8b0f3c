"""Kept machine code is used when all that it was made from is the same, and only then; no file can harm."""

import importlib
import os
import pickle
import platform
import re
import subprocess
import sys
from collections import namedtuple
from hashlib import blake2b
from pathlib import Path

import numba
import numpy as np
import pytest

from flexmb.math import kernel_cache, shipped_kernels
from flexmb.math.kernel import kernel

NUMBERS = """
SIN, COS = 20, 21
"""
MIDDLE = """
from .numbers import COS, SIN
from flexmb.math.kernel import kernel

TABLE = {"sin": SIN, "cos": COS}

@kernel
def chosen(operation, x):
    return x if operation == SIN else -x
"""
TOP = """
from . import middle
from .middle import TABLE, chosen
from flexmb.math.kernel import kernel

OPERATION = TABLE["sin"]

@kernel
def outer(x):
    return chosen(20, x)

@kernel
def by_module(x):
    return x * middle.SIN
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache of kernels; numba reads its settings anew when an earlier test has changed the environment."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Write a small package of three files somewhere and import its kernels afresh."""
    for name in ("numbers", "middle", "top"):
        monkeypatch.delitem(sys.modules, f"scratch.{name}", raising=False)

    def load(where, numbers=NUMBERS, middle=MIDDLE, top=TOP):
        home = tmp_path / where / "scratch"
        home.mkdir(parents=True, exist_ok=True)
        for name, text in {"__init__": "", "numbers": numbers, "middle": middle, "top": top}.items():
            (home / f"{name}.py").write_text(text)
        for name in [name for name in sys.modules if name.partition(".")[0] == "scratch"]:
            del sys.modules[name]
        monkeypatch.setattr(sys, "path", [str(home.parent), *sys.path])
        monkeypatch.setattr(sys, "dont_write_bytecode", True)  # an edit within the same second
        importlib.invalidate_caches()
        return importlib.import_module("scratch.top")

    yield load
    for name in [name for name in sys.modules if name.partition(".")[0] == "scratch"]:
        del sys.modules[name]


def hits(compiled):
    return sum(compiled.stats.cache_hits.values())


def test_constants_two_imports_away_are_part_of_the_code(folder, package):
    top = package("here")
    assert (top.outer(2.0), top.by_module(2.0)) == (2.0, 40.0)
    top = package("here", numbers="SIN, COS = 21, 20")
    assert (top.outer(2.0), top.by_module(2.0)) == (-2.0, 42.0)
    assert hits(top.outer) == hits(top.by_module) == 0


def test_code_of_called_kernels_is_part_of_the_code(folder, package):
    assert package("here").outer(2.0) == 2.0
    top = package("here", middle=MIDDLE.replace("return x if", "return 3.0 * x if"))
    assert top.outer(2.0) == 6.0


def test_another_place_time_and_comment_change_nothing(folder, package):
    package("here").outer(2.0)
    files = sorted(folder.rglob("*-*"))
    top = package("there", top="# moved down by a comment\n" + TOP, middle="import math\n" + MIDDLE)
    for path in Path(top.__file__).parent.iterdir():
        os.utime(path, (1.0, 1.0))
    assert top.outer(2.0) == 2.0
    assert hits(top.outer) == 1
    assert sorted(folder.rglob("*-*")) == files


def test_names_of_the_fields_of_arguments_are_part_of_the_key(folder):
    def second(pair):
        return pair.b

    def with_fields(fields):
        made = namedtuple("Pair", fields)
        made.__qualname__ = "Pair"
        return made(np.float64(1.0), np.float64(2.0))

    assert kernel(second)(with_fields("a b")) == 2.0
    assert kernel(second)(with_fields("b a")) == 1.0
    again = kernel(second)
    assert again(with_fields("a b")) == 2.0
    assert hits(again) == 1


def test_the_compiler_is_part_of_the_name(folder, monkeypatch):
    """Its files are those that `kernel_library` imports, with their own imports, but for what names code."""
    kernel(twice)(3.0)
    monkeypatch.setattr(kernel_cache, "compiler_digest", lambda: "another")
    other = kernel(twice)
    assert other(3.0) == 6.0
    assert hits(other) == 0
    assert len(list(folder.rglob("*-*"))) == 2

    home, reached, ahead = Path(kernel_cache.__file__).parent, set(), {"kernel_library"}
    while ahead:
        name = ahead.pop()
        reached.add(name)
        ahead |= set(re.findall(r"^from flexmb\.math\.(\w+) import", (home / f"{name}.py").read_text(), re.M)) - reached
    assert reached - {"kernel_content"} == set(kernel_cache.COMPILER)


@pytest.mark.slow
def test_swapped_operations_are_compiled_again(tmp_path):
    """The numbers of two operations of expressions are swapped in a copy of the package: sin(0.5) stays sin(0.5)."""
    source = Path(kernel_cache.__file__).parents[1]
    copy = tmp_path / "copy" / "flexmb"
    for path in source.rglob("*.py"):
        target = copy / path.relative_to(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(path.read_bytes())
    command = [sys.executable, "-P", "-c", 'import flexmb; print(flexmb.expression("sin(t)").sample(0.5)[0])']
    environment = {**os.environ, "PYTHONPATH": str(copy.parent), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def sampled():
        child = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, cwd=tmp_path)
        return float(child.stdout)

    assert sampled() == pytest.approx(0.479425538604203, abs=1e-15)
    numbers = copy / "math" / "operations.py"
    text = numbers.read_text()
    assert "SIN, COS, TAN" in text
    numbers.write_text(text.replace("SIN, COS, TAN", "COS, SIN, TAN", 1))
    assert sampled() == pytest.approx(0.479425538604203, abs=1e-15)


def one_file(folder):
    (path,) = folder.rglob("*-*")
    return path


def twice(x):
    return 2.0 * x


def test_file_is_used_by_the_next_process(folder):
    assert kernel(twice)(3.0) == 6.0
    later = kernel(twice)
    assert later(3.0) == 6.0
    assert hits(later) == 1


def checked(content):
    return kernel_cache.FORMAT + blake2b(content, digest_size=kernel_cache.CHECK).digest() + content


def flipped(raw):
    return raw[: len(raw) // 2] + bytes([raw[len(raw) // 2] ^ 1]) + raw[len(raw) // 2 + 1 :]


@pytest.mark.parametrize(
    "damage",
    [
        lambda raw: b"",
        lambda raw: raw[:10],
        lambda raw: raw[:40],
        lambda raw: raw[: len(raw) // 2],
        lambda raw: raw[:-1],
        flipped,
        lambda raw: b"\x00" * len(raw),
        lambda raw: checked(b""),
        lambda raw: checked(raw[:1000]),
        lambda raw: checked(pickle.dumps(("of", "another", "release"))),
        lambda raw: checked(pickle.dumps(3)),
    ],
    ids=["empty", "header", "start", "half", "last", "flipped", "zeros", "nothing", "pickle", "release", "number"],
)
def test_damaged_file_is_made_again(folder, damage):
    kernel(twice)(3.0)
    path = one_file(folder)
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    again = kernel(twice)
    assert again(3.0) == 6.0
    assert hits(again) == 0
    later = kernel(twice)
    assert later(3.0) == 6.0
    assert hits(later) == 1


def test_folder_in_the_place_of_a_file_does_no_harm(folder, recwarn):
    kernel(twice)(3.0)
    path = one_file(folder)
    path.unlink()
    path.mkdir()
    assert kernel(twice)(3.0) == 6.0


def test_no_folder_can_be_made(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "file"))
    with pytest.warns(RuntimeWarning, match="cannot be kept in .* Set NUMBA_CACHE_DIR"):
        assert kernel(twice)(3.0) == 6.0
    assert kernel(twice)(4.0) == 8.0  # said once


def test_settings_read_anew_while_compiling_leave_no_lock(folder, monkeypatch):
    """numba does so after a change of the environment: the file appears where its lock is, which ends."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folder.with_name("other")))
    monkeypatch.setenv("NUMBA_DUMP_IR", "0")
    assert kernel(twice)(3.0) == 6.0
    assert numba.config.CACHE_DIR == str(folder.with_name("other"))
    assert one_file(folder).name.startswith("twice-")


def test_half_written_file_is_never_seen(folder, monkeypatch):
    def full(*names):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    with pytest.warns(RuntimeWarning, match="No space left"):
        assert kernel(twice)(3.0) == 6.0
    assert not [path for path in folder.rglob("*") if path.is_file()]


def test_files_long_unused_are_removed(folder, monkeypatch):
    kernel(twice)(3.0)
    old = one_file(folder)
    os.utime(old, (1.0, 1.0))
    kernel(twice)(3)
    assert one_file(folder) != old


def test_flush_removes_the_files(folder):
    compiled = kernel(twice)
    compiled(3.0)
    compiled._cache.flush()
    assert not list(folder.rglob("*-*"))


FEATURES = shipped_kernels.BASELINES["x86_64"][1].split()


@pytest.fixture
def shipped(package, tmp_path, monkeypatch):
    """Compile a kernel for the baseline in another process, as a wheel carries it."""
    host = shipped_kernels.llvm.get_host_cpu_features()
    if platform.machine() != "x86_64" or not all(host.get(feature) for feature in FEATURES):
        pytest.skip("the baseline of the shipped kernels is x86-64-v3")
    top = package("here")
    code = (
        f"import sys; sys.path.insert(0, {str(Path(top.__file__).parents[1])!r}); import scratch.top as t; t.outer(2.0)"
    )
    built = {"NUMBA_CACHE_DIR": str(tmp_path / "built"), "NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
    subprocess.run([sys.executable, "-c", code], env={**os.environ, **built}, check=True)
    monkeypatch.setattr(kernel_cache, "SHIPPED", tmp_path / "built" / "flexmb")
    kernel_cache._baseline.cache_clear()
    yield top
    kernel_cache._baseline.cache_clear()


def test_kernels_that_came_with_the_package_are_used(folder, shipped):
    assert shipped.outer(2.0) == 2.0
    assert hits(shipped.outer) == 1
    assert not folder.exists()


def test_shipped_kernels_stay_unused_where_the_processor_lacks_a_feature(folder, shipped, monkeypatch):
    host = dict(shipped_kernels.llvm.get_host_cpu_features()) | {"avx2": False}
    monkeypatch.setattr(shipped_kernels.llvm, "get_host_cpu_features", lambda: host)
    assert shipped.outer(2.0) == 2.0
    assert hits(shipped.outer) == 0


def test_other_shipped_code_stays_unused(folder, shipped, package):
    top = package("there", numbers="SIN, COS = 21, 20")
    assert top.outer(2.0) == -2.0
    assert hits(top.outer) == 0


def test_shipping_takes_kernels_and_says_why_they_do_not_fit(folder, shipped, tmp_path, monkeypatch, capsys):
    """Locks and parts of files stay behind; another numba, or an older processor, is named in the message."""
    made = tmp_path / "built" / "flexmb"
    (made / "scratch.top" / ".outer.lock").touch()
    target = tmp_path / "package" / "compiled"
    (target / "old").mkdir(parents=True)
    assert shipped_kernels.ship(made, target) == len(list(made.glob("*/[!.]*"))) > 0
    assert not (target / "old").exists()
    assert not list(target.rglob("*.lock"))
    monkeypatch.setattr(kernel_cache, "SHIPPED", target)
    assert shipped.outer(2.0) == 2.0
    assert hits(shipped.outer) == 1
    assert shipped_kernels.why_unused(target) == ""
    host = dict(shipped_kernels.llvm.get_host_cpu_features()) | {"avx2": False}
    with monkeypatch.context() as older:
        older.setattr(shipped_kernels.llvm, "get_host_cpu_features", lambda: host)
        assert "for x86-64-v3, this processor lacks avx2" in shipped_kernels.why_unused(target)
        older.delenv("FLEXMB_QUIET", raising=False)
        kernel_cache.announce_compiling.cache_clear()
        kernel_cache.announce_compiling()
        assert "compiling kernels, as the kernels in the package are for" in capsys.readouterr().err
        kernel_cache.announce_compiling.cache_clear()
    monkeypatch.setattr("numba.__version__", "0.1")
    assert "are for numba" in shipped_kernels.why_unused(target)
    assert "this is 0.1" in shipped_kernels.why_unused(target)


def test_the_first_compilation_is_announced_once(monkeypatch, capsys):
    monkeypatch.delenv("FLEXMB_QUIET")
    kernel_cache.announce_compiling.cache_clear()
    kernel_cache.announce_compiling()
    kernel_cache.announce_compiling()
    assert capsys.readouterr().err.count("flexmb: compiling kernels") == 1


LOADED_FIRST = """
import sys
import numpy as np
from numba.core.base import BaseContext
from flexmb.math.kernel import kernel

times, refresh = [], BaseContext.refresh
BaseContext.refresh = lambda self: times.append(1) or refresh(self)

@kernel
def products(x):
    return 2.0 * x + np.ones(len(x))

@kernel
def of_others(x):
    return products(x)[1] + max(x[0], 2.0) ** 3

found = products(np.array([1.0, 2.0]))
print(sum(products.stats.cache_hits.values()), bool(times), *found)
if len(sys.argv) > 1:
    print(of_others(np.array([1.0, 2.0])), sum(of_others.stats.cache_hits.values()))
"""


def test_what_is_loaded_needs_no_compiler_and_what_is_compiled_later_finds_it(tmp_path):
    """Three processes: one compiles; one only loads, and numba lists no types and operators for it; the third loads
    first, then compiles. By hand: 2 x + 1 = (3, 5), 5 + 2^3 = 13."""
    (tmp_path / "loaded_first.py").write_text(LOADED_FIRST)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "FLEXMB_QUIET": "1"}

    def said(*arguments):
        command = [sys.executable, str(tmp_path / "loaded_first.py"), *arguments]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.splitlines()

    assert said() == ["0 True 3.0 5.0"]
    assert said() == ["1 False 3.0 5.0"]
    assert said("more") == ["1 False 3.0 5.0", "13.0 0"]
    assert said("more") == ["1 False 3.0 5.0", "13.0 1"]

"""Assertions of the tests are rewritten once, in shares, not by every worker anew."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest


def rewrite_own_share(config: pytest.Config) -> None:
    """Rewrite this worker's share of the files of tests, and keep them where pytest looks before it rewrites.

    What pytest does not offer to all is taken from inside it; where it has other names, each worker rewrites all.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    if sys.dont_write_bytecode or not worker.startswith("gw"):
        return
    try:
        from _pytest.assertion import rewrite

        for path in share(files_of(config), int(worker[2:]), int(os.environ["PYTEST_XDIST_WORKER_COUNT"])):
            kept = rewrite.get_cache_dir(path) / (path.stem + rewrite.PYC_TAIL)
            if kept.exists() and kept.stat().st_mtime >= path.stat().st_mtime:
                continue
            if rewrite.try_makedirs(kept.parent):
                state, code = rewrite._rewrite_test(path, config)
                rewrite._write_pyc(config.stash[rewrite.assertstate_key], code, state, kept)
    except (ImportError, AttributeError, TypeError, SyntaxError, OSError):
        return  # collecting rewrites what is left, and names what is wrong


def files_of(config: pytest.Config) -> list[Path]:
    """Return the files of tests below what the command names."""
    found: set[Path] = set()
    for argument in config.args:
        path = config.invocation_params.dir / argument.split("::")[0]
        found |= set(path.rglob("test_*.py")) if path.is_dir() else {path}
    return sorted(found)


def share(paths: list[Path], number: int, count: int) -> list[Path]:
    """Return this worker's part: as much text as the others have. Those that collect first begin."""
    sizes = [path.stat().st_size for path in paths]
    middles = [sum(sizes[:k]) + size / 2 for k, size in enumerate(sizes)]
    total = sum(sizes) or 1  # all of them may be empty
    return [path for path, middle in zip(paths, middles) if int(count * middle / total) == number]

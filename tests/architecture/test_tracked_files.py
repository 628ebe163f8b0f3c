"""The repository is complete in itself: no path of one machine, no large file, no foreign folder."""

import re
import subprocess
from pathlib import Path

import pytest
from architecture.sources import ROOT

TEXT = {".py", ".md", ".toml", ".txt", ".cfg", ".yml", ".yaml", ".sh", ".json", ".rst", ""}
MACHINE_PATHS = re.compile(r"(?<![\w.$}])/(?:work|tmp|root|home|farm|Users)/|\.\./shared")
LARGEST = 3_000_000  # bytes; what is larger can be generated


def tracked():
    try:
        listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return []
    return [path for path in map(ROOT.joinpath, listing.stdout.splitlines()) if path.is_file()]


FILES = tracked()
pytestmark = pytest.mark.skipif(not FILES, reason="not a git checkout")


def test_no_path_of_one_machine():
    found = []
    for path in FILES:
        if path.suffix not in TEXT or path == Path(__file__):
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
            if MACHINE_PATHS.search(line):
                found.append(f"{path.relative_to(ROOT)}:{number} {line.strip()[:100]}")
    assert not found, "\n".join(found)


def test_no_large_file():
    large = [
        f"{path.relative_to(ROOT)} ({path.stat().st_size / 1e6:.1f} MB)"
        for path in FILES
        if path.stat().st_size > LARGEST
    ]
    assert not large, "\n".join(large)

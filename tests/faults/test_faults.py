"""Short campaigns of faults; the long ones: ``python tests/faults/campaigns.py``."""

import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGNS = Path(__file__).with_name("campaigns.py")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="forks and limits of Linux")


def table(*options):
    """Run campaigns and return their rows: name and counts (cases, lost, not finished, tracebacks, crashes, hangs)."""
    child = subprocess.run([sys.executable, CAMPAIGNS, *options], capture_output=True, text=True, check=False)
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in child.stdout.splitlines()[2:]]
    assert rows, child.stderr
    return {name: [int(count) for count in counts] for name, *counts in rows}, child.stderr


def test_kill_before_writes():
    found, told = table("--only", "kill before every", "--cases", "4")
    assert {name: counts[1:] for name, counts in found.items()} == dict.fromkeys(found, [0] * 5), told


@pytest.mark.slow
def test_all_campaigns():
    """No sample lost, no run that cannot be finished, no traceback, no crash, nothing that hangs."""
    found, told = table("--cases", "5")
    assert {name: counts[1:] for name, counts in found.items()} == dict.fromkeys(found, [0] * 5), told
    assert sum(counts[0] for counts in found.values()) > 40

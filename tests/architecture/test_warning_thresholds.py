"""The table of thresholds from which on warnings are given says what the code has."""

import re
from importlib import import_module
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "theory" / "thresholds.md"
ROWS = re.findall(r"^\| `([\w.]+)` \| (\S+) \| (.+?) \| (.+?) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
WATCHES = (
    "flexmb.bodies.floating.validity",
    "flexmb.integrate.runs.creep_watch",
    "flexmb.integrate.runs.energy_watch",
    "flexmb.integrate.runs.added_error",
    "flexmb.integrate.runs.runaway",
    "flexmb.integrate.runs.outgrown",
    "flexmb.integrate.linear.imbalance",
    "flexmb.integrate.runs.coarse_contacts",
    "flexmb.integrate.runs.vanishing",
    "flexmb.integrate.linear.lost_digits",
    "flexmb.integrate.equilibria.stability",
)


@pytest.mark.parametrize(("constant", "value", "what", "reason"), ROWS, ids=[row[0] for row in ROWS])
def test_value(constant, value, what, reason):
    module, _, name = constant.rpartition(".")
    assert getattr(import_module(module), name) == float(value)
    assert reason.startswith(("derived: ", "chosen"))
    assert len(what) > 10


@pytest.mark.parametrize("module", WATCHES)
def test_every_watch_has_its_rows(module):
    """Each module that judges a run has its share, or its limit, in the table."""
    named = {constant.rpartition(".")[2] for constant, *_ in ROWS if constant.startswith(f"{module}.")}
    own = {"SHARE", "DEFORMATION", "CHANGE", "UNBALANCED", "FAR", "BEYOND", "NOTED", "DENSE", "WITHIN", "SHRUNK"} & set(
        vars(import_module(module))
    )
    assert own
    assert own <= named

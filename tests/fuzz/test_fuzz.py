"""A short walk through every campaign, and proof that a campaign notices what it looks for.

The long walk: ``python tests/fuzz/run.py``. Inputs are numbered, so that one that fails can be made again.
"""

import os
import signal
import time

import pytest
from fuzz import campaign, data_files, decks, extremes, model_files, new_kinds
from fuzz.campaign import Campaign

from flexmb import io
from flexmb.errors import ModelError

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="campaigns fork their workers")

SHORT = {
    "models": (lambda: model_files.model_campaign(seed=7), 40),
    "decks": (lambda: decks.deck_campaign(seed=7), 40),
    "described": (lambda: new_kinds.described_campaign(seed=7), 60),
    "surfaces": (lambda: new_kinds.surface_campaign(seed=7), 48),
    "texts": (lambda: data_files.data_campaign("texts", data_files.TEXTS, seed=7), 40),
    "meshes": (lambda: data_files.data_campaign("meshes", data_files.MESHES, seed=7), 52),
    "matrices": (lambda: data_files.data_campaign("matrices", data_files.MATRICES, seed=7), 44),
    "bodies": (lambda: data_files.data_campaign("bodies", data_files.BODIES, seed=7), 24),
    "runs": (lambda: data_files.data_campaign("runs", data_files.RUNS, seed=7), 16),
}


@pytest.mark.parametrize("name", SHORT)
def test_nothing_but_messages(name):
    make, count = SHORT[name]
    outcome = campaign.run(make(), 0, count)
    assert outcome.inputs == count
    assert outcome.bad == 0, outcome.report()


def test_the_described_part_is_sound(tmp_path, monkeypatch):
    """What is refused as it is tells nothing when it is damaged."""
    monkeypatch.setenv("FLEXMB_BODIES", str(tmp_path / "bodies"))
    (tmp_path / "part.toml").write_text(new_kinds.PART)
    assert io.load_model(tmp_path / "part.toml").bodies[1].data.n_modes == 8


@pytest.mark.slow
def test_extreme_numbers():
    outcome = campaign.run(extremes.extreme_campaign(seed=7), 0, 20)
    assert outcome.bad == 0, outcome.report()


def ends(path):
    """Do what the number in the file says."""
    k = int(path.read_text())
    if k == 1:
        raise ModelError("x", found="y")
    if k == 2:
        raise KeyError("z")
    if k == 3:
        os.kill(os.getpid(), signal.SIGSEGV)
    if k == 4:
        time.sleep(60.0)
    if k == 5:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        time.sleep(60.0)
    if k == 6:
        bytearray(1 << 34)
    if k == 7:
        raise SystemExit(1)


def test_a_campaign_notices(tmp_path, monkeypatch):
    monkeypatch.setattr(campaign, "PATIENCE", 1.0)
    monkeypatch.setattr(campaign, "WARM_UP", 0.0)
    monkeypatch.setattr(campaign, "GRACE", 0.5)

    def make(folder, k):
        (folder / "case").write_text(str(k))
        return folder / "case"

    tried = Campaign("numbers", lambda folder: None, make, ends, limit=0.5, memory=1 << 30)
    outcome = campaign.run(tried, 0, 9, keep=tmp_path / "kept")
    assert outcome.counts == {"read": 2, "refused": 1, "traceback": 3, "crash": 1, "long": 1, "hang": 1}
    assert outcome.bad == 6
    assert sorted(path.name for path in (tmp_path / "kept").iterdir()) == [f"numbers_{k}_case" for k in range(2, 8)]
    assert "KeyError" in outcome.report()
    assert "SystemExit" in outcome.report()

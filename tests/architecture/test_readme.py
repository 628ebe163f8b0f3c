"""The README promises commands and links; what it names is there, and .ci/run runs the same tests."""

import re

from architecture.sources import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
TEST_COMMAND = "python -m pytest"


def test_both_run_the_same_tests():
    """The install-and-test command of the README ends as .ci/run does."""
    promised = re.search(r"^python3 -m venv .*?pip install \"\.\[test\]\" && \.venv/bin/(.*)$", README, re.MULTILINE)
    assert promised is not None
    assert promised.group(1) == TEST_COMMAND
    last = (ROOT / ".ci" / "run").read_text(encoding="utf-8").strip().splitlines()[-1]
    assert last.startswith(TEST_COMMAND)


def test_links_lead_somewhere():
    links = re.findall(r"\]\((?!https?:)([^)#]+)", README)
    missing = [link for link in links if not (ROOT / link).exists()]
    assert not missing, f"README.md links to {missing}"

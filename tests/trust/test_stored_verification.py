"""The table that `flexmb verify` leaves in a run folder is read again by reports: damaged, hostile, or as it was."""

import json
from dataclasses import replace

import pytest
from fuzz.mutation import generator, mutant

import flexmb as fmb
from flexmb import view
from flexmb.errors import DataFileError
from flexmb.trust.verification import Answer, Check

FOUND = fmb.Verification(
    model="swing",
    within=0.01,
    checks=(Check(name="energy", share=1e-6, limit=1e-3, worst="t = 0.3 s"),),
    answers=(
        Answer(
            name="place", unit="m", largest=0.3, course={"half steps": 0.02}, peak={"half steps": 0.001}, within=0.01
        ),
    ),
    runs=("half steps: 400 steps",),
    notes=("no mesh",),
)


def pages(found, folder):
    """Print it, and put it into a report."""
    model = fmb.Model(
        name="swing",
        bodies=[fmb.Ground(), fmb.PointMass("stone", mass=1.0)],
        sensors=[fmb.Position("place", marker="stone.center")],
    )
    run = fmb.simulate(model, 0.1, samples=3)
    return str(found) + view.report({"a": run}, folder / "r.html", verified={"a": found}, pictures=False).read_text()


def test_as_it_was(tmp_path):
    assert fmb.Verification.load(FOUND.save(tmp_path / "verification.json")) == FOUND


def test_names_are_text_of_the_page(tmp_path):
    """Names of checks, sensors, runs and remarks come from a file: they are never a part of the page."""
    bad = "<script>alert(1)</script><img src=x onerror=alert(2)>"
    found = replace(
        FOUND,
        model=bad,
        checks=(Check(name=bad, share=1.0, limit=0.1, worst=bad),),
        answers=(Answer(name=bad, unit=bad, largest=1.0, course={bad: 0.5}, peak={bad: 0.5}, within=0.1),),
        runs=(bad,),
        notes=(bad,),
    )
    page = pages(fmb.Verification.load(found.save(tmp_path / "v.json")), tmp_path).partition("<html")[2]
    assert "&lt;script&gt;alert(1)" in page
    assert "<script>alert" not in page
    assert "<img src=x" not in page


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("checks", 0, "share"), "much"),
        (("checks", 0, "worst"), None),
        (("checks", 0), "x"),
        (("checks",), "x"),
        (("answers", 0, "largest"), [1]),
        (("answers", 0, "course"), {"half steps": "0.1"}),
        (("answers", 0, "peak"), {}),
        (("within",), True),
        (("within",), 10**400),
        (("model",), 3),
        (("runs",), [1]),
        (("notes",), 1),
        (("more",), 1),
    ],
)
def test_other_kinds_of_values(tmp_path, place, value):
    path = FOUND.save(tmp_path / "v.json")
    raw = entry = json.loads(path.read_text())
    for name in place[:-1]:
        entry = entry[name]
    entry[place[-1]] = value
    path.write_text(json.dumps(raw))
    with pytest.raises(DataFileError, match=r"Verification .*v.json': it cannot be read.*Verify the run again"):
        fmb.Verification.load(path)


def test_damaged_in_many_ways(tmp_path):
    """600 mutants: refused, or printed to the end; and brackets without end."""
    path = FOUND.save(tmp_path / "v.json")
    sound, refused = path.read_bytes(), 0
    for k in range(600):
        path.write_bytes(b"[" * 100_000 if k == 0 else mutant(sound, generator(3, k), values=True))
        try:
            str(fmb.Verification.load(path))
        except DataFileError:
            refused += 1
    assert 100 < refused < 600

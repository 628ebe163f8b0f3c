"""Two processes at once at what is no run being written: bodies, reports, plots, sweeps, the cache of reduced parts."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path

from faults.bench import Bench, Counts
from faults.children import begin, ended
from fuzz.new_kinds import PART

import flexmb as fmb
from flexmb.errors import FlexmbError

__all__ = ["pairs_of_verbs"]

MESH = str(Path(__file__).parents[2] / "meshes" / "bracket_hex8.msh")
VARIED = """
[parameters]
mass = 1.0
[[body]]
kind = "Ground"
[[body]]
kind = "PointMass"
name = "stone"
mass = "= mass"
[[force]]
kind = "PointLoad"
name = "push"
marker = "stone.center"
force = [1.0, 0, 0]
[[sensor]]
kind = "Position"
name = "place"
marker = "stone.center"
[simulation]
t_end = 0.1
samples = 3
"""
MASSES = ("1", "2", "3", "4")


def pairs_of_verbs(bench: Bench) -> Counts:
    """Start two commands shortly after each other; one at least ends well, and what is left is complete."""
    counts, folder = Counts(), bench.folder / "pairs"
    folder.mkdir(exist_ok=True)
    run, body, study = folder / "run", folder / "part.h5", folder / "study"
    (folder / "varied.toml").write_text(VARIED)
    (folder / "part.toml").write_text(PART)
    os.environ["FLEXMB_BODIES"] = str(folder / "bodies")
    reduce = [
        "reduce",
        MESH,
        "--interface",
        "a=foot",
        "--interface",
        "b=load",
        "--material",
        "steel",
        "--modes",
        "2",
        "-o",
        str(body),
    ]
    sweep = ["sweep", str(folder / "varied.toml"), "--over", f"mass={','.join(MASSES)}", "--jobs", "1"]
    sweep += ["--output", "final(place x)", "--out", str(study)]
    report, plot = ["report", str(run), "--no-pictures"], ["plot", str(run), "place"]
    check, clear = ["check", str(folder / "part.toml")], ["cache", "--clear"]
    pairs = (
        (reduce, reduce, lambda: fmb.ModalNeutralData.load(body).n_modes == 8),
        (sweep, sweep, lambda: len((study / "results.csv").read_text().splitlines()) == 1 + len(MASSES)),
        (report, report, lambda: (run / "report.html").read_text().rstrip().endswith("</html>")),
        (plot, plot, lambda: all(p.read_bytes().endswith(b"IEND\xaeB`\x82") for p in run.glob("*.png"))),
        (report, plot, lambda: (run / "report.html").read_text().rstrip().endswith("</html>")),
        (check, check, lambda: True),
        (check, clear, lambda: True),
    )
    took: dict[int, float] = {}
    for k in bench.times(8 * len(pairs)):
        first, second, complete = pairs[k % len(pairs)]
        for left in (run, study, folder / "bodies"):
            shutil.rmtree(left, ignore_errors=True)
        for left in (body, *map(body.with_suffix, (".html", ".json"))):  # `reduce` replaces none of them
            left.unlink(missing_ok=True)
        shutil.copytree(bench.folder / "reference", run)
        began = time.monotonic()
        one = begin(first)
        time.sleep(bench.random.uniform(0.0, took.get(k % len(pairs), 0.5)))
        two = begin(second)
        ends = [ended(one), ended(two)]
        took[k % len(pairs)] = min(took.get(k % len(pairs), 60.0), time.monotonic() - began)
        counts.cases += 1
        what = f"{first[0]} and {second[0]}"
        for end in ends:
            counts.take(end, what)
        if not any(end.code == 0 for end in ends):
            counts.refused += 1
            counts.notes.append(f"{what}: both were refused: {ends[0].text[-300:]} {ends[1].text[-300:]}")
        try:
            whole = complete()
        except (FlexmbError, OSError) as error:
            whole = False
            counts.notes.append(f"{what}: {error}")
        if not whole:
            counts.lost += 1
            counts.notes.append(f"{what}: what is left is not complete: {[end.text[-300:] for end in ends]}")
    return counts

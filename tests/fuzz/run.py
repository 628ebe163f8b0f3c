"""Tries damaged and hostile input in large numbers and prints a table: ``python tests/fuzz/run.py --help``."""

from __future__ import annotations

import argparse
import sys
import time
from datetime import date
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz import campaign, data_files, decks, extremes, model_files, new_kinds

GROUPS = {
    "models": (lambda seed: model_files.model_campaign(seed=seed), 100_000),
    "bodies": (lambda seed: data_files.data_campaign("bodies", data_files.BODIES, seed=seed), 10_000),
    "runs": (lambda seed: data_files.data_campaign("runs", data_files.RUNS, seed=seed), 10_000),
    "texts": (lambda seed: data_files.data_campaign("texts", data_files.TEXTS, seed=seed), 20_000),
    "meshes": (lambda seed: data_files.data_campaign("meshes", data_files.MESHES, seed=seed), 40_000),
    "matrices": (lambda seed: data_files.data_campaign("matrices", data_files.MATRICES, seed=seed), 20_000),
    "decks": (lambda seed: decks.deck_campaign(seed=seed), 10_000),
    "described": (lambda seed: new_kinds.described_campaign(seed=seed), 10_000),
    "surfaces": (lambda seed: new_kinds.surface_campaign(seed=seed), 10_000),
    "units": (lambda seed: new_kinds.unit_campaign(seed=seed), 5_000),
    "extremes": (lambda seed: extremes.extreme_campaign(seed=seed), 5_000),
}
"""Campaigns, and how many inputs make a long run."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("groups", nargs="*", choices=[[], *GROUPS], help="what to try; default: everything")
    parser.add_argument("--share", type=float, default=1.0, help="part of the long run, 0.01 for a hundredth")
    parser.add_argument("--count", type=int, help="number of inputs of each group instead")
    parser.add_argument("--first", type=int, default=0, help="number of the first input; default: 0")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder for inputs that end badly")
    given = parser.parse_args()
    print(f"{date.today()}, seed {given.seed}, inputs from {given.first}\n")
    print(
        "| input | tried | "
        + " | ".join(campaign.KINDS)
        + " | s |\n|---" * 1
        + "|---" * (len(campaign.KINDS) + 2)
        + "|"
    )
    bad, causes = 0, []
    for name in given.groups or GROUPS:
        make, whole = GROUPS[name]
        begun = time.monotonic()
        count = given.count or max(1, round(given.share * whole))
        outcome = campaign.run(make(given.seed), given.first, count, keep=given.keep)
        numbers = " | ".join(str(outcome.counts[kind]) for kind in campaign.KINDS)
        print(f"| {name} | {outcome.inputs} | {numbers} | {time.monotonic() - begun:.0f} |", flush=True)
        bad += outcome.bad
        causes += [f"{name}:\n{outcome.report()}"] if outcome.bad else []
    print("\n" + "\n".join(causes))
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())

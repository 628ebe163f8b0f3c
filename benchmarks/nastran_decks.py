"""Nastran decks of a folder, such as `models` of pyNastran: read, or refused and why; their masses beside pyNastran.

Run: python benchmarks/nastran_decks.py folder
"""

import sys
import warnings
from pathlib import Path

from flexmb import fem
from flexmb.errors import FlexmbError
from flexmb.fem.deck.inventory import mass_and_center

LARGEST = 6_000_000
"""Bytes; larger decks are left out."""
NOTHING = 1e-20
"""Below this a mass is none: beams of a material without density."""


def mass_by_pynastran(path: Path) -> float | None:
    """Return the mass of a deck; None where pyNastran does not read or weigh it."""
    from pyNastran.bdf.bdf import BDF
    from pyNastran.bdf.mesh_utils.mass_properties import mass_properties

    try:
        model = BDF(debug=None)
        model.read_bdf(str(path), xref=True)
        return float(mass_properties(model)[0])
    except Exception:  # whatever it raises
        return None


def main(folder: Path) -> None:
    """Print a line per deck and the counts."""
    warnings.simplefilter("ignore")
    counts = {"tried": 0, "read": 0, "refused": 0, "weighed by both": 0, "equal to 1e-6": 0}
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in (".bdf", ".dat", ".nas")):
        if path.stat().st_size > LARGEST:
            continue
        counts["tried"] += 1
        name = path.relative_to(folder)
        try:
            mass, _ = mass_and_center(fem.read_deck(path, show=False))
        except FlexmbError as error:
            counts["refused"] += 1
            print(f"{name}: refused: {' '.join(str(error).split())[:160]}", flush=True)
            continue
        counts["read"] += 1
        theirs = mass_by_pynastran(path)
        if theirs is None:
            print(f"{name}: {mass:.9g} kg", flush=True)
            continue
        counts["weighed by both"] += 1
        same = abs(mass - theirs) <= max(1e-6 * abs(theirs), NOTHING)
        counts["equal to 1e-6"] += same
        print(f"{name}: {mass:.9g} kg, pyNastran {theirs:.9g}{'' if same else '   differs'}", flush=True)
    print(counts)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""Reading a large Nastran deck: `fem.read_deck`'s reader beside pyNastran, in one run.

A cube of 67 x 67 x 67 grid points and CHEXA cells in small fields. Processor time of the readers alone; pyNastran
without cross references. Memory: the largest resident set while our reader
runs less that before, over the file. Run: python benchmarks/decks.py [points per edge]
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

from flexmb.fem.deck.nastran import read_nastran_deck


def write(path: Path, n: int) -> None:
    """Write a cube of n^3 grid points."""
    with path.open("w") as file:
        file.write("CEND\nBEGIN BULK\n")
        for k in range(n**3):
            x, y, z = 0.01 * (k % n), 0.01 * (k // n % n), 0.01 * (k // n**2)
            file.write(f"GRID    {k + 1:8d}        {x:8.4f}{y:8.4f}{z:8.4f}\n")
        label = 0
        for c in range(n - 1):
            for b in range(n - 1):
                for a in range(n - 1):
                    label += 1
                    p = 1 + a + n * b + n * n * c
                    q = p + n * n
                    file.write(f"CHEXA   {label:8d}       1{p:8d}{p + 1:8d}{p + 1 + n:8d}{p + n:8d}{q:8d}{q + 1:8d}+\n")
                    file.write(f"+       {q + 1 + n:8d}{q + n:8d}\n")
        file.write("PSOLID         1       1\nMAT1           1 2.1+11              .3   7850.\nENDDATA\n")


def main(n: int = 67) -> None:
    """Print the times and their ratio."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cube.bdf"
        write(path, n)
        small = Path(folder) / "small.bdf"
        write(small, 3)
        read_nastran_deck(small)  # all modules are loaded
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        start = time.process_time()
        deck = read_nastran_deck(path)
        ours = time.process_time() - start
        grown = 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / path.stat().st_size
        size = path.stat().st_size / 1e6
        print(f"{len(deck.labels)} nodes, {size:.0f} MB: flexmb {ours:.1f} s, {grown:.1f} times the file")
        try:
            from pyNastran.bdf.bdf import BDF
        except ImportError:
            print("pyNastran is not installed")
            return
        start = time.process_time()
        BDF(debug=None).read_bdf(str(path), xref=False)
        theirs = time.process_time() - start
        print(f"pyNastran {theirs:.1f} s, ratio {theirs / ours:.2f}")


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:2]))

"""Campaign over decks of Nastran, Abaqus and Ansys: every family of cards, damaged, and hostile by construction."""

from __future__ import annotations

import os
import random
from pathlib import Path

from fuzz.archives import ARCHIVE
from fuzz.campaign import Campaign
from fuzz.mutation import generator, mutant

from flexmb import fem

__all__ = ["deck_campaign", "hostile", "use"]

BOX = "\n".join(f"GRID,{k + 1},,{k & 1}.,{k >> 1 & 1}.,{k >> 2}." for k in range(8))

SOLIDS = f"""SOL 103
CEND
SPC = 3
MPC = 6
BEGIN BULK
{BOX}
GRID,500,,1.,.5,.5
GRID,501,7,0.,.5,.5,8
GRID,600,,.5,0.,0.
GRID,700,,.5,.5,2.
CORD2R,7,0,0.,0.,0.,0.,0.,1.,+
+,1.,0.,0.
CORD2C,8,7,0.,0.,0.,0.,0.,1.,+
+,1.,0.,0.
CORD1R,9,1,2,3
CORD2S,11,0,0.,0.,0.,0.,0.,1.,+
+,1.,0.,0.
CHEXA,1,1,1,2,4,3,5,6,+
+,8,7,600
CPYRAM,2,1,5,6,8,7,700
CTETRA,3,2,1,2,3,700
CPENTA,4,2,1,2,3,5,6,7
PSOLID,1,1
PSOLID,2,3,8
MAT1,1,2.1+11,,.3,7850.
MAT9,3,2.+11,1.+11,1.+11,,,,2.+11,+
+,1.+11,,,,2.+11,,,,+
+,7.+10,,,7.+10,,7.+10,7850.
RBE2,900,500,123456,4,6,8
RBE3,901,,501,123456,1.,123,1,+
+,3,5,7
MPC,5,2,2,-1.,1,1,2.,,+
+,,3,2,-1.
MPCADD,6,5
SPC1,1,123456,1,THRU,3
SPC,2,4,13
SPCADD,3,1,2
CONM2,100,500,7,5.,.1,.2,.3,,+
+,.4,.01,.5,.02,.03,.6
PARAM,COUPMASS,1
PARAM,WTMASS,.00259
INCLUDE 'more.bdf'
ENDDATA
"""

LINES = """SOL 103
CEND
BEGIN BULK
GRDSET,,,,,,,
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,2.,0.,0.
GRID*                  4                              3.              0.+
+                     0.
GRID    5               4.      0.      0.
GRID,6,,4.,0.,1.
GRID,7,,4.,0.,1.
SPOINT,20,THRU,22
BAROR,,,,,0.,1.,0.
BEAMOR,,,,,0.,1.,0.
CBAR,1,1,1,2,0.,1.,0.,,+
+,,56,0.,.1,.2,0.,.1,.2
CBAR,2,7,2,3,6
CBEAM,3,2,3,4,0.,1.,0.,,+
+,,,0.,0.,.1
CBEAM,12,8,4,5,0.,1.,0.
CROD,4,3,4,5
CONROD,5,5,6,1,1.-3,1.-5
CTUBE,6,4,3,6
CBUSH,7,5,6,7,,,,0
CBUSH1D,13,6,5,7
CELAS1,8,10,1,1,20
CELAS2,9,100.,2,2,3,2
CDAMP2,10,5.,1,1,2,1
CVISC,14,9,1,2
CMASS2,11,2.5,3,1
CONM1,30,3,,1.,0.,1.,0.,0.,+
+,1.
PBAR,1,1,4.-3,2.-6,1.-6,1.-6,,,+
+,.01,.01,.02,.02,.03,.03,.04,.04,+
+,.8,.8
PBARL,7,1,,TUBE,,,,,+
+,.05,.04
PBEAML,2,1,,BAR,,,,,+
+,.04,.08,0.,YES,1.,.02,.04,0.
PBEAM,8,1,4.-3,2.-6,1.-6,0.,1.-6,0.,+
+,,,,,,,,,+
+,YES,1.,3.-3,1.-6,1.-6,0.,1.-6
PROD,3,1,1.-4,1.-8,,.5
PTUBE,4,1,.05,.01
PBUSH,5,K,1.,2.,3.,4.,5.,6.,+
+,,B,.1,,,,,+
+,,GE,.02
PBUSH1D,6,1.+4,10.,2.
PELAS,10,1.+3
PVISC,9,5.,1.
MAT1,1,2.1+11,,.3,7850.,1.-5,20.,.02
RBAR,40,1,2,123456,,,123456
RBE1,41,3,123456,,,,,,+
+,UM,4,123
RROD,42,5,6,1
SUPORT,1,123456
ENDDATA
"""

PLATES = """BEGIN BULK
$ plates
GRID,1,,0.,0.,0.
GRID,2,,1.,0.,0.
GRID,3,,1.,1.,0.
GRID,4,,0.,1.,0.
GRID,5,,2.,0.,0.
GRID,6,,2.,1.,0.
GRID,7,,.5,0.,0.
GRID,8,,1.,.5,0.
GRID,9,,.5,1.,0.
GRID,10,,0.,.5,0.
GRID,11,,3.,0.,0.
GRID,12,,3.,1.,0.
CQUAD4,1,1,1,2,3,4,,.01,+
+,,0,.02,.02,.02,.02
CTRIA3,2,2,2,5,3,30.
CTRIAR,3,3,5,6,3
CQUAD8,4,4,1,2,3,4,7,8,+
+,9,10
CSHEAR,5,5,5,11,12,6
CQUADR,6,6,5,11,12,6
CTRIA6,7,1,1,2,3,7,8,10
PSHELL,1,1,.02,1,1.,1,.8333,3.
PCOMP,2,,5.,,,,,SYM,+
+,1,.005,0.,,2,.005,90.
PCOMPG,3,0.,,,,,,,+
+,1,2,.02,0.
PSHELL,4,4,.02
PSHEAR,5,1,.01,2.
PSHELL,6,1,.01
MAT1,1,2.1+11,,.3,7850.
MAT8,2,1.35+11,1.+10,.3,5.+9,5.+9,3.+9,1600.
MAT2,4,2.+11,6.+10,0.,2.+11,0.,7.+10,7850.
NSM1,9,PSHELL,NSM,2.,1
NSML1,9,ELEMENT,5.,1,2
PLOTEL,70,1,5
ASET1,123,1,2
SET1,9,1,THRU,4
ENDDATA
"""

MORE = "CONM2,77,2,,1.\n"

STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n210e9, .3\n*DENSITY\n7850.\n*DAMPING, ALPHA=1., BETA=1e-4\n"
CORNERS = "\n".join(f"{k + 1}, {k & 1}., {k >> 1 & 1}., {k >> 2}." for k in range(8))

PARTS = f"""*HEADING
two blocks
*PART, NAME=BLOCK
*NODE, NSET=N
{CORNERS}
*ELEMENT, TYPE=C3D8R, ELSET=ALL
1, 1, 2, 4, 3, 5, 6, 8, 7
*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=ONE, PART=BLOCK
*END INSTANCE
*INSTANCE, NAME=TWO, PART=BLOCK
1., 0., 0.
1., 0., 0., 1., 0., 1., 90.
*END INSTANCE
*INSTANCE, NAME=THREE, PART=BLOCK
3., 0., 0.
*END INSTANCE
*NODE, NSET=REF
900, 2., .5, .5
*NSET, NSET=TIPS
ONE.8, TWO.8
*NSET, NSET=FOOT, INSTANCE=ONE, GENERATE
1, 7, 2
*SURFACE, NAME=RIGHT
TWO.ALL, S4
*SURFACE, NAME=LEFT
ONE.ALL, S6
*TIE, NAME=SEAM, POSITION TOLERANCE=.1
RIGHT, LEFT
*COUPLING, CONSTRAINT NAME=END, REF NODE=REF, SURFACE=RIGHT
*DISTRIBUTING
1, 6
*RIGID BODY, REF NODE=REF, ELSET=THREE.ALL
*END ASSEMBLY
{STEEL}*INCLUDE, INPUT=more.inp
*BOUNDARY
FOOT, ENCASTRE
TIPS, 1, 3, 0.
*STEP
*FREQUENCY
5
*END STEP
"""

MIXED = f"""*NODE, NSET=ALL
{CORNERS}
9, 2., 0., 0.
10, 3., 0., 0.
11, 2.5, 0., 0.
12, .5, .5, 2.
*ELEMENT, TYPE=S4, ELSET=SHELLS
1, 1, 2, 4, 3
*ELEMENT, TYPE=S3, ELSET=SHELLS
2, 5, 6, 7
*ELEMENT, TYPE=B31, ELSET=BEAMS
3, 2, 9
*ELEMENT, TYPE=B32, ELSET=LONG
4, 9, 11, 10
*ELEMENT, TYPE=T3D2, ELSET=BARS
5, 4, 9
*ELEMENT, TYPE=C3D4, ELSET=SOLIDS
6, 5, 6, 7, 12
*ELEMENT, TYPE=SPRINGA, ELSET=S
7, 1, 5
*ELEMENT, TYPE=SPRING2, ELSET=S2
12, 1, 5
*ELEMENT, TYPE=MASS, ELSET=M
8, 3
*ELEMENT, TYPE=ROTARYI, ELSET=R
9, 3
*ELEMENT, TYPE=DASHPOTA, ELSET=D
10, 2, 6
*ELEMENT, TYPE=CONN3D2, ELSET=C
11, 2, 6
*ORIENTATION, NAME=O, SYSTEM=RECTANGULAR
1., .3, 0., -.2, 1., 0.
3, 30.
*SHELL SECTION, ELSET=SHELLS, COMPOSITE, ORIENTATION=O, OFFSET=SPOS
.01, 3, PLY, 0.
.01, 3, PLY, 90.
*BEAM SECTION, ELSET=BEAMS, MATERIAL=STEEL, SECTION=RECT
.05, .08
0., 1., 0.
*BEAM GENERAL SECTION, ELSET=LONG, SECTION=GENERAL, DENSITY=7850.
4e-3, 2e-6, 0., 1e-6, 1e-6
0., 1., 0.
210e9, 80e9
*SOLID SECTION, ELSET=BARS, MATERIAL=STEEL
1e-4
*SOLID SECTION, ELSET=SOLIDS, MATERIAL=WOOD, ORIENTATION=O
*SPRING, ELSET=S

500.
*SPRING, ELSET=S2
1, 1
300.
*MASS, ELSET=M
2.
*ROTARY INERTIA, ELSET=R
1., 2., 3.
*DASHPOT, ELSET=D

.5
*MATERIAL, NAME=PLY
*ELASTIC, TYPE=LAMINA
135e9, 10e9, .3, 5e9, 5e9, 3e9
*DENSITY
1600.
*MATERIAL, NAME=WOOD
*ELASTIC, TYPE=ENGINEERING CONSTANTS
135e9, 10e9, 9e9, .3, .28, .4, 5e9, 4.5e9,
3.4e9
*DENSITY
600.
{STEEL}*ELSET, ELSET=E1
SHELLS, 3
*NSET, NSET=ODD, GENERATE
1, 11, 2
*NSET, NSET=OFE, ELSET=E1
*SURFACE, NAME=TOP
SHELLS, SPOS
*SURFACE, NAME=POINTS, TYPE=NODE
ODD, 1.
*TRANSFORM, NSET=ODD, TYPE=C
-1., -1., 0., -1., -1., 1.
*EQUATION
2
8, 1, 1., 4, 2, -2.
*MPC
PIN, 10, 3
PIN, 12, 7
*KINEMATIC COUPLING, REF NODE=10
6, 1, 3
*NONSTRUCTURAL MASS, ELSET=SHELLS, UNITS=TOTAL MASS
3.
*NODAL THICKNESS
1, .01
*BOUNDARY
9, 1, 6
"""

SEEDS = {
    "solids.bdf": SOLIDS,
    "lines.dat": LINES,
    "plates.nas": PLATES,
    "parts.inp": PARTS,
    "mixed.inp": MIXED,
    "archive.cdb": ARCHIVE,
}
UNITS = (None, None, "mm, t, s", "in, lbf s2/in, s", "m, kg, s")


def deck_campaign(*, seed: int = 1, limit: float = 10.0) -> Campaign:
    """Return the campaign over decks: nineteen of twenty are damaged, one is hostile by construction."""

    def make(folder: Path, k: int) -> Path:
        rng = generator(seed, k)
        if k % 20 == 19:
            name, text = hostile(rng, folder)
            (folder / name).write_text(text)
            return folder / name
        name = list(SEEDS)[k % len(SEEDS)]
        path = folder / f"case{Path(name).suffix}"
        path.write_bytes(mutant(SEEDS[name].encode(), rng))
        return path

    def prepare(folder: Path) -> None:
        (folder / "more.bdf").write_text(MORE)
        (folder / "more.inp").write_text("*NSET, NSET=MORE\nREF\n")
        os.mkfifo(folder / "pipe")

    def warm(folder: Path) -> list[Path]:
        for name, text in SEEDS.items():
            (folder / name).write_text(text)
        return [folder / name for name in SEEDS]

    return Campaign("decks", prepare, make, use, limit=limit, warm=warm)


def use(path: Path) -> None:
    """Do with a deck what a user does before its reduction."""
    fe = fem.read_deck(path, units=UNITS[len(path.read_bytes()) % len(UNITS)] if path.is_file() else None)
    repr(fe)
    abs(fe.K).sum()
    abs(fe.M).sum()
    fe.rigid_motions()
    for name in fe.supports:
        fem.fixed_freedoms(fe, name)


_NO_FILES = ("/dev/zero", "/dev/stdin", "pipe", ".", "/proc/self/mem", "n" * 5000, "")


def hostile(rng: random.Random, folder: Path) -> tuple[str, str]:
    """Return the name and text of a deck that asks for too much: includes without end, ranges, devices, doubling."""
    n = rng.choice((10, 1000, 100_000, 10**9, 10**18))
    way = rng.randrange(12)
    if way == 0:
        return "hostile.bdf", LINES.replace("SPC", "X").replace("ENDDATA", f"SPC1,1,123456,1,THRU,{n}\nENDDATA")
    if way == 1:
        return "hostile.bdf", LINES.replace("THRU,22", f"THRU,{20 + n}")
    if way == 2:
        return "hostile.inp", MIXED.replace("1, 11, 2", f"1, {n}, 1")
    if way == 3:
        return "hostile.bdf", SOLIDS.replace("more.bdf", rng.choice(_NO_FILES))
    if way == 4:
        return "hostile.inp", PARTS.replace("more.inp", rng.choice(_NO_FILES))
    if way in (5, 6):  # every file includes the next one twice
        suffix, line = rng.choice((("bdf", "INCLUDE 'twice{}.bdf'\n"), ("inp", "*INCLUDE, INPUT=twice{}.inp\n")))
        depth = rng.choice((4, 18, 30))
        for k in range(depth):
            (folder / f"twice{k}.{suffix}").write_text(2 * line.format(k + 1) if k < depth - 1 else "$\n")
        return f"hostile.{suffix}", (SOLIDS if suffix == "bdf" else PARTS).replace(f"more.{suffix}", f"twice0.{suffix}")
    if way == 7:
        m = min(n, 3000)
        rows = [f"CORD2R,{100 + k},{101 + k},0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0." for k in range(m)]
        last = f"CORD2R,{100 + m},0,0.,0.,0.,0.,0.,1.,+\n+,1.,0.,0.\nGRID,50,100,1.\n"
        return "hostile.bdf", SOLIDS.replace("ENDDATA", "\n".join(rows) + f"\n{last}ENDDATA")
    if way == 8:
        m = min(n, 300)
        rows = [f"*NSET, NSET=D{k + 1}\nD{k}, D{k}" for k in range(m)]
        return "hostile.inp", MIXED + "*NSET, NSET=D0\n1\n" + "\n".join(rows) + "\n"
    if way == 9:
        m = min(n, 2000)
        rows = [f"*INSTANCE, NAME=I{k}, PART=BLOCK\n{k}., 0., 0.\n*END INSTANCE" for k in range(m)]
        return "hostile.inp", PARTS.replace("*NODE, NSET=REF", "\n".join(rows) + "\n*NODE, NSET=REF")
    if way == 10:
        return "hostile.bdf", SOLIDS.replace("GRID,8,", f"GRID,{n},").replace(",8,7,600", f",{n},7,600")
    m = min(n, 100_000)
    return "hostile.inp", "*EQUATION\n" + f"{n}\n" + "1, 1, 1.,\n" * m + MIXED

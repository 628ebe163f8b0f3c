"""An Ansys archive with every family of blocks and commands, for the campaign over decks."""

from fem.ansys_archive import STEEL, archive, brick20, cmblock, eblock, material, nblock, rlblock

__all__ = ["ARCHIVE"]

POINTS, CELLS = brick20((2, 2, 1), (0.2, 0.2, 0.1))
FREE = {101: (0.0, 0.0, 0.5), 102: (0.3, 0.0, 0.5), 103: (0.3, 0.2, 0.6), 104: (0.0, 0.2, 0.5), 105: (0.1, 0.1, 0.9)}

ROWS = [(k, 1, 1, 1, 1, 11, cell) for k, cell in enumerate(CELLS, 1)]
ROWS += [
    (11, 2, 1, 2, 1, 0, (101,)),
    (12, 3, 1, 1, 2, 0, (101, 102, 103, 104)),
    (13, 4, 1, 1, 3, 0, (101, 105, 104)),
    (14, 5, 1, 5, 1, 0, (102, 105)),
    (15, 6, 1, 6, 4, 0, (103, 105)),
    (16, 7, 1, 1, 1, 0, (104, 105)),
    (17, 8, 2, 1, 1, 0, (1, 2, 3, 101)),
]
TYPES = {1: (186, (2, 0)), 2: (21, (3, 0)), 3: (181, (3, 2)), 4: (188, (3, 3)), 5: (14,), 6: (180,)}
TYPES |= {7: (184, (1, 1)), 8: (285,)}
SECTIONS = """SECTYPE,        2,SHEL,    ,skin
SECOFFSET, TOP
SECBLOCK,           2
  0.2000E-02,         1,  0.0000    ,         3
  0.1000E-02,         2,  45.000    ,         3
SECTYPE,        3,BEAM,RECT,slim,   0
SECOFFSET, CENT
SECDATA, 0.02, 0.04
SECTYPE,        4,LINK,,
SECDATA, 1e-4
"""
LOCAL = "LOCAL,R5.0,LOC,       11,  0,  0.1,  0.2,  0.3\nLOCAL,R5.0,ANG,       11,  0,  30.0,  20.0,  0.0\n"
LINKS = """CERIG,101,1,UXYZ
RBE3,105,ALL,SOME
CP,3,UX,2,3
CE,R5.0,DEFI,       2,       9,  0.00000000
CE,R5.0,NODE,         4,UX  ,    1.00000000,         5,UX  ,   -1.00000000
D,      6,UX  ,  0.00000000    ,  0.00000000
D,      6,UY  ,  0.00000000    ,  0.00000000
"""

ARCHIVE = archive(
    TYPES,
    rlblock({2: [2.0, 2.0, 2.0, 0.1, 0.1, 0.1], 5: [1e6, 10.0], 6: [1e-4]}),
    SECTIONS,
    LOCAL,
    nblock({**POINTS, **FREE}, {4: (10.0, 20.0, 30.0)}),
    eblock(ROWS),
    STEEL,
    material(2, EX=140e9, EY=10e9, EZ=10e9, PRXY=0.3, PRYZ=0.3, PRXZ=0.3, GXY=5e9, GYZ=4e9, GXZ=5e9, DENS=1600.0),
    cmblock("SOME", "NODE", [1, -4, 7]),
    cmblock("BRICKS", "ELEM", [1, -4]),
    LINKS,
)
"""Bricks, shells of plies, beams, bars, springs, masses, rigid links, equations, supports, components."""

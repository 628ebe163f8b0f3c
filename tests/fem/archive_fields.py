"""One Ansys archive with every kind of element, and another value for every field, key option and real constant.

Rows of `TEXT` are ``what | text | changed text``; the text stands once in the archive. ``!`` marks what has no effect
on stiffness, mass, supports and places; what else has none here must be told.
"""

from __future__ import annotations

from fem.ansys_archive import archive, cmblock, eblock, nblock, rlblock

__all__ = ["CHANGES", "DECK"]

POINTS = {
    **{k + 1: p for k, p in enumerate([(0, 0, 0), (1.1, 0, 0), (1.2, 1, 0.1), (0, 1, 0)])},
    **{k + 5: p for k, p in enumerate([(0, 0, 1), (1, 0, 1), (1, 1.1, 1), (0, 1, 1.2)])},
    11: (3, 0, 0),
    12: (4.1, 0, 0),
    13: (4, 1, 0),
    14: (3, 1, 0),
    15: (5, 0, 0),
    16: (5, 1.2, 0),
    21: (6, 0, 0),
    22: (7, 0.1, 0),
    23: (8, 0.3, 0.2),
    24: (9, 0.3, 0.4),
    25: (10, 0.5, 0.2),
    26: (6.5, 1, 2),
    31: (0, 3, 0),
    32: (1, 3, 0.2),
    33: (2, 3.2, 0.1),
    34: (2, 4, 0.1),
    35: (1, 4.1, 0.3),
}
ANGLES = {32: (20.0, 10.0, 5.0)}
ELEMENTS = [
    (1, 1, 1, 1, 1, 11, (1, 2, 3, 4, 5, 6, 7, 8)),
    (2, 2, 1, 1, 2, 11, (11, 12, 13, 14)),
    (3, 10, 1, 4, 9, 0, (12, 15, 16, 13)),
    (4, 3, 2, 1, 3, 0, (21, 22, 26)),
    (5, 3, 2, 1, 4, 0, (22, 23)),
    (6, 4, 2, 1, 5, 0, (23, 24)),
    (7, 5, 2, 2, 6, 0, (24, 25)),
    (8, 6, 2, 3, 1, 0, (32,)),
    (9, 7, 2, 5, 1, 0, (32, 33)),
    (10, 8, 2, 1, 1, 0, (33, 34)),
    (11, 9, 2, 1, 1, 0, (34, 35)),
]
TYPES = {1: (185, (2, 2)), 2: (181,), 3: (188,), 4: (288,), 5: (180,), 6: (21,), 7: (14,), 8: (184, (1, 1))}
TYPES |= {9: (184, (1, 0)), 10: (181,)}
COMMANDS = """LOCAL,R5.0,LOC,       11,  1,  0.1,  0.2,  0.3
LOCAL,R5.0,ANG,       11,  1,  30.0,  20.0,  10.0
SECTYPE,        2,SHELL,,layers
SECDATA, 0.01,1,15.0,3
SECDATA, 0.02,3,40.0,3
SECOFFSET,TOP
SECCONTROLS, 1.5e9, 1.6e9, 1e8, 2.5, 1.0
SECTYPE,        3,BEAM,RECT,slim
SECOFFSET,USER, 0.01, 0.02
SECDATA, 0.02, 0.04
SECCONTROLS, 1.1e8, 0.0, 1.2e8, 3.5
SECTYPE,        4,BEAM,ASEC,any
SECOFFSET,ORIGIN
SECDATA, 0.001, 1.0e-6, 1.5e-7, 2.0e-6, 1e-9, 3.0e-6, 0.01, 0.02, 0.03, 0.04
SECCONTROLS, 1.3e8, 0.0, 1.4e8, 4.5
SECTYPE,        5,PIPE,,tube
SECDATA, 0.05, 0.004
SECTYPE,        6,LINK,,bar
SECDATA, 0.002
SECCONTROLS, 5.5
MP,EX,1,150e9
MP,EY,1,9e9
MP,EZ,1,12e9
MP,PRXY,1,0.3
MP,PRYZ,1,0.4
MP,PRXZ,1,0.25
MP,GXY,1,5e9
MP,GYZ,1,3e9
MP,GXZ,1,4e9
MP,DENS,1,1600.0
MPDATA,R5.0, 1,EX  ,       2, 1, 2.1e11,
MPDATA,R5.0, 1,NUXY,       2, 1, 0.31,
MPDATA,R5.0, 1,DENS,       2, 1, 7850.0,
MP,EX,3,70e9
MP,NUXY,3,0.33
MP,DENS,3,2700.0
CE,R5.0,DEFI,       2,       1,  0.0
CE,R5.0,NODE,      31,UX,  1.0,      35,UY,  -2.0
CP,       1,UZ,      31,      16
D,       21,UX,  0.0
D,       22,ALL,  0.0
F,       25,FX,  1.0
LUMPM,0
"""
DECK = archive(
    TYPES,
    COMMANDS,
    rlblock({2: [0.0], 3: [1.5, 1.6, 1.7, 0.1, 0.2, 0.3], 4: [0.01, 0.011, 0.012, 0.013, 25.0, 1.2], 5: [2.5e6, 30.0]}),
    nblock(POINTS, ANGLES),
    eblock(ELEMENTS),
    cmblock("SOME", "NODE", [1, 2]),
)

TEXT = r"""
LOCAL: origin | LOC,       11,  1,  0.1 | LOC,       11,  1,  0.5
LOCAL: kind | ANG,       11,  1 | ANG,       11,  0
LOCAL: THXY | 30.0,  20.0,  10.0 | 35.0,  20.0,  10.0
LOCAL: THYZ | 30.0,  20.0,  10.0 | 30.0,  25.0,  10.0
LOCAL: THZX | 30.0,  20.0,  10.0 | 30.0,  20.0,  15.0
SHELL: thickness | SECDATA, 0.01,1 | SECDATA, 0.02,1
SHELL: material | 0.02,3,40.0 | 0.02,2,40.0
SHELL: angle | 15.0,3 | 25.0,3
SHELL: !points | 15.0,3 | 15.0,5
SHELL: offset | SECOFFSET,TOP | SECOFFSET,BOT
SHELL: E11 | 1.5e9, 1.6e9 | 1.7e9, 1.6e9
SHELL: E22 | 1.5e9, 1.6e9 | 1.5e9, 1.8e9
SHELL: E12 | 1e8, 2.5 | 2e8, 2.5
SHELL: ADMSUA | 1e8, 2.5 | 1e8, 3.5
SHELL: !hourglass | 2.5, 1.0 | 2.5, 2.0
BEAM: B | SECDATA, 0.02, 0.04 | SECDATA, 0.03, 0.04
BEAM: H | SECDATA, 0.02, 0.04 | SECDATA, 0.02, 0.05
BEAM: offset y | USER, 0.01, 0.02 | USER, 0.03, 0.02
BEAM: offset z | USER, 0.01, 0.02 | USER, 0.01, 0.03
BEAM: TXZ | 1.1e8, 0.0, 1.2e8, 3.5 | 1.3e8, 0.0, 1.2e8, 3.5
BEAM: TXY | 1.1e8, 0.0, 1.2e8, 3.5 | 1.1e8, 0.0, 1.3e8, 3.5
BEAM: ADDMAS | 1.1e8, 0.0, 1.2e8, 3.5 | 1.1e8, 0.0, 1.2e8, 4.5
ASEC: A | SECDATA, 0.001, 1.0e-6 | SECDATA, 0.002, 1.0e-6
ASEC: Iyy | 1.0e-6, 1.5e-7 | 1.1e-6, 1.5e-7
ASEC: Iyz | 1.0e-6, 1.5e-7 | 1.0e-6, 1.6e-7
ASEC: Izz | 2.0e-6, 1e-9 | 2.1e-6, 1e-9
ASEC: !Iw, without KEYOPT(1) | 2.0e-6, 1e-9 | 2.0e-6, 2e-9
ASEC: J | 3.0e-6 | 3.1e-6
ASEC: CGy | 0.01, 0.02, 0.03, 0.04 | 0.02, 0.02, 0.03, 0.04
ASEC: CGz | 0.01, 0.02, 0.03, 0.04 | 0.01, 0.03, 0.03, 0.04
ASEC: SHy | 0.01, 0.02, 0.03, 0.04 | 0.01, 0.02, 0.04, 0.04
ASEC: SHz | 0.01, 0.02, 0.03, 0.04 | 0.01, 0.02, 0.03, 0.05
ASEC: TSxz | 0.01, 0.02, 0.03, 0.04 | 0.01, 0.02, 0.03, 0.04, 0., 0., 0.5, 0.5
ASEC: TXZ | 1.3e8, 0.0, 1.4e8, 4.5 | 1.5e8, 0.0, 1.4e8, 4.5
ASEC: TXY | 1.3e8, 0.0, 1.4e8, 4.5 | 1.3e8, 0.0, 1.5e8, 4.5
ASEC: ADDMAS | 1.3e8, 0.0, 1.4e8, 4.5 | 1.3e8, 0.0, 1.4e8, 5.5
PIPE: Do | 0.05, 0.004 | 0.06, 0.004
PIPE: Tw | 0.05, 0.004 | 0.05, 0.005
PIPE: !divisions | 0.05, 0.004 | 0.05, 0.004, 12
PIPE: fluid | 0.05, 0.004 | 0.05, 0.004, 8, 0, 2, 7
LINK: A | SECDATA, 0.002\n | SECDATA, 0.003\n
LINK: ADDMAS | SECCONTROLS, 5.5 | SECCONTROLS, 6.5
LINK: TENSKEY | SECCONTROLS, 5.5 | SECCONTROLS, 5.5, 1
MP: EX | 150e9 | 140e9
MP: EY | MP,EY,1,9e9 | MP,EY,1,8e9
MP: EZ | 12e9 | 13e9
MP: PRXY | 1,0.3\n | 1,0.2\n
MP: PRYZ | 1,0.4\n | 1,0.3\n
MP: PRXZ | 1,0.25 | 1,0.2
MP: GXY | 1,5e9 | 1,6e9
MP: GYZ | 1,3e9 | 1,2e9
MP: GXZ | 1,4e9 | 1,6e9
MP: DENS | 1600.0 | 1700.0
MP: over temperature | 1600.0 | 1600.0, 0.1
MP: damping | 1600.0 | 1600.0\nMP,BETD,1,1e-4
MP: !expansion | 1600.0 | 1600.0\nMP,ALPX,1,1e-5
MPDATA: EX | 2.1e11 | 2.2e11
MPDATA: NUXY | 1, 0.31 | 1, 0.3
MPDATA: DENS | 7850.0 | 7800.0
MPDATA: over temperature | 7850.0, | 7850.0, 7800.0,
CE: constant | 1,  0.0\nCE | 1,  0.1\nCE
CE: factor | UY,  -2.0 | UY,  -3.0
CE: label | 35,UY | 35,UZ
CP: label | 1,UZ,      31 | 1,UY,      31
CP: node | UZ,      31,      16 | UZ,      31,      25
D: label | 21,UX | 21,UY
D: !value | 21,UX,  0.0 | 21,UX,  0.1
D: further label | 21,UX,  0.0 | 21,UX,  0.0,  0.0, , , UZ
F: !force | 25,FX,  1.0 | 25,FX,  2.0
LUMPM | LUMPM,0 | LUMPM,1
ALPHAD | LUMPM,0 | LUMPM,0\nALPHAD,0.1
BETAD | LUMPM,0 | LUMPM,0\nBETAD,1e-4
unknown command | LUMPM,0 | LUMPM,0\nEMODIF,ALL,MAT,2
EKILL | LUMPM,0 | LUMPM,0\nEKILL,1
ENDRELEASE | LUMPM,0 | LUMPM,0\nENDRELEASE,,-1,BALL
!mode | LUMPM,0 | LUMPM,0\nMODOPT,LANB,10
SOLID185: type | ET,        1,185 | ET,        1,45
"""
OPTIONS = """
1 2=0 2=1 !2=3 3=1 6=1
2 1=1 2=1 !3=2 !8=2 9=1 10=1
3 1=1 !2=1 !4=2 5=1 !6=1 !11=1
4 4=2 !6=1
5 !2=1
6 1=1 2=1 3=2
7 1=1 2=3 3=1
8 1=6 !2=1
"""
REALS = {
    "MASS21": {f"{x:.9G}": f"{2 * x:.9G}" for x in (1.5, 1.6, 1.7, 0.1, 0.2, 0.3)},
    "SHELL181": {f"{x:.9G}": f"{2 * x:.9G}" for x in (0.01, 0.011, 0.012, 0.013, 25.0, 1.2)},
    "COMBIN14": {"2500000": "3500000", "30": "40"},
}


def _replaced(old: str, new: str) -> str:
    assert DECK.count(old) == 1, (old, DECK.count(old))
    return DECK.replace(old, new)


def _changes() -> list[tuple[str, str, bool]]:
    """Return what is changed, the changed archive, and whether it acts."""
    out = []
    for line in TEXT.strip().splitlines():
        what, old, new = (word.replace("\\n", "\n") for word in line.split(" | "))
        out.append((what.replace("!", ""), _replaced(old, new), "!" not in what))
    for line in OPTIONS.strip().splitlines():
        number, *words = line.split()
        for word in words:
            option, value = word.lstrip("!").split("=")
            text = _replaced("LOCAL,R5.0,LOC", f"KEYOP,{number},{option},{value}\nLOCAL,R5.0,LOC")
            out.append((f"type {number}, KEYOPT({option}) = {value}", text, not word.startswith("!")))
    for name, values in REALS.items():
        for k, (old, new) in enumerate(values.items()):
            out.append((f"{name}: real constant {k + 1}", _replaced(f"{old:>16}", f"{new:>16}"), True))
    return out


CHANGES = _changes()

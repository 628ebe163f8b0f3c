# ruff: noqa: E501
"""One Abaqus deck with every structural keyword, and another value for every field and every parameter.

Rows of `DATA` are ``keyword: field | text | changed text``; the text stands once in the deck. Rows of `PARAMETERS` are
keywords with the parameters that their manuals know (Abaqus Keywords Guide, CalculiX CrunchiX User's Manual), each with
a value that is not the usual one. ``!`` marks what has no effect on stiffness, mass, supports and places; what else has
none here must be told.
"""

from __future__ import annotations

__all__ = ["CHANGES", "DECK"]

DECK = """*HEADING
*NODE, NSET=NALL
1, 0., 0., 0.
2, 1.1, 0., 0.
3, 1.2, 1., 0.1
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1.1, 1.
8, 0., 1., 1.2
11, 2., 0., 0.
12, 3.1, 0., 0.
13, 3., 1., 0.
14, 2., 1., 0.
15, 4., 0.2, 0.
16, 4.1, 1., 0.
21, 5., 0., 0.
22, 6., .1, 0.
23, 7., .3, .1
24, 8., .3, .4
25, 6.4, 2.1, 0.
31, 0., 2., 0.
32, 1., 2., .2
33, 2., 2.5, .2
41, 0., 5., 0.
42, 1., 5., .3
43, 2., 5.3, .5
44, 0., 5., 1.
51, .5, .4, 1.5
52, 1.3, .5, .5
53, 2.5, .5, 1.
54, .3, .5, .5
55, 4.5, .5, .2
61, 0., 9., 0.
62, 1., 9., 0.
63, 1., 10., 0.
64, 0., 10., 0.
65, 0., 9., 1.
66, 1., 9., 1.
67, 1., 10., 1.
68, 0., 10., 1.
71, .2, 9.2, 1.001
72, .7, 9.3, 1.001
73, .7, 9.8, 1.001
74, .2, 9.8, 1.001
81, 9., 0., 0.
82, 9., 1., 0.
83, 9., 1., 1.
84, 9.5, 2., 0.
85, 9.5, 2.4, 0.5
*ELEMENT, TYPE=C3D8, ELSET=BRICK
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8, ELSET=BLOCK
2, 61, 62, 63, 64, 65, 66, 67, 68
*ELEMENT, TYPE=S4, ELSET=PLATE
11, 11, 12, 13, 14
*ELEMENT, TYPE=S4R, ELSET=STACK
12, 12, 15, 16, 13
*ELEMENT, TYPE=M3D4, ELSET=SKIN
13, 71, 72, 73, 74
*ELEMENT, TYPE=B31, ELSET=BAR
21, 21, 22
*ELEMENT, TYPE=B31, ELSET=BEAM
22, 22, 23, 25
*ELEMENT, TYPE=B31, ELSET=BENT
23, 23, 24
*ELEMENT, TYPE=T3D2, ELSET=ROD
31, 31, 32
32, 32, 33
*ELEMENT, TYPE=MASS, ELSET=WEIGHT
41, 41
*ELEMENT, TYPE=ROTARYI, ELSET=WHEEL
42, 42
*ELEMENT, TYPE=SPRINGA, ELSET=COIL
43, 41, 42
*ELEMENT, TYPE=SPRING2, ELSET=PAIR
44, 42, 43
*ELEMENT, TYPE=SPRING1, ELSET=GROUND
45, 43
*ELEMENT, TYPE=DASHPOTA, ELSET=DAMPER
46, 43, 44
*ELEMENT, TYPE=SPRINGA, ELSET=SOFT
47, 81, 82
48, 82, 83
49, 83, 81
50, 84, 85
*ELEMENT, TYPE=SPRINGA, ELSET=STIFF
51, 44, 41
*ELSET, ELSET=SPARE
47, 50
*NSET, NSET=SOME, GENERATE
61, 64, 1
*NSET, NSET=HELD
1, 4
*SURFACE, NAME=TOP
BRICK, S2
*SURFACE, NAME=END
PLATE, SPOS
*SURFACE, NAME=LID
BLOCK, S2
*SURFACE, NAME=SKINNED, TYPE=NODE
71,
72,
73,
74,
*ORIENTATION, NAME=TURN
1., .2, 0., 0., 1., .1
3, 20.
*ORIENTATION, NAME=ROUND, SYSTEM=CYLINDRICAL
0., 0., -3., 0., .1, 3.
*ORIENTATION, NAME=SIDE
1., .4, .2, .2, 1., .3
*MATERIAL, NAME=STEEL
*ELASTIC
210e9, .3
*DENSITY
7850.
*MATERIAL, NAME=PLY
*ELASTIC, TYPE=ENGINEERING CONSTANTS
135e9, 10e9, 9e9, .3, .28, .4, 5e9, 4.5e9,
3.4e9
*DENSITY
1600.
*MATERIAL, NAME=SHEET
*ELASTIC, TYPE=LAMINA
120e9, 8e9, .25, 4e9, 3.5e9, 3e9
*DENSITY
1500.
*MATERIAL, NAME=FULL
*ELASTIC, TYPE=ORTHOTROPIC
200e9, 80e9, 210e9, 81e9, 82e9, 220e9, 60e9, 61e9,
62e9
*DENSITY
2700.
*MATERIAL, NAME=ANY
*ELASTIC, TYPE=ANISOTROPIC
200e9, 80e9, 210e9, 81e9, 82e9, 220e9, 1e9, 2e9,
3e9, 60e9, 1.1e9, 1.2e9, 1.3e9, 1.4e9, 61e9, 1.5e9,
1.6e9, 1.7e9, 1.8e9, 1.9e9, 62e9
*DENSITY
2800.
*SOLID SECTION, ELSET=BRICK, MATERIAL=PLY, ORIENTATION=ROUND
*SOLID SECTION, ELSET=BLOCK, MATERIAL=FULL, ORIENTATION=TURN
*SOLID SECTION, ELSET=ROD, MATERIAL=STEEL
1.e-3
*SHELL SECTION, ELSET=PLATE, MATERIAL=SHEET, ORIENTATION=TURN, OFFSET=.2
.02, 5
*TRANSVERSE SHEAR STIFFNESS
1.e9, 1.1e9, 1.e8
*SHELL SECTION, ELSET=STACK, COMPOSITE, ORIENTATION=TURN
.001, 3, SHEET, 10.
.002, 3, PLY, 40., CORE
.003, 3, ANY, ROUND
*MEMBRANE SECTION, ELSET=SKIN, MATERIAL=STEEL
.004
*NODAL THICKNESS
14, .03
*BEAM SECTION, ELSET=BAR, MATERIAL=STEEL, SECTION=RECT, OFFSET1=.1
.02, .03
0., .1, 1.
*BEAM GENERAL SECTION, ELSET=BEAM, MATERIAL=STEEL, SECTION=GENERAL
.001, 1.e-6, 1.e-7, 2.e-6, 3.e-6
0., 0., 1.
*CENTROID
.01, .02
*SHEAR CENTER
.03, .04
*TRANSVERSE SHEAR STIFFNESS
1.2e8, 1.3e8
*BEAM GENERAL SECTION, ELSET=BENT, SECTION=GENERAL, DENSITY=2000.
.001, 1.e-6, 1.1e-7, 2.e-6, 3.1e-6
0., .2, 1.
200e9, 80e9
*MASS, ELSET=WEIGHT
2.
*ROTARY INERTIA, ELSET=WHEEL, ORIENTATION=SIDE
1., 2., 2.5, .1, .2, .3
*SPRING, ELSET=COIL

1.e6
*SPRING, ELSET=PAIR, ORIENTATION=SIDE
1, 2
2.e6
*SPRING, ELSET=GROUND
3
3.e6
*SPRING, ELSET=SOFT
,
7.e4
*SPRING, ELSET=STIFF, NONLINEAR

-1.e3, -1.
0., 0.
2.e3, 1.
*DASHPOT, ELSET=DAMPER

50.
*TRANSFORM, NSET=HELD, TYPE=C
5., 0., 0., 5., 0., 1.
*COUPLING, CONSTRAINT NAME=GRIP, REF NODE=51, SURFACE=TOP, ORIENTATION=TURN
*KINEMATIC
1, 3
5
*COUPLING, CONSTRAINT NAME=FOOT, REF NODE=55, SURFACE=END
*DISTRIBUTING
1, 6
*KINEMATIC COUPLING, REF NODE=53
24, 1, 3
*RIGID BODY, REF NODE=54, NSET=LIMB
*NSET, NSET=LIMB
21,
31
*TIE, NAME=GLUE, POSITION TOLERANCE=.1
SKINNED, LID
*MPC
BEAM, 33, 52
PIN, 84, 81
*EQUATION
2
83, 1, 1., 85, 2, -2.
*BOUNDARY
HELD, 1, 2
41, 2, 3, 0.
*STEP
*STATIC
*BOUNDARY
44, 1, 1
*CLOAD
33, 1, 1.
*END STEP
"""

DATA = r"""
NODE: x | 3, 1.2, 1., 0.1 | 3, 1.3, 1., 0.1
NODE: y | 3, 1.2, 1., 0.1 | 3, 1.2, 1.1, 0.1
NODE: z | 3, 1.2, 1., 0.1 | 3, 1.2, 1., 0.2
NODE: normal | 3, 1.2, 1., 0.1 | 3, 1.2, 1., 0.1, 0., 0.6, .8
NSET: increment | 61, 64, 1 | 61, 64, 2
NSET: member | 1, 4\n*SURF | 1, 3\n*SURF
SURFACE: element set | BRICK, S2 | BLOCK, S2
SURFACE: face | BRICK, S2 | BRICK, S3
SURFACE: side | PLATE, SPOS | PLATE, SNEG
ORIENTATION: a | 1., .2, 0., 0., 1., .1 | 1., .3, 0., 0., 1., .1
ORIENTATION: b | 1., .4, .2, .2, 1., .3 | 1., .4, .2, .2, 1., .5
ORIENTATION: c | 1., .2, 0., 0., 1., .1 | 1., .2, 0., 0., 1., .1, .2, .3, .1
ORIENTATION: axis | 3, 20. | 1, 20.
ORIENTATION: angle | 3, 20. | 3, 30.
ORIENTATION: a of the axis | 0., 0., -3., 0., .1, 3. | 0., .4, -3., 0., .1, 3.
ORIENTATION: b of the axis | 0., 0., -3., 0., .1, 3. | 0., 0., -3., 0., .2, 3.
ELASTIC: E | 210e9, .3 | 200e9, .3
ELASTIC: nu | 210e9, .3 | 210e9, .2
ELASTIC: temperature | 210e9, .3 | 210e9, .3, 20.\n180e9, .3, 300.
DENSITY: rho | 7850. | 7000.
DENSITY: temperature | 7850. | 7850., 20.\n7000., 300.
ELASTIC: E1 | 135e9, 10e9 | 134e9, 10e9
ELASTIC: E2 | 10e9, 9e9 | 11e9, 9e9
ELASTIC: E3 | 10e9, 9e9 | 10e9, 8e9
ELASTIC: nu12 | 9e9, .3, | 9e9, .2,
ELASTIC: nu13 | .28, .4 | .25, .4
ELASTIC: nu23 | .28, .4 | .28, .3
ELASTIC: G12 | 5e9, 4.5e9 | 6e9, 4.5e9
ELASTIC: G13 | 5e9, 4.5e9 | 5e9, 4.6e9
ELASTIC: G23 | 3.4e9 | 3.3e9
ELASTIC: temperature of engineering constants | 3.4e9 | 3.4e9, 20.\n134e9, 10e9, 9e9, .3, .28, .4, 5e9, 4.5e9,\n3.4e9, 300.
ELASTIC: E1 of a lamina | 120e9, 8e9 | 110e9, 8e9
ELASTIC: E2 of a lamina | 120e9, 8e9 | 120e9, 9e9
ELASTIC: nu12 of a lamina | 8e9, .25 | 8e9, .2
ELASTIC: G12 of a lamina | 4e9, 3.5e9 | 5e9, 3.5e9
ELASTIC: G13 of a lamina | 4e9, 3.5e9, 3e9 | 4e9, 3.6e9, 3e9
ELASTIC: G23 of a lamina | 4e9, 3.5e9, 3e9 | 4e9, 3.5e9, 2e9
ELASTIC: D1111 | 200e9, 80e9, 210e9, 81e9, 82e9, 220e9, 60e9 | 201e9, 80e9, 210e9, 81e9, 82e9, 220e9, 60e9
ELASTIC: D1122 | 200e9, 80e9, 210e9, 81e9, 82e9, 220e9, 60e9 | 200e9, 79e9, 210e9, 81e9, 82e9, 220e9, 60e9
ELASTIC: D1133 | 200e9, 80e9, 210e9, 81e9, 82e9, 220e9, 60e9 | 200e9, 80e9, 210e9, 80e9, 82e9, 220e9, 60e9
ELASTIC: D1313 | 60e9, 61e9 | 60e9, 59e9
ELASTIC: D2323 | \n62e9\n | \n63e9\n
ELASTIC: D1112 | 220e9, 1e9, 2e9 | 220e9, 1.5e9, 2e9
ELASTIC: D1213 | 3e9, 60e9, 1.1e9 | 3e9, 60e9, 1.5e9
ELASTIC: D2323 of 21 | 1.9e9, 62e9 | 1.9e9, 63e9
SOLID SECTION: area | 1.e-3 | 2.e-3
SHELL SECTION: thickness | .02, 5 | .03, 5
SHELL SECTION: !points | .02, 5 | .02, 7
TRANSVERSE SHEAR STIFFNESS: K11 | 1.e9, 1.1e9, 1.e8 | 2.e9, 1.1e9, 1.e8
TRANSVERSE SHEAR STIFFNESS: K22 | 1.e9, 1.1e9, 1.e8 | 1.e9, 1.2e9, 1.e8
TRANSVERSE SHEAR STIFFNESS: K12 | 1.e9, 1.1e9, 1.e8 | 1.e9, 1.1e9, 2.e8
SHELL SECTION: ply thickness | .001, 3, SHEET | .0011, 3, SHEET
SHELL SECTION: !ply points | .001, 3, SHEET | .001, 5, SHEET
SHELL SECTION: ply material | .001, 3, SHEET | .001, 3, STEEL
SHELL SECTION: ply angle | SHEET, 10. | SHEET, 20.
SHELL SECTION: ply orientation | ANY, ROUND | ANY, SIDE
SHELL SECTION: !ply name | 40., CORE | 40., WEB
NODAL THICKNESS: !thickness | 14, .03 | 14, .04
NODAL THICKNESS: node | 14, .03 | 1, .03
MEMBRANE SECTION: thickness | .004 | .005
BEAM SECTION: a | .02, .03 | .03, .03
BEAM SECTION: b | .02, .03 | .02, .04
BEAM SECTION: n1 | 0., .1, 1. | 0., .2, 1.
BEAM GENERAL SECTION: A | .001, 1.e-6, 1.e-7 | .002, 1.e-6, 1.e-7
BEAM GENERAL SECTION: I11 | .001, 1.e-6, 1.e-7 | .001, 1.1e-6, 1.e-7
BEAM GENERAL SECTION: I12 | .001, 1.e-6, 1.e-7 | .001, 1.e-6, 2.e-7
BEAM GENERAL SECTION: I22 | 1.e-7, 2.e-6, 3.e-6 | 1.e-7, 2.1e-6, 3.e-6
BEAM GENERAL SECTION: J | 1.e-7, 2.e-6, 3.e-6 | 1.e-7, 2.e-6, 3.2e-6
BEAM GENERAL SECTION: Gamma_O | 1.e-7, 2.e-6, 3.e-6 | 1.e-7, 2.e-6, 3.e-6, 1.e-8
BEAM GENERAL SECTION: Gamma_W | 1.e-7, 2.e-6, 3.e-6 | 1.e-7, 2.e-6, 3.e-6, 0., 1.e-9
BEAM GENERAL SECTION: E | 200e9, 80e9\n | 201e9, 80e9\n
BEAM GENERAL SECTION: G | 200e9, 80e9\n | 200e9, 81e9\n
BEAM GENERAL SECTION: !expansion | 200e9, 80e9\n | 200e9, 80e9, 1e-5\n
CENTROID: x1 | .01, .02 | .02, .02
CENTROID: x2 | .01, .02 | .01, .03
SHEAR CENTER: x1 | .03, .04 | .02, .04
SHEAR CENTER: x2 | .03, .04 | .03, .05
TRANSVERSE SHEAR STIFFNESS: K23 | 1.2e8, 1.3e8 | 1.1e8, 1.3e8
TRANSVERSE SHEAR STIFFNESS: K13 | 1.2e8, 1.3e8 | 1.2e8, 1.4e8
TRANSVERSE SHEAR STIFFNESS: SCF | 1.2e8, 1.3e8 | 1.2e8, 1.3e8, .4
MASS: m | \n2.\n*ROT | \n3.\n*ROT
ROTARY INERTIA: I11 | 1., 2., 2.5, .1, .2, .3 | 1.1, 2., 2.5, .1, .2, .3
ROTARY INERTIA: I22 | 1., 2., 2.5, .1, .2, .3 | 1., 2.1, 2.5, .1, .2, .3
ROTARY INERTIA: I33 | 1., 2., 2.5, .1, .2, .3 | 1., 2., 2.6, .1, .2, .3
ROTARY INERTIA: I12 | 1., 2., 2.5, .1, .2, .3 | 1., 2., 2.5, .2, .2, .3
ROTARY INERTIA: I13 | 1., 2., 2.5, .1, .2, .3 | 1., 2., 2.5, .1, .1, .3
ROTARY INERTIA: I23 | 1., 2., 2.5, .1, .2, .3 | 1., 2., 2.5, .1, .2, .2
SPRING: k | 1.e6 | 1.5e6
SPRING: first direction | \n1, 2\n2.e6 | \n3, 2\n2.e6
SPRING: second direction | \n1, 2\n2.e6 | \n1, 3\n2.e6
SPRING: k between | 2.e6\n | 2.5e6\n
SPRING: direction | \n3\n3.e6 | \n2\n3.e6
SPRING: k to ground | \n3\n3.e6 | \n3\n4.e6
SPRING: temperature | 7.e4 | 7.e4, 0., 20.\n6.e4, 0., 300.
SPRING: force | 2.e3, 1. | 3.e3, 1.
SPRING: length | -1.e3, -1. | -1.e3, -2.
DASHPOT: c | \n50.\n | \n60.\n
TRANSFORM: a | 5., 0., 0., 5., 0., 1. | 5., 1., 0., 5., 0., 1.
TRANSFORM: b | 5., 0., 0., 5., 0., 1. | 5., 0., 0., 5., .1, 1.
KINEMATIC: last | \n1, 3\n5 | \n1, 2\n5
KINEMATIC: second line | \n1, 3\n5 | \n1, 3\n6
DISTRIBUTING: last | 1, 6\n*KIN | 1, 5\n*KIN
KINEMATIC COUPLING: node | 24, 1, 3 | 23, 1, 3
KINEMATIC COUPLING: last | 24, 1, 3 | 24, 1, 2
TIE: slave | SKINNED, LID | LID, TOP
TIE: master | SKINNED, LID | SKINNED, TOP
MPC: type | BEAM, 33, 52 | TIE, 33, 52
MPC: node | BEAM, 33, 52 | BEAM, 33, 53
EQUATION: direction | 83, 1, 1., 85, 2, -2. | 83, 3, 1., 85, 2, -2.
EQUATION: factor | 83, 1, 1., 85, 2, -2. | 83, 1, 1., 85, 2, -3.
EQUATION: node | 83, 1, 1., 85, 2, -2. | 83, 1, 1., 82, 2, -2.
BOUNDARY: last | HELD, 1, 2 | HELD, 1, 3
BOUNDARY: first | 41, 2, 3, 0. | 41, 1, 3, 0.
BOUNDARY: !value | 41, 2, 3, 0. | 41, 2, 3, .1
BOUNDARY: in the first step | 44, 1, 1 | 44, 1, 2
CLOAD: !force | 33, 1, 1. | 33, 1, 2.
"""

PARAMETERS = r"""
*NODE, NSET=NALL | SYSTEM=C INPUT=none.txt
*ELEMENT, TYPE=S4, ELSET=PLATE | INPUT=none.txt OFFSET=100 FILE=x ROTATION=1.
*ELSET, ELSET=SPARE | GENERATE INSTANCE=A !UNSORTED !INTERNAL
*NSET, NSET=HELD | GENERATE INSTANCE=A ELSET=PLATE !UNSORTED !INTERNAL
*SURFACE, NAME=TOP | TYPE=NODE COMBINE=UNION CROP TRIM=YES
*ORIENTATION, NAME=TURN | SYSTEM=CYLINDRICAL DEFINITION=NODES
*MATERIAL, NAME=STEEL | !RTOL=.1
*ELASTIC, TYPE=LAMINA | MODULI=INSTANTANEOUS !DEPENDENCIES=1 COMPRESSION_FACTOR=.1
*SOLID SECTION, ELSET=BLOCK | ORIENTATION=SIDE COMPOSITE !CONTROLS=A REF_NODE=1 !STACK_DIRECTION=2 LAYUP=A !SYMMETRIC
*SHELL SECTION, ELSET=PLATE | ORIENTATION=SIDE OFFSET=SPOS NODAL_THICKNESS SHELL_THICKNESS=A DENSITY=3. !CONTROLS=A !POISSON=.2 !SECTION_INTEGRATION=GAUSS !TEMPERATURE=3 THICKNESS_MODULUS=2. !STACK_DIRECTION=1
*MEMBRANE SECTION, ELSET=SKIN | !CONTROLS=A !POISSON=.2 MEMBRANE_THICKNESS=A NODAL_THICKNESS ORIENTATION=NONE
*BEAM SECTION, ELSET=BAR | SECTION=CIRC OFFSET1=.2 OFFSET2=.2 ROTARY_INERTIA=ISOTROPIC !POISSON=.2 !TEMPERATURE=GRADIENTS !LUMPED=NO
*BEAM GENERAL SECTION, ELSET=BENT | DENSITY=3000. !POISSON=.1 !ZERO=20. ROTARY_INERTIA=ISOTROPIC TAPER !LUMPED=NO DEPENDENCIES=1
*MASS, ELSET=WEIGHT | !ALPHA=.1 !COMPOSITE=.1 TYPE=ANISOTROPIC ORIENTATION=SIDE
*ROTARY INERTIA, ELSET=WHEEL | ORIENTATION=TURN !ALPHA=.1 !COMPOSITE=.1
*SPRING, ELSET=PAIR | ORIENTATION=TURN NONLINEAR !DEPENDENCIES=1 !RTOL=.1
*DASHPOT, ELSET=DAMPER | NONLINEAR !DEPENDENCIES=1 !RTOL=.1
*TRANSFORM, NSET=HELD | TYPE=R
*COUPLING, CONSTRAINT NAME=FOOT | INFLUENCE_RADIUS=.1 !ORIENTATION=SIDE SCALE=2.
*KINEMATIC\n | CONSTRAINT=A
*DISTRIBUTING\n | WEIGHTING_METHOD=LINEAR COUPLING=STRUCTURAL ROTATIONAL_COUPLING=NO
*KINEMATIC COUPLING, REF NODE=53 | ORIENTATION=TURN
*RIGID BODY, REF NODE=54 | POSITION=CENTER_OF_MASS PIN_NSET=HELD TIE_NSET=SOME ELSET=ROD ROT_NODE=52 ANALYTICAL_SURFACE=TOP ISOTHERMAL=YES
*TIE, NAME=GLUE | ADJUST=NO CONSTRAINT_RATIO=.5 NO_ROTATION NO_THICKNESS TIED_NSET=HELD !TYPE=NODE_TO_SURFACE CYCLIC_SYMMETRY POSITION_TOLERANCE=1e-9
*MPC\n | MODE=DOF USER
*EQUATION\n | REMOVE INPUT=none.txt
*BOUNDARY\nHELD | !OP=NEW !TYPE=VELOCITY !FIXED SUBMODEL LOAD_CASE=2 !AMPLITUDE=A REGION_TYPE=A
*BOUNDARY\n44 | OP=NEW !AMPLITUDE=A
"""


def _changed_field(old: str, new: str) -> str:
    old, new = (word.replace("\\n", "\n") for word in (old, new))
    assert DECK.count(old) == 1, old
    return DECK.replace(old, new)


def _changed_parameter(head: str, name: str, given: str) -> str:
    """Return the deck with a parameter in the line that begins with a text, in place of its value there."""
    begin = head.replace("\\n", "\n")
    assert DECK.count(begin) == 1, head
    start = DECK.index(begin)
    end = DECK.index("\n", start)
    first, *words = DECK[start:end].split(",")
    kept = [word for word in words if word.partition("=")[0].strip().upper() != name]
    return DECK[:start] + ",".join([first, *kept, f" {name}{given}"]) + DECK[end:]


def _changes() -> list[tuple[str, str, bool]]:
    """Return what is changed, the changed deck, and whether it acts."""
    out = []
    for line in DATA.strip().splitlines():
        what, old, new = line.split(" | ")
        out.append((what.replace("!", ""), _changed_field(old, new), "!" not in what))
    for line in PARAMETERS.strip().splitlines():
        head, words = line.split(" | ")
        keyword = head.split(",")[0].split("\\n")[0]
        for word in words.split():
            name, given, value = word.lstrip("!").partition("=")
            name = name.replace("_", " ")
            text = _changed_parameter(head, name, given + value.replace("_", " "))
            out.append((f"{keyword}, {name}", text, not word.startswith("!")))
    return out


CHANGES = _changes()

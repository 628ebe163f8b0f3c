"""`Program`: the constant input of a compiled evaluation, its type, and the call of the evaluation."""

from __future__ import annotations

from collections import namedtuple

from flexmb.math.block_lu import BlockPattern
from flexmb.math.tables import BYTES, COUNT, FLOATS, INTEGERS, STATE, WORK, caller, tuple_type, void

__all__ = ["EVALUATION", "PROGRAM", "Program", "call_evaluation"]

Program = namedtuple(
    "Program",
    "place inertia energy equations forces raw starts bulk "
    "signal_starts signal_ops signal_args signal_tables signal_table_starts "
    "frames vectors pattern regularisation floor_at floor equation_level branches evaluation",
)
"""place, inertia, energy, equations, forces : addresses of the kernels of every kind; numbers, because function objects
would be inspected one by one in every call from Python
raw : all record tables as bytes; starts (kinds + 1,): where each begins: bodies, equations, forces
bulk : numbers which rows index
frames (nf, 2) : first coordinate and velocity of every frame; vectors (nv, 4): iq, iu and length of plain vectors,
and 1 for flexible coordinates in a frame
pattern : BlockPattern of the iteration matrix
regularisation (ng,) : added to the diagonal of the multipliers (zero unless equations are dependent), with the sign of
G M^-1 G^T, so that no pivot vanishes near singular configurations
floor_at (nf, 2) : velocity, and place of its diagonal in the iteration matrix; floor (nf,): what is added there, times
the weight of the mass, for bodies without inertia in some freedom (see `massless`); the residual does not know it
equation_level (ng,) : 0 for a holonomic equation g(q, t) = 0, 1 for one at velocity level, A(q, t) u + rate = 0
branches : int, first coordinate that tells branches (see Work); they come after the coordinates of all bodies
evaluation : int, address of the machine code of `evaluate`
"""

PROGRAM = tuple_type(
    Program,
    *[INTEGERS] * 5,
    BYTES,
    INTEGERS,
    FLOATS,
    INTEGERS,
    INTEGERS,
    FLOATS,
    FLOATS,
    INTEGERS,
    (INTEGERS, 2),
    (INTEGERS, 2),
    tuple_type(BlockPattern, *[INTEGERS] * (len(BlockPattern._fields) - 3), *[FLOATS] * 3),
    FLOATS,
    (INTEGERS, 2),
    FLOATS,
    INTEGERS,
    COUNT,
    COUNT,
)
EVALUATION = void(PROGRAM, STATE, WORK)
"""The signature of the evaluation."""

call_evaluation = caller(EVALUATION)
"""Call the evaluation at an address."""

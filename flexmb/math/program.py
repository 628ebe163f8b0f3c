"""`Program`: the constant input of a compiled evaluation, its type, and the call of the evaluation."""

from __future__ import annotations

from typing import NamedTuple

from flexmb.math.block_pattern import BlockPattern
from flexmb.math.jets import SignalCode
from flexmb.math.structures import Bytes, Floats, IntegerRows, Integers, numba_type, structure
from flexmb.math.tables import STATE, WORK, caller, void

__all__ = ["EVALUATION", "PROGRAM", "Program", "call_evaluation"]


@structure
class Program(NamedTuple):
    """What is the same in all evaluations of a system.

    Kernels are numbers, their addresses, because function objects would be inspected one by one in every call from
    Python.
    """

    place: Integers
    """address of the kernel of every kind of body that places its markers"""
    inertia: Integers
    """the same, that writes its part of the equations of motion"""
    energy: Integers
    """the same, that adds its energies"""
    equations: Integers
    """address of the kernel of every kind of equation"""
    forces: Integers
    """address of the kernel of every kind of force"""
    raw: Bytes
    """all record tables"""
    starts: Integers
    """(kinds + 1,) where each table begins: bodies, equations, forces"""
    bulk: Floats
    """numbers which rows index"""
    signals: SignalCode
    frames: IntegerRows
    """(nf, 2) first coordinate and velocity of every frame"""
    vectors: IntegerRows
    """(nv, 4) iq, iu and length of plain vectors, and 1 for flexible coordinates in a frame, or INTEGRALS of states"""
    pattern: BlockPattern
    """of the iteration matrix"""
    regularisation: Floats
    """(ng,) added to the diagonal of the multipliers (zero unless equations are dependent), with the sign of
    G M^-1 G^T, so that no pivot vanishes near singular configurations"""
    floor_at: IntegerRows
    """(nf, 2) velocity, and place of its diagonal in the iteration matrix, of bodies without inertia in some freedom"""
    floor: Floats
    """(nf,) what is added there, times the weight of the mass (see `massless`); the residual does not know it"""
    equation_level: Integers
    """(ng,) 0 for a holonomic equation g(q, t) = 0, 1 for one at velocity level, A(q, t) u + rate = 0"""
    branches: int
    """first coordinate that tells branches (see Work); they come after the coordinates of all bodies"""
    evaluation: int
    """address of the machine code of `evaluate`"""


PROGRAM = numba_type(Program)
EVALUATION = void(PROGRAM, STATE, WORK)
"""The signature of the evaluation."""

call_evaluation = caller(EVALUATION)
"""Call the evaluation at an address."""

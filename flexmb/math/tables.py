"""The arrays that kernels work on: record types, the state, the workspace, and the signatures of kernel families.

Every kernel of a kind is compiled for one signature, ``(rows, data, state, work)``, so that the compiled loop over
kinds calls it through a pointer and a new kind needs no change elsewhere:

- ``rows``: the record table of the kind as bytes; the kernel begins with ``rows = raw.view(dtype)``;
- ``data``: the bulk numbers of the kind (modal matrices, curve coefficients), one flat array that rows index;
- ``state``: time, coordinates and sampled signals, read only;
- ``work``: everything an evaluation writes.
"""

from __future__ import annotations

from functools import cached_property
from inspect import Parameter, Signature
from typing import Annotated, Any, NamedTuple

import numpy as np
from numba import types
from numba.core.ccallback import CFunc
from numba.extending import intrinsic

from flexmb.math.energies import Energy
from flexmb.math.kernel_cache import KernelCache
from flexmb.math.kernel_library import KernelCompiler
from flexmb.math.structures import ArrayOf, FloatRows, Floats, Integers, array_type, numba_type, structure
from flexmb.math.weights import Weights

__all__ = [
    "BYTES",
    "CHOICE",
    "COUNT",
    "DAMPED",
    "DIRECT",
    "EQUATION",
    "FLOATS",
    "INTEGERS",
    "INTEGRALS",
    "LEG",
    "MARKER",
    "NUMBER",
    "PAIR",
    "ROW_KERNEL",
    "STATE",
    "STIFF",
    "WORK",
    "PointerKernel",
    "State",
    "Work",
    "call_row_kernel",
    "caller",
    "pointer_kernel",
    "row_kernel",
    "void",
]

MARKER = np.dtype(
    [
        ("r", float, 3),  # m, position in W
        ("R", float, (3, 3)),  # marker axes in W
        ("v", float, 3),  # m/s, in W
        ("w", float, 3),  # rad/s, in W
        ("bias", float, 6),  # acceleration (m/s2, rad/s2, in W) at zero generalised acceleration
        ("wrench", float, 6),  # N, N m, in W, acting on the body at the marker
        ("body", np.int64),  # number of the body
        ("iu", np.int64),  # first velocity that moves the marker
        ("nu", np.int64),  # number of velocities that move the marker (0: ground)
        ("width", np.int64),  # how many of them make a block of the iteration matrix
        ("iJ", np.int64),  # first number of the Jacobian (6, nu) in work.J: twist in W = J u
        ("iH", np.int64),  # first number of d(modal force)/d(wrench in W) (6, nu) in work.H, or -1
    ],
    align=True,
)
"""Marker kinematics: the only thing a joint, force or sensor sees of a body."""

EQUATION = np.dtype(
    [
        ("g", float),  # residual of the constraint (m or rad)
        ("rate", float),  # partial derivative of g with respect to time
        ("drift", float),  # g'' = G u' + drift
        ("force", float),  # multiplier lam as evaluated: G^T lam acts on the bodies
        ("leg", np.int64),  # first leg
        ("legs", np.int64),  # number of legs
        ("diagonal", np.int64),  # position of the diagonal entry in work.S
    ],
    align=True,
)
"""One scalar constraint equation: g(q, t) = 0, or at velocity level A(q, t) u + rate = 0 with its residual in g."""

LEG = np.dtype(
    [
        ("gradient", float, 6),  # derivative of g with respect to the marker's twist in W
        ("slope", float, 6),  # of a velocity-level equation: derivative of its residual with respect to displacement
        ("push", float, 6),  # derivative of the marker's wrench by the multiplier, beyond the gradient (friction)
        ("marker", np.int64),
        ("equation", np.int64),
        ("iS", np.int64),  # first entry in work.transposed of the positions of G, one for every block of velocities
        ("iT", np.int64),  # first entry in work.transposed of the positions of G^T
    ],
    align=True,
)
"""One marker's part in one equation."""

PAIR = np.dtype(
    [
        ("K", float, (12, 12)),  # -d(wrench on a, wrench on b)/d(displacement of a, of b), in W
        ("D", float, (12, 12)),  # -d(wrenches)/d(twists), in W
        ("a", np.int64),
        ("b", np.int64),
        ("iS", np.int64),  # first entry in work.pair_rows of the positions of aa, ab, ba, bb (or ab): by row, by block
        ("active", np.int64),  # STIFF if kernels write K, DAMPED if also D, 0 if neither, less if they write to S
    ],
    align=True,
)
"""Two markers between which wrenches depend on relative position or velocity."""

STIFF, DAMPED, DIRECT, ONE_WAY = 1, 2, -1, -2
"""What kernels write of a pair: stiffness only (constraints), stiffness and damping (forces), or nothing, because they
write to the iteration matrix at its places themselves (rates of states); of a pair that is one-way the rows of a in the
columns of b alone have places."""


INTEGRALS = 2
"""What marks, among the plain vectors of a program, the integrals of first-order states."""


@structure
class State(NamedTuple):
    """What an evaluation reads: time, coordinates and sampled signals."""

    t: float
    """s"""
    q: Floats
    """(nq,) configuration"""
    u: Floats
    """(nu,) velocity"""
    a: Floats
    """(nu,) acceleration"""
    lam: Floats
    """(ng,) multipliers"""
    signals: FloatRows
    """(ns, 3) value, rate and second rate of every signal"""


@structure
class Work(NamedTuple):
    """What an evaluation writes."""

    markers: Annotated[np.ndarray, ArrayOf(MARKER)]
    J: Floats
    """Jacobians of the markers, flat"""
    H: Floats
    """d(modal force)/d(wrench) of the markers that have it, flat"""
    equations: Annotated[np.ndarray, ArrayOf(EQUATION)]
    legs: Annotated[np.ndarray, ArrayOf(LEG)]
    pairs: Annotated[np.ndarray, ArrayOf(PAIR)]
    residual: Floats
    """(nu,) M a - forces - G^T lam"""
    S: Floats
    """values of the iteration matrix in the pattern of its factors"""
    rows: Integers
    """(nu + couplings,) position in S of the first entry of each velocity's own block in its row; then, for each
    coupling of two blocks of a body, those of the first block's rows in the columns of the second, and the reverse"""
    transposed: Integers
    """positions in S, see LEG"""
    pair_rows: Integers
    """positions in S, see PAIR"""
    branches: Floats
    """(nb,) which of several solutions a kernel has taken: the angle of a joint with all its full turns, the place on a
    curve. A kernel takes the one nearest to the last coordinates of the state, q[nq - nb:], so an evaluation has no
    history; whoever accepts a state writes them there (`keep_branches`)"""
    weights: Annotated[np.ndarray, ArrayOf(Weights.dtype)]
    """one row: what is to be made of S"""
    energy: Annotated[np.ndarray, ArrayOf(Energy.dtype)]
    """one row: sums over all parts"""
    loads: Floats
    """(nl,) amount of each load shape"""
    channels: FloatRows
    """(nc, 6) derivative of a wrench on a marker by a signal that follows measurements; written by the force"""


FLOATS, INTEGERS, BYTES = np.dtype(float), np.dtype(np.int64), np.dtype(np.uint8)
NUMBER, COUNT, CHOICE = types.float64, types.int64, types.boolean
void = types.void


STATE, WORK = numba_type(State), numba_type(Work)
ROW_KERNEL = void(array_type(BYTES), array_type(FLOATS), STATE, WORK)
"""The signature of every row kernel."""


class PointerKernel:
    """A function compiled to one signature when it is first needed, and called through its address.

    Its machine code is made once: a caller that is compiled holds a call, not a copy to be optimised again.
    """

    def __init__(self, function, signature):
        self.function, self.signature = function, signature
        self.__doc__ = function.__doc__

    @cached_property
    def _declared(self) -> Any:
        signature = self.signature.args, self.signature.return_type
        options = {"error_model": "numpy"}
        code: Any = CFunc(self.function, signature, locals={}, options=options, pipeline_class=KernelCompiler)
        code._cache = KernelCache(self.function, {**options, "called_through": "pointer"})
        return code

    @cached_property
    def compiled(self) -> Any:
        """The machine code, from the cache on disk if it is there."""
        self._declared.compile()
        return self._declared

    def is_missing(self) -> bool:
        """Is there no machine code of it, here or on disk?"""
        code = self._declared
        return code.native_name is None and not code._cache.holds(code._sig, code._targetdescr.target_context)

    def is_being_compiled(self) -> bool:
        """Is a process compiling it?"""
        code = self._declared
        return code._cache.is_being_compiled(code._sig, code._targetdescr.target_context)


def row_kernel(function) -> PointerKernel:
    """Declare a row kernel ``(raw, data, state, work) -> None``."""
    return PointerKernel(function, ROW_KERNEL)


def pointer_kernel(signature):
    """Declare a kernel of another signature that is called through its address."""
    return lambda function: PointerKernel(function, signature)


def caller(signature):
    """Return a function for kernels, ``call(address, ...)``, that calls the function of this signature at an
    address.
    """

    def call(context, address, *arguments):
        def generate(target, builder, _, values):
            prototype = types.FunctionType(signature).ftype
            builder.call(builder.inttoptr(values[0], target.get_value_type(prototype)), values[1:])
            return target.get_dummy_value()

        return types.void(types.int64, *signature.args), generate

    # named one by one: a variable number of arguments would be packed into a tuple, and every array in it counted
    names = ["context", "address", *(f"argument_{k}" for k in range(len(signature.args)))]
    call.__signature__ = Signature([Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in names])
    return intrinsic(call)


call_row_kernel = caller(ROW_KERNEL)
"""Call the row kernel at an address."""

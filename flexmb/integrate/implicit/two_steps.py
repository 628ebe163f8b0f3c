"""Weights by which the rates of two steps of `Implicit` tell the local error of the second.

An error of order five has a part for each tree of five nodes. Stages satisfy A c = c^2 / 2, so four are different:
those of c^4, c A c^2, A c^3 and A A c^2. Six stages of one step tell the last, all there is in linear equations. The
stages of this step and those of the one before tell all four, and of their weights the least are taken. Very short
steps between them, to a sample, tell nothing, and are taken as one: three steps are one of a method of 18 stages.
Source: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 2nd ed. 1993, sec. II.2 (trees).
"""

from __future__ import annotations

import numpy as np

from flexmb.integrate.implicit.stages import STAGES, WEIGHTS
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["ALL", "KEPT", "LONGER", "SHORTER", "TREES", "weights_of_two"]

SHORTER, LONGER = 0.2, 5.0
"""Size of the step before, relative to this one, between which two steps are asked: beyond, the weights are large, or
this step is very short."""
KEPT = STAGES - 1
"""Stages of the step before that are asked: all but its last."""


def _errors() -> np.ndarray:
    """Return what a step from 0 to 1 errs by (9,), by tree, in the order of `_rows`."""
    A, c = WEIGHTS, WEIGHTS.sum(axis=1)
    square = A @ c**2
    trees = np.array([c**0, c, c**2, c**3, square, c**4, c * square, A @ c**3, A @ square])
    errors = trees @ A[-1] - 1.0 / np.array([1.0, 2.0, 3.0, 4.0, 12.0, 5.0, 15.0, 20.0, 60.0])
    errors[:5] = 0.0  # but for rounding
    return errors


ERRORS = _errors()
TREES, ALL = len(ERRORS), 3 * STAGES


@inner_kernel
def _after(weights, sizes, v, out):
    """Write A v (18,) of three steps as one."""
    whole = 0.0
    for step in range(len(sizes)):
        first, end = step * STAGES, 0.0
        for i in range(STAGES):
            end = 0.0
            for j in range(STAGES):
                end += sizes[step] * weights[i, j] * v[first + j]
            out[first + i] = whole + end
        whole += end  # the last stage is the end of the step


@inner_kernel
def _rows(weights, sizes, C):
    """Write 1, c, c^2, c^3, A c^2, c^4, c A c^2, A c^3, A A c^2 of all stages to the rows of C (9, 18)."""
    for i in range(ALL):
        C[0, i] = 1.0
    _after(weights, sizes, C[0], C[1])
    for i in range(ALL):
        c = C[1, i]
        C[2, i], C[3, i], C[5, i] = c * c, c * c * c, c * c * c * c
    _after(weights, sizes, C[2], C[4])
    for i in range(ALL):
        C[6, i] = C[1, i] * C[4, i]
    _after(weights, sizes, C[3], C[7])
    _after(weights, sizes, C[4], C[8])


@kernel
def weights_of_two(weights, sizes, C, w):
    """Write weights w (18,): their sum with h times the rates of the stages is the error of the last step, of size h.

    sizes : (3,) of the step before, of what is between and of the last step, relative to h; those of the second have no
    weight, and neither has the last of the first, whose rate is about that with which the last begins. C (9, 18) is
    scratch.
    """
    _rows(weights, sizes, C)
    for i in range(ALL):
        w[i] = 0.0
    for k in range(TREES):
        for i in range(KEPT, 2 * STAGES):
            C[k, i] = 0.0
        error = ERRORS[k]
        for j in range(k):  # rows before are orthonormal by now: Gram and Schmidt, w is a sum of them
            along, known = 0.0, 0.0
            for i in range(ALL):
                along += C[j, i] * C[k, i]
                known += C[j, i] * w[i]
            for i in range(ALL):
                C[k, i] -= along * C[j, i]
            error -= along * known
        size = 0.0
        for i in range(ALL):
            size += C[k, i] * C[k, i]
        size = size**0.5
        for i in range(ALL):
            C[k, i] /= size
            w[i] += error / size * C[k, i]

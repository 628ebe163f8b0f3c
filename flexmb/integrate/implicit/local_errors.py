"""The local errors of implicit Runge-Kutta steps, as the stages of each step, or of two, tell them."""

from __future__ import annotations

import numpy as np

from flexmb.integrate.implicit.stages import STAGES, WEIGHTS
from flexmb.integrate.implicit.two_steps import KEPT, LONGER, SHORTER, weights_of_two
from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["SEEN", "keep_rates", "take_off_errors"]

LINEAR = -8.463541666666567e-4
"""Error of a step of y' = f(y) by h^5 times the fifth derivative of y, for linear f."""


def _fifth() -> np.ndarray:
    """Return the weights (6,) by which the rates of the stages give h^4 times the fifth derivative of y in one step.

    The stages of y' = z y are those of (I - z A)^-1: powers of z up to three cancel and the fourth is one; and so do
    third powers of time in rates that are given. There are as many weights as these conditions.
    """
    rows = [np.ones(STAGES)]
    for _ in range(4):
        rows.append(WEIGHTS @ rows[-1])
    rows.append(rows[1] ** 3)
    return np.linalg.solve(rows, [0.0, 0.0, 0.0, 0.0, 1.0, 0.0])


ALONE = _fifth()
BESIDE = (3.6, 4.7, 8.0)
"""Error of order five beside what the embedded method differs by: of a vibration by 1.2 and by 2 radians a step, and of
one that steps do not follow."""
COARSE = 4.0
"""By how much the error is larger than that of linear equations at two radians a step: a heavy top errs 1.0 times as
much at 1.2 radians, 1.7 at 1.4, 4.1 at 2."""
FADES = 0.9
"""Part of the size of a step that still counts a step later: what swings passes zero."""
SHORT = 0.5
"""Size of a step, relative to the one before, below which that one is kept for the next."""
SEEN = 3
"""Steps after which that size is known."""


@inner_kernel
def _differ(weights, third, r, b, h):
    """Return the square of what the embedded method of order three differs by in the rates, the largest of late."""
    size = 0.0
    for i in range(b.own[0].moving):
        apart = 0.0
        for j in range(STAGES):
            apart += (weights[STAGES - 1, j] - third[j]) * r.A[j, i]
        size += b.free[i] * (h * apart) ** 2
    b.own[0].size = max(size, FADES * b.own[0].size)
    return b.own[0].size


@kernel
def keep_rates(r, b, h):
    """Keep the rates of a step for the next one; those of a very short one say nothing to a longer one."""
    own = b.own[0]
    if h < SHORT * own.before and own.passed + h < own.before:
        b.own[0].passed += h
        return
    b.own[0].before, b.own[0].passed = h, 0.0
    for j in range(KEPT):
        for i in range(len(b.dv)):
            b.A[j, i] = r.A[j, i]
        for i in range(len(b.dx)):
            b.K[j, i] = r.K[j, i]


@inner_kernel
def _by_one(r, b, h):
    """Write the error of order five of linear equations to b.change and b.k, as the stages of the step tell it."""
    for i in range(len(b.dv)):
        fifth = 0.0
        for j in range(STAGES):
            fifth += ALONE[j] * r.A[j, i]
        b.change[i] = b.free[i] * LINEAR * h * fifth
    for i in range(len(b.dx)):
        fifth = 0.0
        for j in range(STAGES):
            fifth += ALONE[j] * r.K[j, i]
        b.k[i] = LINEAR * h * fifth


@inner_kernel
def _summed(w, before, now, i):
    """Return the sum of weights (18,) with rates of the stages of the step before and of this one, one coordinate."""
    total = 0.0
    for j in range(KEPT):
        total += w[j] * before[j, i]
    for j in range(STAGES):
        total += w[2 * STAGES + j] * now[j, i]
    return total


@inner_kernel
def _by_two(r, b, h, weights):
    """Write that of any equations, as the stages of this step and of the one before tell it."""
    b.sizes[0], b.sizes[1], b.sizes[2] = b.own[0].before / h, b.own[0].passed / h, 1.0
    weights_of_two(weights, b.sizes, b.trees, b.w)
    for i in range(len(b.dv)):
        b.change[i] = b.free[i] * h * _summed(b.w, b.A, r.A, i)
    for i in range(len(b.dx)):
        b.k[i] = h * _summed(b.w, b.K, r.K, i)


@inner_kernel
def _size(b):
    """Return the square of the local error of the rates."""
    size = 0.0
    for i in range(b.own[0].moving):
        size += b.change[i] ** 2
    return size


@kernel
def take_off_errors(r, b, h, weights, third):
    """Take the local error of a step off the motion beside."""
    low, high, most = BESIDE
    differs = _differ(weights, third, r, b, h)
    seen = b.own[0].steps > SEEN and differs > 0.0
    two = SHORTER * h <= b.own[0].before <= LONGER * h
    if two:
        _by_two(r, b, h, weights)
        two = not seen or _size(b) <= most**2 * differs
    if not two:
        _by_one(r, b, h)
    size = _size(b)
    if seen and not size <= most**2 * differs:
        b.own[0].stiff += 1
        return
    long = ((size / differs) ** 0.5 - low) / (high - low) if seen and not two else 0.0
    times = 1.0 + (COARSE - 1.0) * min(max(long, 0.0), 1.0)
    given_x, given_v = 0.0, 0.0
    for i in range(len(b.dv)):
        b.dv[i] -= times * b.change[i]
        given_v += b.change[i] ** 2 if i < b.own[0].moving else 0.0
    for i in range(len(b.dx)):
        b.dx[i] -= times * b.k[i]
        given_x += b.k[i] ** 2 if i < len(b.dx) - len(b.dv) + b.own[0].moving else 0.0
    b.own[0].given_x += times * given_x**0.5
    b.own[0].given_v += times * given_v**0.5

"""What the trapezoidal rule leaves out of the distance that is carried beside a run of implicit Runge-Kutta steps."""

from __future__ import annotations

from flexmb.math.kernel import inner_kernel, kernel

__all__ = ["straightened"]

STRAIGHT = 0.1
"""Largest correction of the trapezoidal rule, relative to the distance."""
STIFF = 1.0
"""The same from which the distance swings or dies away too fast to be carried."""
TURNED = 1.3
"""Radians of a vibration in a step up to which the correction, brought forward by the parabola through three of them,
makes nothing grow: the distance keeps 1 - 0.0065 w^6 of a vibration by w, grows from 1.36 on, and by 19 % at 2."""
FADES = 0.9
"""Part of the size of a step that still counts a step later: what swings passes zero."""


@inner_kernel
def _forward(h, before, earlier):
    """Return the weights by which values in the middle of this step, of the one before and of the one before that give
    the value at the end of this step; sizes of steps are 0 where there was none.
    """
    if before <= 0.0:
        return 1.0, 0.0, 0.0
    here, back = 0.5 * h, h + 0.5 * before
    if earlier <= 0.0:
        return back / (back - here), -here / (back - here), 0.0
    far = h + before + 0.5 * earlier
    return (
        back * far / ((back - here) * (far - here)),
        -here * far / ((back - here) * (far - back)),
        here * back / ((far - here) * (far - back)),
    )


@inner_kernel
def _slow(b):
    """Return if what bends is resolved: second rates of a vibration by w bend by 4 sin^2(w/4), turn by 2 sin(w/2)."""
    bends, turns = 0.0, 0.0
    for i in range(b.own[0].moving):
        bends += b.kv[i] ** 2
        turns += (b.da[i] - b.a0[i]) ** 2
    b.own[0].bends = max(bends, FADES * b.own[0].bends)
    b.own[0].turns = max(turns, FADES * b.own[0].turns)
    return 16.0 * b.own[0].bends <= TURNED**2 * b.own[0].turns


@inner_kernel
def _swings(b):
    """Return if the distance itself is mostly one of vibrations that are too fast for the correction."""
    turns, size = 0.0, 0.0
    for i in range(len(b.dx) - len(b.dv) + b.own[0].moving):
        turns += (b.dx[i] - b.x0[i]) ** 2
        size += b.dx[i] ** 2
    b.own[0].swings = max(turns, FADES * b.own[0].swings)
    b.own[0].spread = max(size, FADES * b.own[0].spread)
    return b.own[0].swings > TURNED**2 * b.own[0].spread


@kernel
def straightened(b, h):
    """Correct the distance by what the trapezoidal rule leaves out, h / 12 (2 f(1/2) - f(0) - f(1)) (Simpson's rule).

    It is known for the middle of the step, and wanted for its end: without that shift in time it would make
    vibrations grow. Where it is large, or most of it belongs to vibrations that it would make grow even so, it is left
    out: the rule alone keeps their size. Returns whether the distance could be carried at all.
    """
    slow, by = _slow(b), h**-2
    now, before, earlier = _forward(h, b.own[0].bent, b.own[0].bent_before)
    change, size = 0.0, 0.0
    for i in range(len(b.dv)):
        k = by * b.kv[i]
        b.kv[i] = h**3 / 12.0 * (now * k + before * b.bv[i] + earlier * b.cv[i])
        b.cv[i], b.bv[i] = b.bv[i], k
        if i < b.own[0].moving:
            change, size = change + b.kv[i] ** 2, size + b.dv[i] ** 2
    for i in range(len(b.dx)):
        k = by * b.kx[i]
        b.kx[i] = h**3 / 12.0 * (now * k + before * b.bx[i] + earlier * b.cx[i])
        b.cx[i], b.bx[i] = b.bx[i], k
    fast = _swings(b) and not slow  # the rule alone lags behind it: its size is kept, how it adds up is not known
    followed = b.own[0].bent > 0.0
    b.own[0].bent_before, b.own[0].bent = b.own[0].bent, h
    if followed and slow and change <= STRAIGHT**2 * size:
        for i in range(len(b.dv)):
            b.dv[i] += b.kv[i]
        for i in range(len(b.dx)):
            b.dx[i] += b.kx[i]
    if followed and fast:
        b.own[0].stiff += 1
    b.own[0].wide = max(size, FADES * b.own[0].wide)
    return not followed or change <= STIFF**2 * b.own[0].wide

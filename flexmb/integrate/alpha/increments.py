"""The end of a step of the generalized-alpha method: its configuration, and a correction of all that belongs to it."""

from __future__ import annotations

from flexmb.integrate.alpha.world_translation import move, to_body_axes, to_increment
from flexmb.math.block_substitution import lu_solve
from flexmb.math.kernel import inner_kernel
from flexmb.system.program import advance

__all__ = ["correct", "move_to_end", "solve_for_increment"]


@inner_kernel
def move_to_end(program, v, h):
    """Write the configuration at the end of the step; a joint may turn any number of times in a step."""
    advance(program, v.q, v.dx, 1.0, v.q1)
    move(v.world, v.q, v.dx, v.q1)
    for k in range(len(v.pace)):
        v.q1[program.branches + k] += h * v.pace[k]
    to_body_axes(v.world, v.q1, v.u1, v.a1, v.body_u, v.body_a)


@inner_kernel
def solve_for_increment(program, work, v, c, h, scale):
    """Write the Newton correction to `right`, from the residual and equations of the last evaluation."""
    nu = len(v.u)
    for i in range(nu):
        v.right[i] = -scale * work.residual[i]
    for i in range(len(v.lam)):
        # a velocity-level equation per displacement: u1 varies gamma / (beta h) times as much as the increment
        v.right[nu + i] = -work.equations[i].g * (c.beta * h / c.gamma if program.equation_level[i] == 1 else 1.0)
    lu_solve(work.S, program.pattern, v.right)
    to_increment(program.frames, v.world, v.q1, v.dx, v.right)


@inner_kernel
def correct(program, v, c, h, scale):
    """Add the Newton correction `right` (of the increment over the step, and c times the multipliers)."""
    nu = len(v.u)
    for i in range(nu):
        v.d[i] = v.right[i]
    for i in range(nu):
        v.dx[i] += v.d[i]
        v.a1[i] += v.d[i] / scale
        v.u1[i] += v.d[i] * c.gamma / (c.beta * h)
        v.alg1[i] += v.d[i] / (c.beta * h * h)
    for i in range(len(v.lam)):
        v.lam1[i] += v.right[nu + i] / scale
    move_to_end(program, v, h)

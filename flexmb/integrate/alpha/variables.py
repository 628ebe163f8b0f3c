"""State, scratch and parameters of the compiled generalized-alpha steps."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np

from flexmb.integrate.runs.gap import Gap
from flexmb.integrate.runs.switching import Switching
from flexmb.math.structures import ArrayOf, FloatRows, Floats, IntegerRows, Record, structure

__all__ = ["COUNTED", "AlphaRun", "Apart", "Controls", "Motions", "Variables"]


class AlphaRun(Record):
    """How far a run is, and how it goes on."""

    t: float
    """s"""
    next_step: float
    """s"""
    last_step: float
    """s, since the accelerations `a_last`"""
    short: float
    """s, part of it in steps too short to tell a rate"""
    size: float
    """s, of the last step"""
    longest_step: float
    """s"""
    span: float
    """s, of the run"""
    convergence: float
    """rate of the iteration with a fresh matrix"""
    rounding: float
    """m, of positions"""
    since_look: float
    """steps since powers were last evaluated after the last correction of one"""
    looked_at: float
    """`rough` of that step"""
    first_state: int
    """velocities from here on are first-order states"""
    rough: int
    """corrections of a step, if the last has changed velocities or states noticeably; else 0"""
    compared: int
    """of the motion without local errors: steps until its reactions were compared with the run's"""
    steps: int
    iterations: int
    factorisations: int
    rejected_by_error: int
    rejected_by_iteration: int
    cut_at_contacts: int


COUNTED = (
    "steps",
    "iterations",
    "factorisations",
    "rejected_by_error",
    "rejected_by_iteration",
    "cut_at_contacts",
)
"""What the statistics of a run tell."""


@structure
class Variables(NamedTuple):
    """State and scratch of the integration."""

    q: Floats
    """(nq,) configuration at the step's start"""
    u: Floats
    """(nu,) velocity"""
    a: Floats
    """(nu,) acceleration"""
    lam: Floats
    """(ng,) multipliers"""
    alg: Floats
    """(nu,) algorithmic acceleration"""
    q1: Floats
    """(nq,) the same at its end, as the next four"""
    u1: Floats
    a1: Floats
    lam1: Floats
    alg1: Floats
    dx: Floats
    """(nu,) increment over the step"""
    d: Floats
    """(nu,) scratch"""
    right: Floats
    """(nu + ng,) scratch"""
    a_last: Floats
    """(nu,) acceleration at the start of the previous step (of those that tell a rate), for the prediction"""
    lam_last: Floats
    """(ng,) multipliers there"""
    hidden: Floats
    """(ng,) rate of the constraints at the step's start"""
    slope: Floats
    """(nu,) distance of the algorithmic acceleration from the true one, per step size"""
    curve: Floats
    """(ng,) rate of the constraints that a step leaves, per square of its size"""
    change: Floats
    """(nu,) of the velocities, with the step size"""
    extent: Floats
    """(nu,) m, length that makes an increment a displacement (radius of gyration for rotations); of states 1/s: what
    makes an increment of their integral one of themselves, in a step of this size"""
    reach: Floats
    """(nu,) m, displacement to which tolerances are relative"""
    works: Floats
    """(3,) J, work of loads, of drives, dissipated energy"""
    powers: Floats
    """(3,) W, their rates"""
    powers_last: Floats
    """(3,) W, a step before"""
    lacking: Floats
    """(3,) W/s^3, what powers before the last correction of a step lack, see `flexmb.integrate.alpha.powers`"""
    signals: FloatRows
    run: Annotated[np.ndarray, ArrayOf(AlphaRun.dtype)]
    """one row: how far it is, and how it goes on"""
    pace: Floats
    """(nb,) rate of the branches (turns, places on curves) over the last step, by which they are followed"""
    world: IntegerRows
    """(n, 2) frames whose u, a, alg, dx have translations in world axes"""
    body_u: Floats
    """(nu,) u1 with all in body axes"""
    body_a: Floats
    """(nu,) a1, likewise"""
    switching: Switching
    axes: FloatRows
    """(frames, AXIS) errors of the axes of spinning bodies, see `flexmb.integrate.runs.spin_axes`"""


@structure
class Apart(NamedTuple):
    """What the local errors of the steps have added up to."""

    dx: Floats
    """(nu,) local error of the increment of the last step"""
    du: Floats
    """(nu,) of the velocity"""
    q: Floats
    """(nq,) distance of the configurations at the start of the step"""
    u: Floats
    """(nu,) of the velocities"""
    a: Floats
    """(nu,) of the accelerations"""
    second: Floats
    """(ng,) second rates of the constraints at the end of the step"""
    early: Floats
    """(ng,) by how much those with algorithmic accelerations lie ahead"""
    earlier: Floats
    """(ng,) the same of the motion beside"""
    x: Floats
    """(nu,) scratch, as the next"""
    y: Floats
    q_start: Floats
    """(nq,) configuration from which motion is counted"""
    reactions: FloatRows
    """(ng, 4) see `flexmb.integrate.runs.reaction_errors`"""
    run: Annotated[np.ndarray, ArrayOf(Gap.dtype)]
    """one row"""


@structure
class Motions(NamedTuple):
    """The motion of a run, and beside it the one without the local errors that are known."""

    own: Variables
    corrected: Variables
    apart: Apart

    @property
    def switching(self) -> Switching:
        """The switches of the run."""
        return self.own.switching


@structure
class Controls(NamedTuple):
    """Parameters of the method."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    tolerance: float
    """of the error of a step"""
    of_axes: float
    """part of the motion of an axis that errors which add up may be"""
    newton: float
    """of the iteration, relative to that"""
    settled: float
    """of the accelerations, relative to the largest one"""
    adaptive: bool
    smallest: float
    """s, step size at which a run ends"""
    iterations: int
    sweeps: int
    """to solve for the accelerations of samples, 0: of the step"""
    friction: bool
    """forces depend on the multipliers, or on accelerations"""
    trend: float
    """1.0 if multipliers are predicted by their trend, 0.0 where dependent equations leave a part of them to chance,
    which would grow by it from step to step"""

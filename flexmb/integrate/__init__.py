"""Analyses: what happens to a system over time, and about a state."""

from flexmb.integrate.accelerations import Accelerations, accelerations
from flexmb.integrate.alpha.generalized_alpha import GeneralizedAlpha
from flexmb.integrate.check import Report, check
from flexmb.integrate.disturbed import disturbed
from flexmb.integrate.equations_of_motion import EquationsOfMotion, equations
from flexmb.integrate.equilibria.load_path import ArcLength, LimitPoint, LoadPath, LoadSteps
from flexmb.integrate.equilibria.statics import statics
from flexmb.integrate.explicit.explicit import Explicit
from flexmb.integrate.formulations import Augmented, Baumgarte, NullSpace, UdwadiaPhohomsiri
from flexmb.integrate.ida.ida import IDA
from flexmb.integrate.implicit.implicit import Implicit
from flexmb.integrate.kinematics import inverse_dynamics, kinematics
from flexmb.integrate.linear.campbell import Campbell, campbell
from flexmb.integrate.linear.first_frequencies import FirstFrequencies, first_frequencies
from flexmb.integrate.linear.linearize import Linearization, linearize
from flexmb.integrate.linear.mode_motion import mode_motion
from flexmb.integrate.linear.plant import Plant
from flexmb.integrate.linear.random_loads import spectral_response, variances
from flexmb.integrate.linear.root_locus import RootLocus, root_locus
from flexmb.integrate.nonsmooth.moreau_jean import MoreauJean
from flexmb.integrate.runs.ahead_of_run import compile_ahead_of_kinds
from flexmb.integrate.runs.family import Family
from flexmb.integrate.runs.impact import Impulse, impulses
from flexmb.integrate.runs.resume import resume
from flexmb.integrate.runs.simulate import simulate
from flexmb.integrate.runs.stepper import Stepper, stepper
from flexmb.model.methods import Integrator
from flexmb.model.registered import registered
from flexmb.tree import Recursive

KINDS = registered(globals(), Integrator)
"""All integrators by name: read by the model files."""
FORMULATIONS = {kind.__name__: kind for kind in (Augmented, NullSpace, UdwadiaPhohomsiri, Recursive, Baumgarte)}
"""All formulations that an integrator may have, by name: read by the model files."""

__all__ = [
    "FORMULATIONS",
    "KINDS",
    *KINDS,
    "Accelerations",
    "ArcLength",
    "Augmented",
    "Baumgarte",
    "Campbell",
    "EquationsOfMotion",
    "Family",
    "FirstFrequencies",
    "Impulse",
    "LimitPoint",
    "Linearization",
    "LoadPath",
    "LoadSteps",
    "NullSpace",
    "Plant",
    "Report",
    "RootLocus",
    "Stepper",
    "UdwadiaPhohomsiri",
    "accelerations",
    "campbell",
    "check",
    "compile_ahead_of_kinds",
    "disturbed",
    "equations",
    "first_frequencies",
    "impulses",
    "inverse_dynamics",
    "kinematics",
    "linearize",
    "mode_motion",
    "resume",
    "root_locus",
    "simulate",
    "spectral_response",
    "statics",
    "stepper",
    "variances",
]

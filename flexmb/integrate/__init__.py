"""Analyses: what happens to a system over time, and about a state."""

from flexmb.integrate.accelerations import Accelerations, accelerations
from flexmb.integrate.campbell import Campbell, campbell
from flexmb.integrate.check import Report, check
from flexmb.integrate.disturbed import disturbed
from flexmb.integrate.equations_of_motion import EquationsOfMotion, equations
from flexmb.integrate.explicit import Explicit
from flexmb.integrate.first_frequencies import FirstFrequencies, first_frequencies
from flexmb.integrate.formulations import Augmented, Baumgarte, NullSpace, UdwadiaPhohomsiri
from flexmb.integrate.generalized_alpha import GeneralizedAlpha
from flexmb.integrate.ida import IDA
from flexmb.integrate.impact import Impulse, impulses
from flexmb.integrate.implicit import Implicit
from flexmb.integrate.kinematics import inverse_dynamics, kinematics
from flexmb.integrate.linearize import Linearization, linearize
from flexmb.integrate.load_path import ArcLength, LimitPoint, LoadPath, LoadSteps
from flexmb.integrate.mode_motion import mode_motion
from flexmb.integrate.plant import Plant
from flexmb.integrate.resume import resume
from flexmb.integrate.simulate import simulate
from flexmb.integrate.statics import statics
from flexmb.model.methods import Integrator
from flexmb.model.registered import registered

KINDS = registered(globals(), Integrator)
"""All integrators by name: read by the model files."""

__all__ = [
    "KINDS",
    *KINDS,
    "Accelerations",
    "ArcLength",
    "Augmented",
    "Baumgarte",
    "Campbell",
    "EquationsOfMotion",
    "FirstFrequencies",
    "Impulse",
    "LimitPoint",
    "Linearization",
    "LoadPath",
    "LoadSteps",
    "NullSpace",
    "Plant",
    "Report",
    "UdwadiaPhohomsiri",
    "accelerations",
    "campbell",
    "check",
    "disturbed",
    "equations",
    "first_frequencies",
    "impulses",
    "inverse_dynamics",
    "kinematics",
    "linearize",
    "mode_motion",
    "resume",
    "simulate",
    "statics",
]

"""Analyses: what happens to a system over time, and about a state."""

from flexmb.integrate.check import Report, check
from flexmb.integrate.generalized_alpha import GeneralizedAlpha
from flexmb.integrate.simulate import simulate

__all__ = ["GeneralizedAlpha", "Report", "check", "simulate"]

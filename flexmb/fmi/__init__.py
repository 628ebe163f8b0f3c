"""Functional mock-up units (FMI): mechanisms as parts of other programs' simulations."""

from flexmb.fmi.cosimulation import Fmu, cosimulate
from flexmb.fmi.export import ports, write_fmu

__all__ = ["Fmu", "cosimulate", "ports", "write_fmu"]

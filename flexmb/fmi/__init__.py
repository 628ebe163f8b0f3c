"""Functional mock-up units (FMI): mechanisms as parts of other programs' simulations, and the other way round."""

from flexmb.fmi.cosimulation import Fmu, cosimulate
from flexmb.fmi.export import ports, write_fmu
from flexmb.fmi.model_exchange import ModelExchange

__all__ = ["Fmu", "ModelExchange", "cosimulate", "ports", "write_fmu"]

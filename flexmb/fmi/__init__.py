"""Functional mock-up units (FMI): mechanisms as parts of other programs' simulations."""

from flexmb.fmi.export import ports, write_fmu

__all__ = ["ports", "write_fmu"]

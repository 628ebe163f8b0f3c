"""Finite elements: every way to arrive at an `FEModel`."""

from flexmb.fem.frame import frame
from flexmb.fem.section import Section

__all__ = ["Section", "frame"]

"""Finite elements: every way to arrive at an `FEModel`."""

from flexmb.fem.connectors import with_mass, with_spring, with_supports
from flexmb.fem.frame import frame
from flexmb.fem.links import with_averaging_link, with_node, with_rigid_link
from flexmb.fem.section import Section

__all__ = [
    "Section",
    "frame",
    "with_averaging_link",
    "with_mass",
    "with_node",
    "with_rigid_link",
    "with_spring",
    "with_supports",
]

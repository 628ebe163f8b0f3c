"""Finite elements: every way to arrive at an `FEModel`."""

from flexmb.fem.connectors import with_mass, with_spring, with_supports
from flexmb.fem.deck import DECK_READERS, DeckChecks, deck_checks, read_deck
from flexmb.fem.fe_model import ElementBlock, FEModel, ReferencePoint
from flexmb.fem.frame import frame
from flexmb.fem.joined import joined
from flexmb.fem.links import with_averaging_link, with_node, with_rigid_link
from flexmb.fem.matrices import from_matrices
from flexmb.fem.mesh import Mesh, MeshWarning
from flexmb.fem.read_matrices import read_matrices, write_matrices
from flexmb.fem.read_mesh import read_mesh
from flexmb.fem.section import Section
from flexmb.fem.shell import shell
from flexmb.fem.solid import solid
from flexmb.fem.solid_elements import HEX8_COMPATIBLE, SolidElement
from flexmb.fem.solve import Modes, buckling, eigenmodes, fixed_freedoms, static
from flexmb.fem.split import split
from flexmb.fem.surface_load import pressure_load, traction_load

__all__ = [
    "DECK_READERS",
    "HEX8_COMPATIBLE",
    "DeckChecks",
    "ElementBlock",
    "FEModel",
    "Mesh",
    "MeshWarning",
    "Modes",
    "ReferencePoint",
    "Section",
    "SolidElement",
    "buckling",
    "deck_checks",
    "eigenmodes",
    "fixed_freedoms",
    "frame",
    "from_matrices",
    "joined",
    "pressure_load",
    "read_deck",
    "read_matrices",
    "read_mesh",
    "shell",
    "solid",
    "split",
    "static",
    "traction_load",
    "with_averaging_link",
    "with_mass",
    "with_node",
    "with_rigid_link",
    "with_spring",
    "with_supports",
    "write_matrices",
]
